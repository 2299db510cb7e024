"""The browser page: ``static/`` as it lies on disk, revalidated on every visit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fastapi import FastAPI, Request
from fastapi.responses import Response
from starlette.staticfiles import StaticFiles

__all__ = ["mount_pages", "static_folder"]


def static_folder() -> Path:
    """Where the page lies: beside ``app`` in a checkout, inside it in a wheel."""
    here = Path(__file__).resolve().parent
    inside = here / "static"
    return inside if inside.is_dir() else here.parent / "static"


class _Revalidated(StaticFiles):
    """Files that a browser may keep but asks about: an update is seen at once, an unchanged file costs a 304."""

    def file_response(self, *args: Any, **options: Any) -> Response:  # handed on as they come
        answer = super().file_response(*args, **options)
        answer.headers["Cache-Control"] = "no-cache"
        return answer


def mount_pages(app: FastAPI) -> None:
    """Serve the page at ``/`` and its files under ``/static``."""
    folder = static_folder()
    files = _Revalidated(directory=folder)

    @app.api_route("/", methods=["GET", "HEAD"], include_in_schema=False)
    @app.api_route("/index.html", methods=["GET", "HEAD"], include_in_schema=False)
    async def index(request: Request) -> Response:
        return await files.get_response("index.html", request.scope)

    @app.api_route("/favicon.ico", methods=["GET", "HEAD"], include_in_schema=False)
    async def icon(request: Request) -> Response:
        return await files.get_response("icon.svg", request.scope)

    app.mount("/static", files)
