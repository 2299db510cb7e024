"""Sign-in: the one-time link that ``tsr review`` prints, and the sign-in page for people."""

from __future__ import annotations

from fastapi import FastAPI, Request
from fastapi.responses import FileResponse, JSONResponse, RedirectResponse, Response

from app.errors import error_body
from app.page_files import static_folder
from app.security.access import Access, Denied, sign_in_cookie


def mount_login(app: FastAPI, access: Access) -> None:
    """Serve ``/login/{link}`` and ``/sign-in``.

    A used link still opens the page in a browser that is signed in. Any other browser gets a page that says what to do,
    and a program gets the error in the common shape. In a library with people a link leads to the sign-in page.
    """

    @app.get("/login/{link}", include_in_schema=False)
    async def login(link: str, request: Request) -> Response:
        people = not await access.has_no_people()
        if not people and access.tokens.use_link(link):
            answer = RedirectResponse("/", status_code=303)
            sign_in_cookie(request, answer, access.tokens.cookie)
            return answer
        try:
            await access.identify(request.scope)
            return RedirectResponse("/", status_code=303)
        except Denied as denied:
            if "text/html" in request.headers.get("accept", ""):
                return RedirectResponse("/sign-in" if people else "/static/used_link.html", status_code=303)
            used = "This link has been used. 'tsr review' prints a new one."
            return JSONResponse(error_body(denied.code, denied.message if people else used), status_code=401)

    @app.api_route("/sign-in", methods=["GET", "HEAD"], include_in_schema=False)
    def sign_in_page() -> Response:
        return FileResponse(static_folder() / "sign_in.html", headers={"Cache-Control": "no-cache"})
