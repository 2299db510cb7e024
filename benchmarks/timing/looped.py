"""Drives of 720x576 as long as one likes: a part of the sample drives, its coded pictures repeated without recoding."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Final

import av
import cv2
import numpy as np

from sample_videos import SHIPPED
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.records import Picture

__all__ = ["RATE", "SIZE", "base_clip", "cut_out", "looped"]

SIZE: Final = (720, 576)
RATE: Final = 25
"""Frames a second."""


def cut_out(picture: Picture) -> Picture:
    """The right part of a picture, as wide as SIZE's shape allows, scaled to SIZE; signs stand at the right."""
    height, width = picture.shape[:2]
    wide = min(width, round(height * SIZE[0] / SIZE[1]))
    return np.asarray(cv2.resize(picture[:, width - wide :], SIZE, interpolation=cv2.INTER_LINEAR), np.uint8)


def base_clip(folder: Path, frames: int, drives: int = 1) -> Path:
    """The first pictures of the sample drives, as many of each; made once.

    Args:
        folder: for the file.
        frames: in all.
        drives: how many sample drives share them.

    Raises:
        ValueError: the drives are shorter.
    """
    path = folder / f"base_{frames}_{drives}.mp4"
    if path.is_file():
        return path
    folder.mkdir(parents=True, exist_ok=True)
    left = frames
    # key frames often, and none that waits for a later one: the file can be repeated at its end
    with VideoWriter(path, *SIZE, Fraction(RATE), keys=RATE) as writer:
        for number, clip in enumerate(SHIPPED[:drives]):
            with open_video(clip.video) as video:
                for frame in video.frames(0, -(-left // (drives - number))):
                    writer.write(cut_out(frame.picture))
                    left -= 1
        if left:
            raise ValueError(f"Expected at most {frames - left} frames, all that the drives have. Got {frames}.")
    return path


def looped(base: Path, times: int, path: Path) -> Path:
    """A clip again and again in one file; made once."""
    if path.is_file():
        return path
    part = path.with_suffix(".part.mp4")
    with av.open(str(base)) as source:
        length = source.streams.video[0].frames
    with av.open(str(part), "w") as sink:
        out: object = None
        for turn in range(times):
            with av.open(str(base)) as source:
                stream = source.streams.video[0]
                out = out or sink.add_stream_from_template(stream)
                step = round(length / (RATE * stream.time_base))
                for packet in source.demux(stream):
                    if packet.pts is None:
                        continue
                    packet.pts += turn * step
                    packet.dts += turn * step
                    packet.stream = out
                    sink.mux(packet)
    part.rename(path)
    return path
