"""The Rerun viewer at ``/rerun``: its page, its files and the recordings that it opens."""

from __future__ import annotations

from typing import Annotated, Final

from fastapi import Header, Path, Response
from fastapi.responses import FileResponse

from app.api.routing import api_router
from app.body_model import Model
from app.context import ContextDep
from app.errors import Busy, NotFound
from app.page_files import static_folder

VIEWER_CSP: Final = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; connect-src 'self' data: blob:; "
    "img-src 'self' data: blob:; font-src 'self' data:; worker-src 'self' blob:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'"
)
"""Policy that lets the viewer reach only this server; it would call others for fonts, usage statistics and examples."""

router = api_router(prefix="/rerun", in_schema=False)

_IMMUTABLE: Final = {"Cache-Control": "private, max-age=31536000, immutable"}


class ViewerState(Model):
    """Whether the viewer is available; see ``ViewerState`` in static/js/views/recording/index.js."""

    ready: bool
    version: str
    message: str


@router.get("/state")
def get_state(context: ContextDep) -> ViewerState:
    """Make the viewer available; the first call takes some seconds."""
    try:
        context.viewer.ensure()
    except Busy as error:
        return ViewerState(ready=False, version=context.viewer.version, message=error.message)
    return ViewerState(ready=True, version=context.viewer.version, message="")


@router.get("/viewer.html")
def get_page() -> Response:
    """The page that holds the viewer; the review screen shows it in a frame."""
    page = static_folder() / "rerun" / "viewer.html"
    return FileResponse(page, headers={"Content-Security-Policy": VIEWER_CSP, "Cache-Control": "no-cache"})


@router.get("/recordings/{output_id}.rrd")
def get_recording(output_id: Annotated[str, Path(pattern="^[0-9a-f]{32}$")], context: ContextDep) -> Response:
    """A recording under a name whose extension the viewer knows."""
    output = context.outputs.get(output_id)
    if output.kind != "recording":
        raise NotFound(f"{output.name} is not a recording.")
    path, _ = context.outputs.open(output_id)
    headers = {**_IMMUTABLE, "Content-Encoding": "identity"}  # compressed already
    return FileResponse(path, media_type="application/octet-stream", headers=headers)


@router.get("/{version}/{name}")
def get_file(
    version: str, name: str, context: ContextDep, if_none_match: Annotated[str | None, Header()] = None
) -> Response:
    """A file of the viewer, gzipped as stored."""
    file = context.viewer.file(name) if version == context.viewer.version else None
    if file is None:
        raise NotFound(f"The Rerun viewer {version[:40]!r} has no file {name[:80]!r} here.")
    headers = {
        **_IMMUTABLE,
        "ETag": f'"{file.digest}"',
        "Content-Encoding": "gzip",
        "Vary": "Accept-Encoding",
        "Rerun-Final-Length": str(file.size),
    }
    if if_none_match is not None and f'"{file.digest}"' in if_none_match:
        return Response(status_code=304, headers=headers)
    return FileResponse(file.path, media_type=file.media_type, headers=headers)
