"""The beginning of a sample drive as a separate file, with signs in view from its first frame on."""

from __future__ import annotations

from pathlib import Path

import av

from sample_videos import SHIPPED

__all__ = ["write_short_drive"]


def write_short_drive(path: Path, frames: int) -> Path:
    """Copy the packets of the first ``frames`` frames without encoding them again."""
    with av.open(str(SHIPPED[0].video)) as source, av.open(str(path), "w") as target:
        stream = source.streams.video[0]
        copy = target.add_stream_from_template(stream)
        for packet in list(source.demux(stream))[:frames]:
            packet.stream = copy
            target.mux(packet)
    return path
