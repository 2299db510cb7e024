"""Writes frames of a video as picture files, one in memory at a time."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import ExportError
from tsr_engine.exchange.dataset import DatasetVideo
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.io.video import Frame, open_video

JPEG_QUALITY = 95


@dataclass(frozen=True, slots=True)
class WrittenPicture:
    """An exported frame; a row of the manifest.

    Attributes:
        video: index of the video in the data set.
        frame: ordinal.
        file: relative to the export, with slashes.
        sha256: hash of the decoded picture's bytes (BGR, 8 bit, row by row), before compression.
    """

    video: int
    frame: int
    file: str
    sha256: str


def wanted_frames(video: DatasetVideo, annotated: NDArray[np.int64], pictures: str) -> NDArray[np.int64]:
    """Ordinals of the frames whose pictures are exported, ascending.

    Args:
        video: frames of its rejected tracks count as annotated: their pictures are hard negatives.
        annotated: frames with a box.
        pictures: ``none``, ``annotated`` or ``all`` (all examined frames).
    """
    if pictures == "all":
        return np.arange(video.first, video.stop or video.frames, dtype=np.int64)
    if pictures != "annotated":
        return np.zeros(0, dtype=np.int64)
    return np.unique(np.concatenate([annotated, *(track.frames for track in video.negatives)])).astype(np.int64)


def stream_frames(video: DatasetVideo, frames: NDArray[np.int64]) -> Iterator[Frame]:
    """Yield decoded frames in ascending order, one in memory at a time.

    Frames in between are decoded too; if the next one is far, decoding restarts at a key frame.

    Args:
        video: needs its ``path``.
        frames: ordinals, ascending.

    Raises:
        ExportError: the video's path is not known.
        VideoError: the file cannot be decoded, or differs from the video's frame table.
    """
    if not len(frames):
        return
    if video.path is None:
        raise ExportError(f"The file of {video.name} is not known, so it has no pictures. Export without pictures.")
    max_skip = 300
    breaks = np.flatnonzero(np.diff(frames) > max_skip) + 1
    with open_video(video.path, limits=video.limits, table=video.table) as opened:
        for part in np.split(frames, breaks):
            wanted = set(part.tolist())
            for frame in opened.frames(int(part[0]), int(part[-1]) + 1):
                if frame.ordinal in wanted:
                    yield frame


def picture_sha256(frame: Frame) -> str:
    """SHA-256 of a decoded picture's bytes: BGR, 8 bit, row by row."""
    return hashlib.sha256(np.ascontiguousarray(frame.picture).data).hexdigest()


def encode_picture(picture: NDArray[np.uint8], suffix: str) -> bytes:
    """Encode a picture as a file.

    Args:
        picture: BGR, uint8, shape (h, w, 3).
        suffix: ``.jpg`` (quality 95), ``.png`` or ``.ppm``.

    Raises:
        ExportError: OpenCV cannot encode it.
    """
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY] if suffix == ".jpg" else []
    done, content = cv2.imencode(suffix, picture, options)
    if not done:
        raise ExportError(f"A picture of {picture.shape[1]}x{picture.shape[0]} px cannot be written as {suffix}.")
    return content.tobytes()


def write_pictures(
    video: DatasetVideo, video_index: int, frames: NDArray[np.int64], out: OutputSink, names: Sequence[str]
) -> Iterator[WrittenPicture]:
    """Write frames of a video; yields after each file, so that the caller can report progress or stop.

    Args:
        video: needs its ``path``.
        video_index: index of the video in the data set.
        frames: ordinals, ascending.
        out: the export.
        names: file name of each frame, with slashes; the suffix decides the format.

    Raises:
        ExportError: the video's path is not known.
        VideoError: the file cannot be decoded.
        OSError: a file cannot be written.
    """
    for frame, name in zip(stream_frames(video, frames), names, strict=True):
        out.put(name, encode_picture(frame.picture, name[name.rindex(".") :]))
        yield WrittenPicture(video_index, frame.ordinal, name, picture_sha256(frame))


def frames_with_boxes(video: DatasetVideo) -> NDArray[np.int64]:
    """Frames with a box, ascending; reads the tracks once."""
    has_box = np.zeros(video.frames, dtype=np.bool_)
    for track in video.tracks():
        has_box[track.frames] = True
    return np.flatnonzero(has_box).astype(np.int64)
