"""One shape for all errors: of our routes, the framework, a file response, or a bug."""

from __future__ import annotations

import json
import logging
import uuid

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, Response
from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.errors import RETRY_AFTER, ApiError, Busy, error_body
from app.storage.database import storage_failure
from tsr_engine.errors import StorageError, TsrError
from tsr_engine.extras import MissingExtra, missing_extra
from tsr_engine.json_shapes import JsonObject

_log = logging.getLogger("tsr.server")
_CODES = {400: "bad_request", 404: "not_found", 405: "method_not_allowed", 416: "range_not_satisfiable"}


class ErrorShape:
    """ASGI middleware that gives unhandled failures the common error shape.

    It runs inside the guard, so that these responses get the guard's headers too.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one connection."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        started = False
        plain: Message | None = None
        text = b""

        async def shaped(message: Message) -> None:
            nonlocal started, plain, text
            if message["type"] == "http.response.start":
                started = True
                if message["status"] >= 400 and not _is_json(message):
                    plain = message
                    return
            elif plain is not None:
                text += message.get("body", b"")
                if not message.get("more_body", False):
                    await _as_json(plain, text)(scope, receive, send)
                return
            await send(message)

        try:
            await self.app(scope, receive, shaped)
        except Exception as error:
            if started:
                raise  # part of the response has been sent, so the connection can only be aborted
            await _unexpected(Request(scope), error)(scope, receive, send)


def _is_json(start: Message) -> bool:
    return Headers(raw=start["headers"]).get("content-type", "").startswith("application/json")


def _as_json(start: Message, text: bytes) -> Response:
    headers = Headers(raw=start["headers"])
    said = (
        text.decode("utf-8", "replace").strip().rstrip(".") if "text/plain" in headers.get("content-type", "") else ""
    )
    kept = {name: headers[name] for name in ("content-range", "allow", "retry-after") if name in headers}
    body = error_body(_CODES.get(start["status"], "refused"), f"{said or 'The request was refused'}.")
    return JSONResponse(body, status_code=start["status"], headers=kept)


def handle_failures(app: FastAPI) -> None:
    """Register handlers that convert exceptions of routes to responses."""

    @app.exception_handler(ApiError)
    async def _api(_: Request, error: ApiError) -> Response:
        return _error_response(error)

    @app.exception_handler(RequestValidationError)
    async def _invalid(_: Request, error: RequestValidationError) -> Response:
        return JSONResponse(_first_problem(error), status_code=422)

    @app.exception_handler(HTTPException)
    async def _http(_: Request, error: HTTPException) -> Response:
        body = error_body(_CODES.get(error.status_code, "refused"), f"{error.detail}.")
        return JSONResponse(body, status_code=error.status_code, headers=dict(error.headers or {}))

    @app.exception_handler(DBAPIError)
    async def _database(request: Request, error: DBAPIError) -> Response:
        known = storage_failure(error)
        if known is None:
            return _unexpected(request, error)
        return _error_response(known)

    @app.exception_handler(PoolTimeout)
    async def _pool(_: Request, __: PoolTimeout) -> Response:
        return _error_response(
            Busy("Too many requests wait for the database. This one can be repeated.", code="database_busy")
        )

    @app.exception_handler(ModuleNotFoundError)
    async def _module(request: Request, error: ModuleNotFoundError) -> Response:
        known = missing_extra(error)
        return _unexpected(request, error) if known is None else _missing_extra_response(known)

    @app.exception_handler(MissingExtra)
    async def _extra(_: Request, error: MissingExtra) -> Response:
        return _missing_extra_response(error)

    @app.exception_handler(TsrError)
    async def _engine(_: Request, error: TsrError) -> Response:
        status, code = 422, "invalid"
        if isinstance(error, StorageError):
            status, code = 500 if error.kind == "failed" else 507, f"storage_{error.kind}"
        return JSONResponse(error_body(code, str(error)), status_code=status)


def _missing_extra_response(error: MissingExtra) -> Response:
    return JSONResponse(error_body("missing_extra", str(error)), status_code=501)


def _error_response(error: ApiError) -> Response:
    headers = {"Retry-After": RETRY_AFTER} if error.status == 503 else None
    return JSONResponse(error.body(), status_code=error.status, headers=headers)


def _first_problem(error: RequestValidationError) -> JsonObject:
    """One sentence about the first invalid value."""
    first = error.errors()[0]
    place = [str(part) for part in first["loc"] if part not in ("body", "query", "path", "header")]
    if first["type"] == "json_invalid":
        return error_body("invalid", "The body is not JSON.")
    if place[:1] == ["command"] and len(place) > 2:
        del place[1]  # the name of the command, which is in the body
    field = ".".join(place) or (str(first["loc"][0]) if first["loc"] else None)
    reason = first["msg"].removeprefix("Value error, ").rstrip(".")
    return error_body("invalid", f"{field or 'The request'}: {reason[:1].lower()}{reason[1:]}.", field)


def _unexpected(request: Request, error: Exception) -> Response:
    """Answer with an error number; the log has the details under that number."""
    number = uuid.uuid4().hex[:8]
    _log.error("Error %s in %s %s", number, request.method, json.dumps(request.url.path), exc_info=error)
    message = f"Something unexpected went wrong. The server's log has it under {number}."
    return JSONResponse(error_body("internal", message), status_code=500)
