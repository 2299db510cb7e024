"""``create_app(settings)``: the whole server as one ASGI application."""

from __future__ import annotations

import logging
import uuid
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, RedirectResponse, Response
from sqlalchemy.exc import DBAPIError
from starlette.exceptions import HTTPException
from starlette.middleware.gzip import GZipMiddleware

from app.api import catalogue, compare, edits, events, evidence, frames, runs, session, truths, videos
from app.context import Context, build_context
from app.errors import ApiError, error_body
from app.pages import mount_pages
from app.security.guard import Guard, cookie_name
from app.settings import Settings
from app.startup import start, stop
from app.storage.database import storage_failure
from tsr_engine.errors import StorageError, TsrError
from tsr_engine.version import __version__

__all__ = ["create_app"]

_log = logging.getLogger("tsr.server")
_ROUTERS = (session, catalogue, videos, frames, runs, events, evidence, edits, truths, compare)


def create_app(settings: Settings) -> FastAPI:
    """Build the server.

    Args:
        settings: see :class:`app.settings.Settings`.

    Raises:
        StorageError: the data folder or the database cannot be used.
    """
    context = build_context(settings)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        running = start(context)
        app.state.running = running
        try:
            yield
        finally:
            await stop(running)
            context.close()

    app = FastAPI(
        title="tsr review",
        version=__version__,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        openapi_url="/api/openapi.json",
        redirect_slashes=False,
    )
    app.state.context = context
    for module in _ROUTERS:
        app.include_router(module.router, prefix="/api")
    _login(app, context)
    mount_pages(app)
    _failures(app)
    app.add_middleware(GZipMiddleware, minimum_size=2048, compresslevel=3)
    app.add_middleware(Guard, tokens=context.tokens, hosts=settings.allowed_hosts, body_max=settings.body_max_kb * 1024)
    return app


def _login(app: FastAPI, context: Context) -> None:
    @app.get("/login/{link}", include_in_schema=False)
    def login(link: str, request: Request) -> Response:
        if not context.tokens.use_link(link):
            return JSONResponse(
                error_body("unauthorised", "This link has been used. 'tsr review' prints a new one."), status_code=401
            )
        answer = RedirectResponse("/", status_code=303)
        port = (request.scope.get("server") or ("", 0))[1] or 0
        answer.set_cookie(
            cookie_name(port),
            context.tokens.cookie,
            max_age=30 * 86400,
            httponly=True,
            samesite="strict",
            secure=request.url.scheme == "https",
        )
        return answer


def _failures(app: FastAPI) -> None:
    """One shape for everything that goes wrong."""

    @app.exception_handler(ApiError)
    async def _api(_: Request, error: ApiError) -> Response:
        return JSONResponse(error.body(), status_code=error.status)

    @app.exception_handler(RequestValidationError)
    async def _invalid(_: Request, error: RequestValidationError) -> Response:
        first = error.errors()[0]
        place = [str(part) for part in first["loc"] if part not in ("body", "query", "path", "header")]
        if first["type"] == "json_invalid":
            return JSONResponse(error_body("invalid", "The body is not JSON.", None), status_code=422)
        if place[:1] == ["command"] and len(place) > 2:
            del place[1]  # the name of the command, which the body says already
        field = ".".join(place) or (str(first["loc"][0]) if first["loc"] else None)
        reason = first["msg"].removeprefix("Value error, ").rstrip(".")
        message = f"{field or 'The request'}: {reason[:1].lower()}{reason[1:]}."
        return JSONResponse(error_body("invalid", message, field), status_code=422)

    @app.exception_handler(HTTPException)
    async def _http(_: Request, error: HTTPException) -> Response:
        code = {404: "not_found", 405: "method_not_allowed"}.get(error.status_code, "refused")
        body = error_body(code, f"{error.detail}.")
        return JSONResponse(body, status_code=error.status_code, headers=dict(error.headers or {}))

    @app.exception_handler(DBAPIError)
    async def _database(request: Request, error: DBAPIError) -> Response:
        known = storage_failure(error)
        return await _unexpected(request, error) if known is None else await _api(request, known)

    @app.exception_handler(TsrError)
    async def _engine(_: Request, error: TsrError) -> Response:
        status, code = (507, "storage_full") if isinstance(error, StorageError) else (422, "invalid")
        return JSONResponse(error_body(code, str(error)), status_code=status)

    @app.exception_handler(Exception)
    async def _unexpected(request: Request, error: Exception) -> Response:
        number = uuid.uuid4().hex[:8]
        _log.exception("Error %s in %s %s", number, request.method, request.url.path, exc_info=error)
        message = f"Something unexpected went wrong. The server's log has it under {number}."
        return JSONResponse(error_body("internal", message), status_code=500)
