"""Re-encodes pictures of videos whose packets a viewer cannot show or that would make a recording too large."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from fractions import Fraction
from io import BytesIO
from typing import Final

import av
import numpy as np

from tsr_engine.errors import VideoError
from tsr_engine.io.cores import usable_cores
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video import open_video
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.recording.content import Frames
from tsr_engine.recording.group_encoder import GroupEncoder
from tsr_engine.track_table import IntArray

FRAME_BYTES: Final = 13_500
"""Bytes for a picture of 1280x720; other sizes by their area."""
TYPICAL_FRAMES: Final = 300
"""Frames of a usual recording: ``FRAME_BYTES`` each, with the layers of a busy street, stay below 5 MB."""
_TYPICAL_PIXELS: Final = 1280 * 720
_MICROSECONDS: Final = Fraction(1, 1_000_000)
_ENCODER_OPTIONS: Final = {"preset": "veryfast", "crf": "20", "g": "30", "bf": "0", "threads": "1"}
_DECODER_OPTIONS: Final = {"skip_loop_filter": "all"}
_MAX_CORES: Final = 8
_LOOKAHEAD: Final = 8
"""Number of packets that are decoded ahead of the consumer."""


def size_limit(count: int, width: int, height: int) -> int:
    """Size limit for ``count`` pictures of a recording, bytes; a short recording may be as large as the usual one."""
    return int(FRAME_BYTES * max(count, TYPICAL_FRAMES) * width * height / _TYPICAL_PIXELS)


def encode_packets(stream: av.VideoStream, packets: Sequence[av.Packet], wanted: IntArray, budget: int) -> bytes | None:
    """Encode pictures of a stream as H.264 in an MP4 file of a given size, each at its presentation time.

    The fast path: decoder and encoder run in parallel, and pictures are not converted in between.

    Args:
        stream: the stream of the packets.
        packets: in decoding order, from a key frame on.
        wanted: presentation times of the pictures, in ticks of the stream, ascending.
        budget: target size of the file, bytes; missed by some percent.

    Returns:
        The file, its pictures in the order of ``wanted``; None: the fast path is impossible, because the decoder gives
        other pictures or their sides are odd.
    """
    remaining = wanted.tolist()[::-1]
    start, target = remaining[-1], BytesIO()
    with av.open(target, "w", format="mp4", options={"use_editlist": "0"}) as out:
        encoder: GroupEncoder | None = None
        for picture in _decoded(stream.codec_context, packets, encoder_threads()):
            if not remaining or picture.pts != remaining[-1]:
                continue  # a lead-in picture
            if encoder is None:
                if picture.width % 2 or picture.height % 2:
                    return None
                encoder = GroupEncoder(out, picture, stream.time_base, len(remaining), budget, encoder_threads())
            elif (picture.width, picture.height) != encoder.size:
                return None
            remaining.pop()
            converted = picture if picture.format.name == "yuv420p" else picture.reformat(format="yuv420p")
            converted.pts, converted.time_base, converted.pict_type = picture.pts - start, stream.time_base, 0
            encoder.put(converted)
        if remaining or encoder is None:
            return None
        encoder.close()
    return target.getvalue()


def _decoded(context: av.VideoCodecContext, packets: Sequence[av.Packet], threads: int) -> Iterator[av.VideoFrame]:
    """All pictures of packets, in order of presentation.

    They are decoded in parallel with their consumer. With the decoder's own threads alone, both are idle for a
    fifth of the time on two cores, because the decoder runs out of work whenever the consumer is slow for a moment.

    The loop filter is off: it takes a quarter of the decoder's time, and the encoder removes most block edges too.
    Only H.264, H.265 and VP9 have this option.
    """
    decoder = av.CodecContext.create(context.codec.name, "r")
    decoder.extradata, decoder.thread_type, decoder.thread_count = context.extradata, "AUTO", threads
    decoder.options = _DECODER_OPTIONS
    futures: deque[Future[list[av.VideoFrame]]] = deque()
    with ThreadPoolExecutor(1, thread_name_prefix="tsr-recording-decode") as pool:
        for packet in (*packets, None):
            futures.append(pool.submit(decoder.decode, packet))
            if len(futures) > _LOOKAHEAD:
                yield from futures.popleft().result()
        for future in futures:
            yield from future.result()


def encoder_threads() -> int:
    """Threads of decoder and encoder each. On two cores, more threads for one make both wait for each other."""
    return max(1, min(_MAX_CORES, usable_cores()) // 2)


def encode_frames(path: VideoSource, frames: Frames, limits: VideoLimits, table: FrameTable | None) -> bytes:
    """Encode the frames upright as H.264 in an MP4 file, each at its presentation time.

    Odd sizes grow by one column or row, which repeats the last one.

    Raises:
        VideoError: the video ends before the last frame, or cannot be decoded.
    """
    target, count = BytesIO(), 0
    start = float(frames.seconds[0])
    with (
        open_video(path, limits=limits, table=table) as video,
        av.open(target, "w", format="mp4", options={"use_editlist": "0"}) as out,
    ):
        stream = out.add_stream("libx264", rate=30, options=_options(frames, video.width, video.height))
        stream.width, stream.height = video.width + video.width % 2, video.height + video.height % 2
        stream.pix_fmt = "yuv420p"
        stream.codec_context.time_base = stream.time_base = _MICROSECONDS
        last_time = -1
        for frame in video.frames(frames.first, frames.first + len(frames)):
            padding = ((0, stream.height - video.height), (0, stream.width - video.width), (0, 0))
            picture = av.VideoFrame.from_ndarray(np.pad(frame.picture, padding, mode="edge"), format="bgr24")
            last_time = max(last_time + 1, round((float(frames.seconds[count]) - start) * 1e6))
            picture.pts, picture.time_base = last_time, _MICROSECONDS
            out.mux(stream.encode(picture))
            count += 1
        out.mux(stream.encode(None))
    if count != len(frames):
        raise VideoError(
            f"{path} ends before frame {frames.first + len(frames) - 1}: it is not the video of this run. Name the one "
            "that was tracked."
        )
    return target.getvalue()


def _options(frames: Frames, width: int, height: int) -> dict[str, str]:
    """Encoder options for good pictures within the size limit."""
    bits = int(size_limit(len(frames), width, height) * 8 / frames.duration)
    return {**_ENCODER_OPTIONS, "maxrate": str(bits), "bufsize": str(bits)}
