"""Cuts the picture of a recording: packets copied from a key frame on, in a small MP4 file.

Pictures are re-encoded only if the packets exceed the size limit of a recording, or if a viewer could not show them
at the right time: another codec, a rotated picture, a file without presentation times. The clip then says why.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from io import BytesIO
from typing import Final

import av
import numpy as np
from av.container import InputContainer

from tsr_engine.errors import UsageError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource, open_source
from tsr_engine.io.video_decoder import Orientation
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.io.video_packets import (
    UnfitPackets,
    check_kind,
    copy_packets,
    missing_packets_error,
    presentation_times,
    timed_packets,
)
from tsr_engine.io.video_probe import error_reason, open_container
from tsr_engine.recording.content import Frames
from tsr_engine.recording.transcode import encode_frames, encode_packets, size_limit
from tsr_engine.track_table import IntArray

PLAYABLE_CODECS: Final = frozenset({"h264", "hevc", "av1", "vp9"})
"""Codecs that a viewer plays from an MP4 file."""
MAX_BYTES: Final = 512 * 2**20
"""Largest clip in bytes: a viewer holds it in memory."""
_SEEK_MARGINS_S: Final = (0, 2, 10, 60)
"""Seconds by which a repeated search for the key frame starts earlier."""

TimeReader = Callable[[bytes], IntArray]


@dataclass(frozen=True, slots=True)
class Clip:
    """A clip of a video.

    Attributes:
        data: the MP4 file.
        times_ns: presentation time within the clip of each wanted frame, ns, shape (n,).
        how: one sentence on how the picture was made.
    """

    data: bytes
    times_ns: IntArray
    how: str


def cut_clip(
    path: VideoSource,
    frames: Frames,
    read_times: TimeReader,
    *,
    table: FrameTable | None = None,
    limits: VideoLimits | None = None,
    exact: bool = False,
) -> Clip:
    """Cut the part of a video that shows some frames.

    Args:
        path: the video.
        frames: the frames.
        read_times: returns the presentation times in ns of all pictures of an MP4 file as the viewer reads them.
        table: the video's frame table; it makes seeking fast if pictures are re-encoded.
        limits: limits on the file.
        exact: copy the packets however many bytes they take.

    Raises:
        VideoError: the video cannot be read.
        UsageError: the clip is too large for a viewer.
    """
    allowed = VideoLimits() if limits is None else limits
    try:
        data, wanted, how = _copy_packets(path, frames, allowed, exact)
        return Clip(data, _times_of_wanted(read_times(data), wanted), how)
    except UnfitPackets as error:
        cause = str(error)
    except (av.FFmpegError, OSError) as error:
        cause = f"its packets cannot be copied ({error_reason(error)})"
    data = encode_frames(path, frames, allowed, table)
    _check_size(path, len(data))
    times_ns = _times_of_wanted(read_times(data), np.arange(len(frames)))
    return Clip(data, times_ns, f"Re-encoded as H.264, because {cause}.")


def _times_of_wanted(times_ns: IntArray, wanted: IntArray) -> IntArray:
    """Times of the wanted pictures, given by their rank in the clip."""
    if len(times_ns) <= int(wanted[-1]):
        raise UnfitPackets(f"the copy holds {len(times_ns)} pictures where {int(wanted[-1]) + 1} were expected")
    found: IntArray = np.sort(times_ns)[wanted]
    return found


def _copy_packets(path: VideoSource, frames: Frames, limits: VideoLimits, exact: bool) -> tuple[bytes, IntArray, str]:
    """The packets as an MP4 file, the ranks of the wanted frames among its pictures, and a sentence on their origin."""
    if (frames.pts < 0).any():
        raise UnfitPackets("the run does not know its presentation times")
    with open_source(path) as file, open_container(file, limits) as (container, stream, kind):
        codec = str(stream.codec_context.codec.name)
        codec = {"libdav1d": "av1", "libaom-av1": "av1", "libvpx-vp9": "vp9"}.get(codec, codec)
        if kind.address == "position":
            raise UnfitPackets("AVI files store no presentation times")
        check_kind(kind)
        if codec not in PLAYABLE_CODECS:
            raise UnfitPackets(f"viewers do not play {codec}")
        if _orientation(container, stream) != Orientation():
            raise UnfitPackets("the picture is stored rotated")
        packets = select_packets(container, stream, frames.pts)
        size = sum(packet.size for packet in packets)
        _check_size(path, size)
        pts = presentation_times(packets)
        budget = size_limit(len(frames), frames.width, frames.height)
        if size > budget and not exact:
            encoded = encode_packets(stream, packets, frames.pts, budget)
            if encoded is not None and len(encoded) < size:
                encoded_mb = len(encoded) / 1e6
                how = f"Re-encoded as H.264 in {encoded_mb:.1f} MB, because its packets take {size / 1e6:.1f} MB."
                return encoded, np.arange(len(frames)), how
        target = BytesIO()
        copy_packets(target, stream, packets, pts, "mp4")
        how = f"The packets of the video ({codec}), not re-encoded."
        return target.getvalue(), np.searchsorted(pts, frames.pts), how


def _check_size(path: VideoSource, size: int) -> None:
    if size > MAX_BYTES:
        raise UsageError(
            f"The pictures of these frames of {path} take {size >> 20} MiB, more than the {MAX_BYTES >> 20} MiB that "
            "a viewer can hold. Choose a shorter range, or leave the picture out."
        )


def _orientation(container: InputContainer, stream: av.VideoStream) -> Orientation:
    with suppress(av.FFmpegError, OSError, StopIteration):
        return Orientation.from_frame(next(iter(container.decode(stream))))
    return Orientation()


def select_packets(container: InputContainer, stream: av.VideoStream, wanted: IntArray) -> list[av.Packet]:
    """Packets in decoding order, from the last key frame before the first wanted picture to the last one needed."""
    base = Fraction(stream.time_base)
    for margin in _SEEK_MARGINS_S:
        try:
            container.seek(int(wanted[0] - margin / base), stream=stream, backward=True)
        except (av.FFmpegError, OSError):
            continue
        if chosen := _collect_packets(container, stream, wanted):
            return chosen
    container.seek(-(2**40), stream=stream, backward=True)
    if chosen := _collect_packets(container, stream, wanted):
        return chosen
    raise UnfitPackets("no key frame comes before the first of the frames")


def _collect_packets(container: InputContainer, stream: av.VideoStream, wanted: IntArray) -> list[av.Packet]:
    """Packets from the last key frame before the first wanted picture; empty if the search ended too late."""
    chosen: list[av.Packet] = []
    missing = set(wanted.tolist())
    key: av.Packet | None = None
    for packet in timed_packets(container, stream):
        if packet.is_keyframe:
            key = packet
            if packet.pts <= wanted[0] and len(missing) == len(wanted):
                chosen.clear()  # a later key frame to start from
            elif not chosen:
                return []
        elif key is None or packet.pts < chosen[0].pts:
            continue  # its references are not in the clip
        elif packet.pts < key.pts:
            # Shown before a key frame that is decoded earlier: a seek to that key frame would break this picture.
            key.is_keyframe = False
        chosen.append(packet)
        missing.discard(packet.pts)
        if not missing:
            return chosen
    if not chosen:
        return []
    raise missing_packets_error(len(missing))
