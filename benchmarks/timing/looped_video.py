"""Makes drives of 720x576 of any length: coded pictures of the sample drives, repeated without encoding."""

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

SIZE: Final = (720, 576)
RATE: Final = 25
"""Frames a second."""


def cut_out(picture: Picture) -> Picture:
    """The right part of a picture with the aspect ratio of SIZE, scaled to SIZE; signs are on the right."""
    height, width = picture.shape[:2]
    wide = min(width, round(height * SIZE[0] / SIZE[1]))
    return np.asarray(cv2.resize(picture[:, width - wide :], SIZE, interpolation=cv2.INTER_LINEAR), np.uint8)


def base_clip(folder: Path, frames: int, drives: int = 1) -> Path:
    """Equally many first pictures of the sample drives as one clip, made on first use.

    Args:
        folder: folder for the file.
        frames: total number of frames.
        drives: number of sample drives.

    Raises:
        ValueError: the drives are too short.
    """
    path = folder / f"base_{frames}_{drives}.mp4"
    if path.is_file():
        return path
    folder.mkdir(parents=True, exist_ok=True)
    left = frames
    # Frequent keyframes and no frame that depends on a later one, so that the file can be repeated at its end.
    with VideoWriter(path, *SIZE, Fraction(RATE), key_distance=RATE) as writer:
        for number, clip in enumerate(SHIPPED[:drives]):
            with open_video(clip.video) as video:
                for frame in video.frames(0, -(-left // (drives - number))):
                    writer.write(cut_out(frame.picture))
                    left -= 1
        if left:
            raise ValueError(f"Expected at most {frames - left} frames, all that the drives have. Got {frames}.")
    return path


def repeat_clip(clip: Path, out: Path, frames: int) -> None:
    """Write a clip repeated until it has so many frames or more, without encoding."""
    with av.open(out, "w", format="mp4") as target:
        stream: object = None
        done = after = 0
        while done < frames:
            with av.open(clip) as container:
                source = container.streams.video[0]
                stream = stream or target.add_stream_from_template(source)
                packets = [packet for packet in container.demux(source) if packet.size]
                step = min(packet.duration for packet in packets if packet.duration)
                first = min(packet.pts for packet in packets)
                end = max(packet.pts for packet in packets) + step - first
                for packet in packets:
                    packet.pts += after - first
                    packet.dts += after - first
                    packet.stream = stream
                    target.mux(packet)
                after, done = after + end, done + len(packets)
