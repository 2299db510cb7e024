"""The job ``import``: decodes a video once and stores its frame table, a thumbnail and a small copy."""

from __future__ import annotations

import time
from collections.abc import Callable

import cv2
from sqlalchemy.orm import Session

from app.events import EventBus
from app.jobs.context import Stopped, TaskContext
from app.jobs.queue import JobQueue
from app.jobs.watchdog import watchdog
from app.storage.models import Video
from app.videos.checked_file import current_stamp, library_file
from app.videos.error_text import with_upload_name
from app.videos.import_files import preview_path, thumbnail_path
from app.videos.packed_table import pack
from app.videos.preview_writer import decode_all
from app.videos.view import publish_video
from tsr_engine.errors import VideoError
from tsr_engine.io.atomic import atomic_bytes
from tsr_engine.io.video import open_video

THUMBNAIL_WIDTH = 480
MAX_FRAME_CPU_S = 300.0
"""Processor time that one frame may take, seconds: a hundred times that of the largest allowed picture."""
_PROGRESS_INTERVAL_S = 0.5


def import_video(task: TaskContext, sample_ready: Callable[[Session, EventBus, JobQueue], None]) -> None:
    """Decode the whole video, so that every frame is known to exist before it is requested.

    Args:
        task: the job.
        sample_ready: called in the transaction that makes a sample drive ready.

    Raises:
        VideoError: the file cannot be decoded, or changed while it was read.
        Stopped: the job was asked to stop, or its subject was removed.
    """
    with task.database.read() as session:
        video = session.get_one(Video, task.job.subject)
    reported, done = 0.0, 0

    def too_slow() -> str:
        return (
            f"Frame {done} could not be decoded within {MAX_FRAME_CPU_S:.0f} s of computing. The file may be damaged "
            "there: encode it again, then add the new file."
        )

    def progress(confirmed: int) -> None:
        nonlocal reported, done
        done = confirmed
        step_done()
        if task.leaving():
            raise Stopped
        now = time.monotonic()
        if now - reported < _PROGRESS_INTERVAL_S:
            return
        reported = now
        if task.is_cancelled():
            raise Stopped
        with task.write() as session:
            row = session.get_one(Video, video.id)
            row.frames = confirmed
            task.record_progress(session, confirmed)
            publish_video(session, task.events, row)

    source = library_file(task.settings, video)
    source.stamp = None  # the whole file is read now, and its frame table is relied on later
    copy = preview_path(task.settings.home, video.id)
    with (
        watchdog(task, MAX_FRAME_CPU_S, too_slow) as step_done,
        open_video(source, limits=task.settings.video_limits) as file,
    ):
        table = decode_all(file, copy, progress)
        middle = file.read(len(table) // 2).picture
        last = len(table) - 1
        duration = float(table.time(last) - table.time(0) + table.interval())
        warnings = list(file.warnings)
        before, after = source.stamp, file.file.stamp
    if not before == after == current_stamp(source.path):
        raise VideoError(f"{source} was written to while it was read. Add it again when it is complete.")
    display_width = max(1, round(middle.shape[1] * file.pixel_ratio))
    width = min(THUMBNAIL_WIDTH, display_width)
    height = max(1, round(width * middle.shape[0] / display_width))
    small = cv2.resize(middle, (width, height), interpolation=cv2.INTER_AREA)
    _, code = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 85])
    path = thumbnail_path(task.settings.home, video.id)
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_bytes(path) as out:
        out.write(code.tobytes())
    with task.complete() as session:
        row = session.get_one(Video, video.id)
        row.state, row.error = "ready", None
        row.width, row.height, row.rotation = file.width, file.height, file.rotation
        row.pixel_ratio = float(file.pixel_ratio)
        row.codec, row.rate, row.frames, row.duration = file.codec, float(file.rate), len(table), duration
        row.warnings = [with_upload_name(row, warning) for warning in warnings]
        row.frame_table = pack(table)
        row.stamp = list(after)
        if row.sample:
            session.flush()
            sample_ready(session, task.events, task.jobs)
        publish_video(session, task.events, row)
