"""The job ``glance``: makes the copy of a video that ``app.videos.glance`` reads."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
from sqlalchemy.orm import undefer

from app.jobs.context import Stopped, TaskContext
from app.storage.models import Video
from app.videos.glance import glance_path
from app.videos.table import unpack
from tsr_engine.errors import VideoError
from tsr_engine.io.video import VideoLimits, open_video
from tsr_engine.io.video_writer import VideoWriter

__all__ = ["KEYS", "WIDTH", "make_glances"]

KEYS = 12
"""Pictures from one key frame of the copy to the next."""
WIDTH = 960
"""Width of the copy at most, px."""
_CRF = 24
_RATE = Fraction(25)


def make_glances(task: TaskContext) -> None:
    """The job ``glance``: decode once, write the copy; begun anew after a kill."""
    with task.database.read() as session:
        video = session.get_one(Video, task.job.subject, options=[undefer(Video.frame_table)])
    if video.frame_table is None:
        raise VideoError(f"{video.name} is {video.state}: no copy for scrubbing can be made of it.")
    table = unpack(video.frame_table)
    place = glance_path(task.settings.home, video.id)
    place.parent.mkdir(parents=True, exist_ok=True)
    with open_video(Path(video.path), limits=VideoLimits(max_pixels=task.settings.max_pixels), table=table) as file:
        width, height = _size(file.width, file.height)
        with VideoWriter(place, width, height, _RATE, crf=_CRF, preset="ultrafast", keys=KEYS) as copy:
            for frame in file.frames():
                if frame.ordinal % 16 == 0 and task.stop():
                    raise Stopped
                small = cv2.resize(frame.picture, (width, height), interpolation=cv2.INTER_AREA)
                copy.write(np.asarray(small, dtype=np.uint8))
            if copy.frames != len(table):
                raise VideoError(f"{video.path} gave {copy.frames} pictures, not {len(table)}. Add it again.")


def _size(width: int, height: int) -> tuple[int, int]:
    wide = min(WIDTH, width)
    return wide, max(2, round(height * wide / width))
