"""Cuts the clip of a bundle out of a video by copying packets, so that every picture decodes to the same bits.

Both are decoded to verify the copy. If packets cannot be copied or decode differently, the pictures are stored without
loss instead.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from av.container import InputContainer

from tsr_engine.bundle.layout import CLIP_STEM
from tsr_engine.errors import TsrError, UsageError, VideoError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video import Frame, Video, open_video
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
from tsr_engine.records import Picture

MAX_BYTES = 4 << 30
"""Largest clip, bytes."""
_TICKS_PER_SECOND = 1000
"""Time base of the lossless clip, ticks per second."""


@dataclass(frozen=True, slots=True)
class ClipFrame:
    """One frame of the range.

    Attributes:
        ordinal: ordinal in the video.
        clip: ordinal in the clip.
        seconds: presentation time in the video.
        digest: hash of the decoded picture, see ``picture_digest``.
    """

    ordinal: int
    clip: int
    seconds: float
    digest: str


@dataclass(frozen=True, slots=True)
class Clip:
    """A clip of a video.

    Attributes:
        path: the file.
        offset: ordinal of the clip's first frame in the video.
        frames: the frames of the range.
        copied: whether the packets are the video's own.
        how: one sentence on how the clip was made.
    """

    path: Path
    offset: int
    frames: tuple[ClipFrame, ...]
    copied: bool
    how: str


def picture_digest(picture: Picture) -> str:
    """SHA-256 of a decoded picture's size and BGR bytes, hex."""
    digest = hashlib.sha256(f"{picture.shape[1]}x{picture.shape[0]}\n".encode())
    digest.update(np.ascontiguousarray(picture).data)
    return digest.hexdigest()


def cut_clip(
    path: VideoSource,
    start: int,
    stop: int,
    folder: Path,
    *,
    table: FrameTable | None = None,
    limits: VideoLimits | None = None,
    progress: Callable[[int], None] = lambda _done: None,
) -> Clip:
    """Cut frames ``start <= k < stop`` out of a video.

    Args:
        path: the video.
        start: first frame.
        stop: frame after the last.
        folder: where the clip goes.
        table: the video's frame table; None: not known.
        limits: limits on the file.
        progress: called with the number of frames read; the range is read twice.

    Raises:
        VideoError: the video cannot be read, or ends before ``stop``.
        UsageError: the clip would be too large.
    """
    allowed = VideoLimits() if limits is None else limits
    with open_video(path, limits=allowed, table=table) as video:
        decoded = []
        for frame in video.frames(start, stop):
            decoded.append((frame.ordinal, frame.seconds, picture_digest(frame.picture)))
            progress(len(decoded))
        if len(decoded) != stop - start:
            raise VideoError(f"{path} ends at frame {start + len(decoded) - 1}. Expected frames up to {stop - 1}.")
        try:
            clip_path, offset = _copy(video, start, stop, folder, allowed)
            clip = Clip(
                clip_path, offset, _clip_frames(decoded, offset), True, "The packets of the video, not re-encoded."
            )
            _verify(clip, allowed, progress)
        except UnfitPackets as error:
            cause = str(error)
        except (av.FFmpegError, OSError) as error:
            cause = f"its packets cannot be copied ({error_reason(error)})"
        except TsrError:
            cause = "the copy cannot be read"
        else:
            return clip
        for leftover in folder.glob(f"{CLIP_STEM}.*"):
            leftover.unlink()
        clip_path = _store_lossless(video, start, stop, folder)
    how = f"Every picture re-encoded without loss (FFV1), because {cause}."
    clip = Clip(clip_path, start, _clip_frames(decoded, start), False, how)
    try:
        _verify(clip, allowed, progress)
    except UnfitPackets as error:
        raise VideoError(f"The frames {start} to {stop - 1} of {path} cannot be copied: {error}.") from None
    return clip


def _clip_frames(decoded: list[tuple[int, float, str]], offset: int) -> tuple[ClipFrame, ...]:
    return tuple(ClipFrame(ordinal, ordinal - offset, seconds, digest) for ordinal, seconds, digest in decoded)


def _verify(clip: Clip, limits: VideoLimits, progress: Callable[[int], None]) -> None:
    """Check that every picture of the clip equals the video's, bit by bit."""
    count = len(clip.frames)
    with open_video(clip.path, limits=limits) as video:
        seen = 0
        for wanted, frame in zip(clip.frames, video.frames(clip.frames[0].clip), strict=False):
            if picture_digest(frame.picture) != wanted.digest:
                raise UnfitPackets(f"frame {wanted.ordinal} decodes to another picture in the copy")
            seen += 1
            progress(count + seen)
    if seen != count:
        raise UnfitPackets(f"the copy holds {seen} of {count} frames")


def _copy(video: Video, start: int, stop: int, folder: Path, limits: VideoLimits) -> tuple[Path, int]:
    """Copy packets from the last key frame before the range; return the file and that key frame's ordinal."""
    table = video.table
    offset = table.key_at_or_before(start)
    if offset is None:
        raise UnfitPackets("no key frame comes before the first of the frames")
    if not np.array_equal(table.pts, table.stamps):
        raise UnfitPackets("the file stores no presentation times, or not for each picture its own")
    wanted = table.pts[offset:stop]
    if len(wanted) != stop - offset:
        raise UnfitPackets("the file does not list all of the frames")
    with open_container(video.file, limits) as (container, stream, kind):
        check_kind(kind)
        mp4 = kind.demuxer == "mov"
        packets = _packets(container, stream, wanted.tolist())
        target = folder / f"{CLIP_STEM}.{'mp4' if mp4 else 'mkv'}"
        # No dates and no random names, so that equal input gives equal bytes.
        copy_packets(
            target, stream, packets, presentation_times(packets), "mp4" if mp4 else "matroska", {"fflags": "+bitexact"}
        )
    return target, offset


def _packets(container: InputContainer, stream: av.VideoStream, wanted: list[int]) -> list[av.Packet]:
    """Packets in decoding order, from the one that shows the first wanted picture until all are found."""
    for seek_time in (wanted[0], -(2**40)):
        container.seek(seek_time, stream=stream, backward=True)
        if found := _collect_packets(container, stream, wanted):
            return found
    raise UnfitPackets("its key frame has no packet of its own")


def _collect_packets(container: InputContainer, stream: av.VideoStream, wanted: list[int]) -> list[av.Packet]:
    chosen: list[av.Packet] = []
    missing = set(wanted)
    size = 0
    for packet in timed_packets(container, stream):
        if not chosen and not (packet.pts == wanted[0] and packet.is_keyframe):
            continue
        if packet.pts < wanted[0]:
            continue  # its references are not in the clip
        if packet.is_discard:
            raise UnfitPackets("an edit list hides some of its pictures")
        size += packet.size
        if size > MAX_BYTES:
            raise UsageError(f"The clip would have more than {MAX_BYTES >> 30} GiB. Choose fewer frames.")
        chosen.append(packet)
        missing.discard(packet.pts)
        if not missing:
            return chosen
    if chosen:
        raise missing_packets_error(len(missing))
    return []


def _store_lossless(video: Video, start: int, stop: int, folder: Path) -> Path:
    """Store the upright pictures without loss, each independently."""
    target = folder / f"{CLIP_STEM}.mkv"
    with av.open(str(target), "w", format="matroska", options={"fflags": "+bitexact"}) as out:
        stream = out.add_stream("ffv1", rate=video.rate.limit_denominator(100_000))
        stream.width, stream.height, stream.pix_fmt = video.width, video.height, "bgr0"
        stream.codec_context.time_base = Fraction(1, _TICKS_PER_SECOND)
        stream.codec_context.sample_aspect_ratio = video.pixel_ratio
        stream.codec_context.thread_count = 1
        stream.codec_context.options = {"level": "3", "g": "1", "slicecrc": "1"}
        for packet in _encoded(stream, video.frames(start, stop)):
            out.mux(packet)
            if target.stat().st_size > MAX_BYTES:
                raise UsageError(f"The clip would have more than {MAX_BYTES >> 30} GiB. Choose fewer frames.")
    return target


def _encoded(stream: av.VideoStream, frames: Iterator[Frame]) -> Iterator[av.Packet]:
    first: Fraction | None = None
    last = -1
    for frame in frames:
        first = frame.time if first is None else first
        picture = av.VideoFrame.from_ndarray(frame.picture, format="bgr24").reformat(format="bgr0")
        last = max(last + 1, round((frame.time - first) * _TICKS_PER_SECOND))
        picture.pts, picture.time_base = last, Fraction(1, _TICKS_PER_SECOND)
        yield from stream.encode(picture)
    yield from stream.encode(None)
