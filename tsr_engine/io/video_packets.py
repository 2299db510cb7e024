"""Copies packets of a part of a video into a new file without decoding and encoding them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Literal

import av
import numpy as np
from av.container import InputContainer
from numpy.typing import NDArray

from tsr_engine.io.video_kinds import Kind

IntArray = NDArray[np.int64]


class UnfitPackets(Exception):
    """Raised if packets cannot be copied; the message is the reason."""


def check_kind(kind: Kind) -> None:
    """Raise ``UnfitPackets`` for kinds of files whose packets are not copied."""
    if kind.demuxer not in ("mov", "matroska"):
        raise UnfitPackets(f"packets of {kind.name} files are not copied")


def timed_packets(container: InputContainer, stream: av.VideoStream) -> Iterator[av.Packet]:
    """The packets with content, in decoding order.

    Raises:
        UnfitPackets: a packet has no presentation time.
    """
    for packet in container.demux(stream):
        if packet.size:
            if packet.pts is None:
                raise UnfitPackets("its packets have no presentation times")
            yield packet


def missing_packets_error(missing: int) -> UnfitPackets:
    """The error for frames without a packet."""
    return UnfitPackets(f"{missing} of its frames have no packet of their own")


def presentation_times(packets: Sequence[av.Packet]) -> IntArray:
    """Presentation times of packets, ascending, in ticks of their stream, shape (n,).

    Raises:
        UnfitPackets: two packets have the same time.
    """
    pts = np.sort(np.array([packet.pts for packet in packets], np.int64))
    if (np.diff(pts) <= 0).any():
        raise UnfitPackets("two of its packets have the same presentation time")
    return pts


def copy_packets(
    target: Path | IO[bytes],
    stream: av.VideoStream,
    packets: Sequence[av.Packet],
    pts: IntArray,
    container_format: Literal["mp4", "matroska"],
    options: Mapping[str, str] | None = None,
) -> None:
    """Write packets as a file without an edit list; decoding times are computed, so that none is missing.

    Args:
        target: the new file.
        stream: the stream of the packets.
        packets: in decoding order, from a key frame on; their times are changed.
        pts: see ``presentation_times``.
        container_format: container of the file.
        options: further options of the muxer.
    """
    delay = int(max(int(p) - packet.pts for p, packet in zip(pts, packets, strict=True)))
    muxer_options = {**(options or {}), **({"use_editlist": "0"} if container_format == "mp4" else {})}
    with av.open(
        str(target) if isinstance(target, Path) else target, "w", format=container_format, options=muxer_options
    ) as out:
        copy = out.add_stream_from_template(stream)
        copy.time_base = stream.time_base
        start = int(pts[0])
        for decoding, packet in zip(pts, packets, strict=True):
            packet.pts += delay - start
            packet.dts = int(decoding) - start
            packet.stream = copy
            out.mux(packet)
