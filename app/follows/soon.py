"""Opens a video in advance at a frame where a person may soon follow a sign, decoded from its key frame.

This takes longer than all other steps before the first proposal. A worker keeps one such video.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from sqlalchemy.orm import undefer

from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Run, Video
from app.videos.opened import CheckedFile, library_file
from app.videos.previews import effort
from app.videos.same_file import require_same
from app.videos.table import unpack
from tsr_engine.errors import TsrError
from tsr_engine.io.bidirectional_frames import BidirectionalFrames
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import Stamp
from tsr_engine.io.video import Video as OpenVideo
from tsr_engine.io.video import VideoLimits, open_video

__all__ = ["get_ready", "opened"]

_MOST = 2.0
"""Maximum seconds of decoding for a follow that may not be requested."""


@dataclass(slots=True)
class _Kept:
    digest: str
    stamp: Stamp | None
    video: OpenVideo
    pictures: BidirectionalFrames

    def close(self) -> None:
        self.pictures.close()
        self.video.close()


_kept: list[_Kept] = []


def get_ready(settings: Settings, database: Database, run_id: str, frame: int) -> None:
    """Open the video of a run and decode up to a frame; errors are reported when a person follows."""
    with database.read() as session:
        run = session.get(Run, run_id)
        video = None if run is None else session.get(Video, run.video_id, options=(undefer(Video.frame_table),))
    if video is None or video.frame_table is None:
        return
    table = unpack(video.frame_table)
    if not 0 <= frame < len(table.key):
        return
    try:
        file = library_file(settings, video)
        require_same(database, file, video)
        kept = _take(file) or _open(file, table, settings.video_limits)
        _kept.append(kept)
        key = table.key_at_or_before(frame) or 0
        if effort(frame - key, kept.video.width, kept.video.height) < _MOST:
            kept.pictures.prefetch(frame)
    except Exception as error:  # a video that failed is not kept
        while _kept:
            _kept.pop().close()
        if not isinstance(error, TsrError | OSError):
            raise


@contextmanager
def opened(file: CheckedFile, table: FrameTable | None, limits: VideoLimits) -> Iterator[BidirectionalFrames]:
    """Open a file that was just checked; frames that were decoded in advance are reused.

    Raises:
        VideoError: the file cannot be opened, or does not match its table.
    """
    kept = _take(file) or _open(file, table, limits)
    try:
        yield kept.pictures
    finally:
        kept.close()


def _take(file: CheckedFile) -> _Kept | None:
    """The kept video if it is this file in its current state; another one is closed."""
    while _kept:
        kept = _kept.pop()
        if (kept.digest, kept.stamp) == (file.digest, file.stamp):
            return kept
        kept.close()
    return None


def _open(file: CheckedFile, table: FrameTable | None, limits: VideoLimits) -> _Kept:
    video = open_video(file, limits=limits, table=table)
    return _Kept(file.digest or "", file.stamp, video, BidirectionalFrames(video))
