"""The frame table of a video, packed for the database and for the page."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np

from app.body_model import Model
from tsr_engine.errors import InputError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.models import ARCHIVE_ERRORS

_TIME = struct.Struct("<q")


class TableAnswer(Model):
    """The presentation time of each frame of a video, and the frames at which decoding can start."""

    frames: int
    time_base: tuple[int, int]
    """Numerator, denominator: pts * n / d = seconds."""
    first_pts: int
    steps: list[tuple[int, int]]
    """Runs of equal pts steps: [step, count]."""
    keys: list[int]
    """Ordinals of key frames."""
    corrupt: list[int]
    """Ordinals of damaged frames."""


def pack(table: FrameTable) -> bytes:
    """Pack a table as a deflated NumPy archive after eight bytes, in which earlier versions stored a time."""
    buffer = io.BytesIO()
    np.savez(buffer, **table.to_arrays())  # type: ignore[arg-type]
    return _TIME.pack(-1) + zlib.compress(buffer.getvalue(), 4)


def unpack(data: bytes) -> FrameTable:
    """Invert ``pack``.

    Raises:
        InputError: the data is damaged.
    """
    try:
        with np.load(io.BytesIO(zlib.decompress(data[_TIME.size :])), allow_pickle=False) as archive:
            return FrameTable.from_arrays(archive)
    except ARCHIVE_ERRORS as error:
        raise InputError(f"The frame table is damaged: {error}. Import the video again.") from None


def page_table(table: FrameTable) -> TableAnswer:
    """Convert a table for pages, with runs of equal time steps: a constant rate is one pair for any length."""
    steps = np.diff(table.pts)
    starts = np.flatnonzero(np.diff(steps, prepend=steps[:1] - 1)) if len(steps) else np.zeros(0, np.int64)
    counts = np.diff(np.append(starts, len(steps)))
    return TableAnswer(
        frames=len(table),
        time_base=(table.time_base.numerator, table.time_base.denominator),
        first_pts=int(table.pts[0]) if len(table) else 0,
        steps=[(int(steps[start]), int(count)) for start, count in zip(starts, counts, strict=True)],
        keys=np.flatnonzero(table.key).tolist(),
        corrupt=np.flatnonzero(table.corrupt).tolist(),
    )
