"""Whether a file is still the one that a video is named after, and what is refused where it is not."""

from __future__ import annotations

import threading
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import undefer

from app.errors import Conflict
from app.storage.database import Database
from app.storage.models import Run, Video
from app.videos.table import modified
from app.videos.words import in_words
from tsr_engine.errors import InputError, VideoError
from tsr_engine.io.video_probe import video_sha256

__all__ = ["ChangedFiles", "file_changed", "file_stamp", "is_same", "is_untouched", "require_same"]


def is_untouched(video: Video, path: Path) -> bool:
    """Whether size and time of change of a file are those of when the frame table was made; its bytes are not read."""
    try:
        found = path.stat()
    except OSError:
        return False
    stamp = -1 if video.frame_table is None else modified(video.frame_table)
    return stamp >= 0 and (found.st_size, found.st_mtime_ns) == (video.size, stamp)


def is_same(video: Video, path: Path) -> bool:
    """Whether a file has the video's bytes. They are read where only the time of change is another: it may be a copy.

    Raises:
        VideoError: it is missing or cannot be read.
    """
    stamp = file_stamp(path)
    if stamp is not None and stamp[0] != video.size:
        return False
    return is_untouched(video, path) or video_sha256(path) == video.id


def require_same(video: Video) -> None:
    """The file must be there and be the one that the video is named after, for its frame table is relied on.

    Raises:
        InputError: it is missing, or holds other bytes.
        VideoError: it cannot be read.
    """
    path = Path(video.path)
    if not path.is_file():
        raise InputError(f"{path} is not there any more. Put it back, or add the video from where it lies now.")
    if not is_same(video, path):
        raise InputError(f"{path} has changed since it was added. Add it again: it counts as another video.")


def file_stamp(path: Path) -> tuple[int, int, int, int] | None:
    """Size, time of change and place of a regular file; None where there is none."""
    try:
        found = path.stat()
    except OSError:
        return None
    return (found.st_size, found.st_mtime_ns, found.st_dev, found.st_ino) if path.is_file() else None


def file_changed(video: Video) -> Conflict:
    """The refusal of what is about frames that nobody can look at any more."""
    sentence = f"{video.path} has changed since it was added. Put it back as it was, or add it as another video."
    return Conflict(in_words(video, sentence), code="file_changed")


class ChangedFiles:
    """Refuses to change what is said about a video while another file lies in its place.

    A file that is not there, or cannot be read, does not: what a person says is about frames of the video that its
    hash names, their evidence is here, and a drive that is not plugged in is no reason to put work off.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._lock = threading.Lock()
        self._known: dict[str, tuple[tuple[int, ...], bool]] = {}
        """By video: how its file stood when its bytes were last judged, and whether they were the video's."""

    def refuse(self, run_id: str) -> None:
        """Look at the file of a run's video; it is read only where it was touched, and once for each time.

        Raises:
            Conflict: it holds other bytes (``file_changed``).
        """
        query = select(Video.id, Video.path).join(Run, Run.video_id == Video.id).where(Run.id == run_id)
        with self._database.read() as session:
            found = session.execute(query).first()
        stamp = None if found is None else file_stamp(Path(found.path))
        if found is None or stamp is None or self._known.get(found.id) == (stamp, True):
            return
        with self._database.read() as session:
            video = session.get(Video, found.id, options=(undefer(Video.frame_table),))
        if video is not None and not self._is_same(video, stamp):
            raise file_changed(video)

    def _is_same(self, video: Video, stamp: tuple[int, ...]) -> bool:
        with self._lock:  # who else asks for the same file meanwhile need not read it once more
            known = self._known.get(video.id)
            if known is None or known[0] != stamp:
                try:
                    known = (stamp, is_same(video, Path(video.path)))
                except VideoError:
                    return True
                self._known[video.id] = known
            return known[1]
