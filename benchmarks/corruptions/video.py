"""Videos of changed pictures, such as those of a dim camera."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.records import Picture


def write_changed(
    change: Callable[[Picture, int], Picture], source: Path, place: Path, frames: int | None = None
) -> Path:
    """Write a video of changed pictures; returns ``place``.

    Args:
        change: changes a picture, given the picture and its number; keeps its size.
        source: the video.
        place: file to write.
        frames: number of first pictures to write; unset: all.
    """
    with open_video(source) as video, VideoWriter(place, video.width, video.height, video.rate) as writer:
        for frame in islice(video.frames(), frames):
            writer.write(change(frame.picture, frame.ordinal))
    return place


def dim(picture: Picture, ordinal: int) -> Picture:
    """The picture with a fifth of the light, noise, blur and strong compression."""
    rng = np.random.default_rng(ordinal)
    dark = picture.astype(np.float32) * 0.22 + rng.normal(0, 3.0, picture.shape).astype(np.float32)
    soft = cv2.GaussianBlur(np.clip(dark, 0, 255).astype(np.uint8), (0, 0), 0.9)
    _, code = cv2.imencode(".jpg", soft, [cv2.IMWRITE_JPEG_QUALITY, 45])
    return np.asarray(cv2.imdecode(code, cv2.IMREAD_COLOR), dtype=np.uint8)
