"""The browser page: ``static/`` as it lies on disk.

The page links its scripts and styles under ``/static/v-VERSION/``; the version is a digest of the files' names and
content. Browsers cache the files of a version, so a second visit requests only the page. Under ``/static/`` itself,
and under an old version, files are revalidated.
"""

from __future__ import annotations

import asyncio
import re
from pathlib import Path
from typing import Final

from fastapi import FastAPI, Request
from fastapi.responses import FileResponse, HTMLResponse, Response
from starlette.datastructures import Headers
from starlette.staticfiles import NotModifiedResponse, StaticFiles
from starlette.types import Scope

from app.page_files import page_version, static_folder

_VERSIONED: Final = re.compile(r"v-([0-9a-f]{16})[/\\]")
_CODE: Final = re.compile(r'(?<=")/static/(?=(?:js|css)/)')


class _PageFiles(StaticFiles):
    """Static files: browsers cache those under their version and revalidate the others (304 if unchanged)."""

    def __init__(self, folder: Path) -> None:
        super().__init__(directory=folder)
        self.folder = folder
        self.version = ""
        self._kept: dict[str, tuple[bytes, Headers]] = {}
        """Content and headers of the version's files that were asked for, by path with the version."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Serve ``path``, with or without a version prefix."""
        named = _VERSIONED.match(path)
        current = named is not None and named[1] == self.version
        asked = Headers(scope=scope)
        if current and path in self._kept and scope["method"] == "GET" and "range" not in asked:
            content, headers = self._kept[path]
            unchanged = self.is_not_modified(headers, asked)
            return NotModifiedResponse(headers) if unchanged else Response(content, headers=headers)
        answer = await super().get_response(path[named.end() :] if named else path, scope)
        answer.headers["Cache-Control"] = "public, max-age=31536000, immutable" if current else "no-cache"
        if current and isinstance(answer, FileResponse) and scope["method"] == "GET" and "range" not in asked:
            content = await asyncio.to_thread(Path(answer.path).read_bytes)
            if answer.headers["content-length"] == str(len(content)):  # otherwise it is being written
                headers = Headers(raw=list(answer.raw_headers))  # those of the answer still change
                self._kept[path] = content, headers
                return Response(content, headers=headers)
        return answer

    def page(self, request: Request) -> Response:
        """Serve ``index.html`` with the current version in its addresses."""
        version = page_version(self.folder)
        if version != self.version:
            self.version, self._kept = version, {}
        text = (self.folder / "index.html").read_text(encoding="utf-8")
        headers = {"Cache-Control": "no-cache", "ETag": f'"{self.version}"'}
        answer = HTMLResponse(_CODE.sub(f"/static/v-{self.version}/", text), headers=headers)
        return NotModifiedResponse(answer.headers) if self.is_not_modified(answer.headers, request.headers) else answer


def mount_pages(app: FastAPI) -> None:
    """Serve the page at ``/`` and its files under ``/static``."""
    files = _PageFiles(static_folder())

    @app.api_route("/", methods=["GET", "HEAD"], include_in_schema=False)
    @app.api_route("/index.html", methods=["GET", "HEAD"], include_in_schema=False)
    def index(request: Request) -> Response:
        return files.page(request)

    @app.api_route("/favicon.ico", methods=["GET", "HEAD"], include_in_schema=False)
    async def icon(request: Request) -> Response:
        return await files.get_response("icon.svg", request.scope)

    app.mount("/static", files)
