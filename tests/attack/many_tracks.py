"""Small archives that unpack to very many tracks and boxes."""

from __future__ import annotations

from functools import cache

from tests.attack.damage import zipped

__all__ = ["FRAMES", "MAX_MEMORY_MB", "cvat_archive", "mot_archive"]

FRAMES = 75
"""Length of the video that they are for."""
MAX_MEMORY_MB = 600
"""Memory of the server during any import, MiB."""


@cache
def mot_archive(tracks: int, boxes: int = 1) -> bytes:
    """A ZIP of MOT rows with so many tracks of so many boxes each."""
    rows = "".join(
        f"{1 + (i + k) % FRAMES},{i + 1},{10 + i % 97},{10 + i % 43},20,20,1,1,1\n"
        for i in range(tracks)
        for k in range(boxes)
    )
    return zipped({"gt/gt.txt": rows.encode()})


def cvat_archive(tracks: int) -> bytes:
    """CVAT tracks of two key frames each, with all frames between them interpolated."""
    line = '<box frame="{}" xtl="10" ytl="10" xbr="30" ybr="30" outside="0" occluded="0" keyframe="1"/>'
    ends = line.format(0) + line.format(FRAMES - 1)
    rows = "".join(f'<track id="{i}" label="stop">{ends}</track>' for i in range(tracks))
    return zipped({"annotations.xml": f"<annotations><version>1.1</version>{rows}</annotations>".encode()})
