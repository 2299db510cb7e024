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
from app.videos.checked_file import CheckedFile, library_file
from app.videos.file_changes import require_unchanged
from app.videos.packed_table import unpack
from app.videos.previews import decoding_seconds
from tsr_engine.errors import TsrError
from tsr_engine.io.bidirectional_frames import BidirectionalFrames
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import Stamp
from tsr_engine.io.video import Video as OpenVideo
from tsr_engine.io.video import VideoLimits, open_video

_MAX_DECODING_S = 2.0
"""Maximum seconds of decoding for a follow that may not be requested."""


@dataclass(slots=True)
class _PreparedVideo:
    digest: str
    stamp: Stamp | None
    video: OpenVideo
    pictures: BidirectionalFrames

    def close(self) -> None:
        self.pictures.close()
        self.video.close()


_prepared: list[_PreparedVideo] = []


def prepare_video(settings: Settings, database: Database, run_id: str, frame: int) -> None:
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
        require_unchanged(database, file, video)
        prepared = _take(file) or _open(file, table, settings.video_limits)
        _prepared.append(prepared)
        key = table.key_at_or_before(frame) or 0
        if decoding_seconds(frame - key, prepared.video.width, prepared.video.height) < _MAX_DECODING_S:
            prepared.pictures.prefetch(frame)
    except Exception as error:  # a video that failed is not kept
        while _prepared:
            _prepared.pop().close()
        if not isinstance(error, TsrError | OSError):
            raise


@contextmanager
def open_prepared(file: CheckedFile, table: FrameTable | None, limits: VideoLimits) -> Iterator[BidirectionalFrames]:
    """Open a file that was just checked; frames that were decoded in advance are reused.

    Raises:
        VideoError: the file cannot be opened, or does not match its table.
    """
    prepared = _take(file) or _open(file, table, limits)
    try:
        yield prepared.pictures
    finally:
        prepared.close()


def _take(file: CheckedFile) -> _PreparedVideo | None:
    """The kept video if it is this file in its current state; another one is closed."""
    while _prepared:
        prepared = _prepared.pop()
        if (prepared.digest, prepared.stamp) == (file.digest, file.stamp):
            return prepared
        prepared.close()
    return None


def _open(file: CheckedFile, table: FrameTable | None, limits: VideoLimits) -> _PreparedVideo:
    video = open_video(file, limits=limits, table=table)
    return _PreparedVideo(file.digest or "", file.stamp, video, BidirectionalFrames(video))
