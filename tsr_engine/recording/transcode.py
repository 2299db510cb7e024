"""Pictures encoded anew, for videos whose packets a viewer cannot show."""

from __future__ import annotations

from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import av
import numpy as np

from tsr_engine.errors import VideoError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.video import open_video
from tsr_engine.io.video_probe import VideoLimits
from tsr_engine.recording.content import Frames

__all__ = ["encode_frames"]

_MICROSECONDS: Final = Fraction(1, 1_000_000)
_OPTIONS: Final = {"preset": "veryfast", "crf": "20", "g": "30", "bf": "0", "threads": "1"}


def encode_frames(path: Path, frames: Frames, limits: VideoLimits, table: FrameTable | None) -> tuple[bytes, int]:
    """The frames upright as H.264 in an MP4 file, each at its own presentation time, and how many there are.

    Odd sizes grow by one column or row, which repeats the last one.

    Raises:
        VideoError: the video ends before the last of the frames, or cannot be decoded.
    """
    target, count = BytesIO(), 0
    start = float(frames.seconds[0])
    with (
        open_video(path, limits=limits, table=table) as video,
        av.open(target, "w", format="mp4", options={"use_editlist": "0"}) as out,
    ):
        stream: Any = out.add_stream("libx264", rate=30, options=_OPTIONS)
        stream.width, stream.height = video.width + video.width % 2, video.height + video.height % 2
        stream.pix_fmt = "yuv420p"
        stream.codec_context.time_base = stream.time_base = _MICROSECONDS
        before = -1
        for frame in video.frames(frames.first, frames.first + len(frames)):
            padding = ((0, stream.height - video.height), (0, stream.width - video.width), (0, 0))
            picture = av.VideoFrame.from_ndarray(np.pad(frame.picture, padding, mode="edge"), format="bgr24")
            before = max(before + 1, round((float(frames.seconds[count]) - start) * 1e6))
            picture.pts, picture.time_base = before, _MICROSECONDS
            out.mux(stream.encode(picture))
            count += 1
        out.mux(stream.encode(None))
    if count != len(frames):
        raise VideoError(
            f"{path} ends before frame {frames.first + len(frames) - 1}: it is not the video of this run. Name the one "
            "that was tracked."
        )
    return target.getvalue(), count
