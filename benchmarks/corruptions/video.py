"""Annotated clips as a person would have corrected them, and as a dim camera would have filmed them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from tsr_engine.exchange.dataset import DatasetVideo, Track
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.records import Picture
from tsr_engine.track_table import TrackTable

__all__ = ["corrected", "dim", "dimmed", "filmed"]


def corrected(path: Path, truth: TrackTable) -> DatasetVideo:
    """A clip with its annotation as tracks with a keyframe in every frame."""
    tracks = [_stated(truth, int(sign)) for sign in np.unique(truth.track)]
    with open_video(path) as video:
        frames = len(video.confirm())
        return DatasetVideo(
            path.name, "", video.width, video.height, frames, Fraction(30), None, True, _maker(tracks), path, 0, frames
        )


def _stated(truth: TrackTable, sign: int) -> Track:
    rows = np.flatnonzero(truth.track == sign)
    rows = rows[np.argsort(truth.frame[rows])]
    n = len(rows)
    return Track(
        uid=str(sign),
        label=int(np.bincount(truth.class_id[rows] + 1).argmax()) - 1,
        frames=truth.frame[rows],
        boxes=truth.boxes[rows],
        key=np.ones(n, bool),
        occluded=np.zeros(n, bool),
        score=np.full(n, np.nan),
        ignore=truth.ignore[rows],
        state="truth",
        source="truth",
    )


def _maker(tracks: list[Track]) -> Callable[[], Iterator[Track]]:
    return lambda: iter(tracks)


def dimmed(source: Path, place: Path) -> Path:
    """Write the clip with a fifth of the light, noise, blur and strong compression; returns ``place``."""
    return filmed(dim, source, place)


def filmed(change: Callable[[Picture, int], Picture], source: Path, place: Path, frames: int | None = None) -> Path:
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
