"""Finds videos and runs; queries with many values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final, TypeVar

from sqlalchemy import UnaryExpression, func, select
from sqlalchemy.orm import Session, undefer

from app.errors import NotFound
from app.storage.models import Edit, Run, Video

T = TypeVar("T")
ACTIVE: Final = ("queued", "running")
"""States of a job, run, output or version of models that waits or is being worked on."""


def require_video(session: Session, video_id: str, *, table: bool = False) -> Video:
    """Return a video; ``table``: with its frame table.

    Raises:
        NotFound: no such video.
    """
    video = session.get(Video, video_id, options=[undefer(Video.frame_table)] if table else [])
    if video is None:
        raise NotFound(f"There is no video {video_id[:80]!r}.")
    return video


def require_run(session: Session, run_id: str) -> Run:
    """Return a run.

    Raises:
        NotFound: no such run.
    """
    run = session.get(Run, run_id)
    if run is None:
        raise NotFound(f"There is no run {run_id[:40]!r}.")
    return run


def in_parts(values: Sequence[T], size: int = 500) -> Iterator[Sequence[T]]:
    """Cut values into parts for one statement each, because databases limit the values of a statement."""
    return (values[start : start + size] for start in range(0, len(values), size))


def newest_edit(session: Session, run_id: str) -> int:
    """Number of the newest operation on a run; 0: none yet."""
    return session.scalar(select(func.max(Edit.seq)).where(Edit.run_id == run_id)) or 0


def current_run_last() -> tuple[UnaryExpression[bool] | UnaryExpression[int], ...]:
    """Sort the current run of a video last: complete after incomplete, the engine's after imported, then by age.

    Imported tracks of others are only used if a request names their run.
    """
    return (Run.state == "complete").asc(), (Run.kind == "engine").asc(), Run.order.asc()
