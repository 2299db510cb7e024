"""Who is here, and what the page may do."""

from __future__ import annotations

from fastapi import APIRouter

from app.api.responses import failures
from app.context import ContextDep
from app.shapes import Model
from tsr_engine.params.presets import PRESETS
from tsr_engine.version import __version__

__all__ = ["router"]

router = APIRouter(tags=["session"])


class Sample(Model):
    """The bundled drive that the first screen offers."""

    video_id: str
    run_id: str | None


class SessionAnswer(Model):
    """What the page starts from."""

    version: str
    author: str
    """Name that edits carry unless the page sets another."""
    roots: list[str]
    """Folders that videos may be added from."""
    upload_bytes: int
    """Largest upload."""
    sample: Sample | None
    """The bundled drive."""
    presets: list[str]


class Link(Model):
    """A path that opens the page once."""

    path: str


@router.get("/session", operation_id="get_session", responses=failures())
def get_session(context: ContextDep) -> SessionAnswer:
    """Version, name, limits, and the sample drive."""
    sample = context.videos.sample()
    return SessionAnswer(
        version=__version__,
        author=context.settings.author,
        roots=[str(root) for root in context.settings.roots],
        upload_bytes=context.settings.upload_max_mb * 2**20,
        sample=None if sample is None else Sample(video_id=sample[0], run_id=sample[1]),
        presets=list(PRESETS),
    )


@router.post("/session/links", operation_id="create_link", status_code=201, responses=failures())
def create_link(context: ContextDep) -> Link:
    """A new one-time link, for a second browser or after a lost cookie."""
    return Link(path=f"/login/{context.tokens.new_link()}")
