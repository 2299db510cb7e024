"""The link that ``tsr review`` prints: it opens the page once, and becomes a cookie."""

from __future__ import annotations

from fastapi import FastAPI, Request
from fastapi.responses import JSONResponse, RedirectResponse, Response

from app.errors import error_body
from app.security.guard import cookie_name, known
from app.security.tokens import Tokens

__all__ = ["mount_login"]


def mount_login(app: FastAPI, tokens: Tokens) -> None:
    """Serve ``/login/{link}``.

    A browser that is signed in comes in with a link that has been used too; any other one gets a page that says what to
    do, and a program the error in the shape of all others.
    """

    @app.get("/login/{link}", include_in_schema=False)
    def login(link: str, request: Request) -> Response:
        if tokens.use_link(link):
            return _signed_in(request, tokens.cookie)
        if known(tokens, request.scope):
            return RedirectResponse("/", status_code=303)
        if "text/html" in request.headers.get("accept", ""):
            return RedirectResponse("/static/used_link.html", status_code=303)
        return JSONResponse(
            error_body("unauthorised", "This link has been used. 'tsr review' prints a new one."), status_code=401
        )


def _signed_in(request: Request, cookie: str) -> Response:
    answer = RedirectResponse("/", status_code=303)
    port = (request.scope.get("server") or ("", 0))[1] or 0
    answer.set_cookie(
        cookie_name(port),
        cookie,
        max_age=30 * 86400,
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
    )
    return answer
