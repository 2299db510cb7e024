"""Where a video ends: nothing that people say lies beyond its last frame.

Documents span any frames that they name, so one far frame would cost whoever reads its track as much as a video of that
length. What is stored is checked here; what older versions have stored is cut where it is read
(:func:`app.edits.effective.effective_track`).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from sqlalchemy.orm import Session

from app.edits.commands import Follow, Interpolate, Redo, Undo
from app.edits.documents import TrackDoc
from app.errors import Conflict, Invalid
from app.storage.models import Run, Video

__all__ = ["known_frames", "require_documents_inside", "require_inside"]


def known_frames(session: Session, run: Run) -> int:
    """How many frames of a run's video are known to be there.

    All, once it is imported. Until then (the clip of a bundle comes with a run that is complete) those that the import
    has decoded or the run has seen.

    Args:
        session: reads.
        run: stored.

    Raises:
        Conflict: none is known yet.
    """
    video = session.get_one(Video, run.video_id)
    frames = video.frames or 0
    if video.state != "ready":
        frames = max(frames, run.stop or 0)
    if frames < 1:
        raise Conflict(f"{video.name} is {video.state}: its frames are not known yet.", code="not_ready")
    return frames


def require_inside(command: Any, frames: int) -> None:
    """Refuse a command about frames that the video does not have.

    Its ``spans`` may reach further: they are what the page took the engine's tracks to be, and nobody reads them.

    Args:
        command: see :mod:`app.edits.commands`.
        frames: that the video has.

    Raises:
        Invalid: names the first such frame.
    """
    if isinstance(command, Undo | Redo):
        return
    named = {"frame": command.frame}
    if isinstance(command, Interpolate):
        named |= {"first": command.first, "last": command.last}
    if isinstance(command, Follow):
        named |= {"boxes": command.boxes[-1].frame}
    for name, frame in named.items():
        if frame >= frames:
            raise Invalid(_beyond(frame, frames), field=f"command.{name}", code="no_such_frame")


def require_documents_inside(documents: Iterable[TrackDoc], frames: int) -> None:
    """Refuse documents with key frames or notes beyond the video's end, whoever brings them.

    Segments may reach further: they only choose among the engine's own boxes.

    Args:
        documents: to be stored.
        frames: that the video has.

    Raises:
        Invalid: names the track and its last frame.
    """
    for doc in documents:
        last = doc.last_said()
        if last is not None and last >= frames:
            raise Invalid(f"Track {doc.key}: {_beyond(last, frames)}", code="no_such_frame")


def _beyond(frame: int, frames: int) -> str:
    return f"The video has frames 0 to {frames - 1}. Got {frame}."
