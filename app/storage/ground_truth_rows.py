"""Rows of ground truth: from strict CSV, and packed for the database."""

from __future__ import annotations

import zlib
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.errors import Invalid
from tsr_engine.evaluation.box_tables import TRUTH_COLUMNS, RowError, read_truth_table

COLUMNS: Final = TRUTH_COLUMNS
"""Header of the CSV, and order of the packed columns."""
MAX_ROWS: Final = 2_000_000

Rows = NDArray[np.float64]


def parse(content: bytes, frames: int | None) -> Rows:
    """Parse a CSV to rows, ordered by frame, then by track.

    Args:
        content: UTF-8 text with the header ``COLUMNS``.
        frames: length of the video; unset: unknown, so frames are not checked against it.

    Returns:
        Shape (n, 9), columns as in ``COLUMNS``.

    Raises:
        Invalid: a line breaks a rule; the message names the first one and the rule.
    """
    try:
        table = read_truth_table(content, frames, MAX_ROWS)
    except RowError as error:
        raise Invalid(
            f"Line {error.line}: {error.rule}. Nothing was imported.", field=f"line {error.line}", code="bad_truth"
        ) from None
    return np.ascontiguousarray(table[np.lexsort((table[:, 1], table[:, 0]))])


def pack(rows: Rows) -> bytes:
    """Pack rows for the table ``ground_truths``: little-endian float64, row by row, deflated."""
    return zlib.compress(np.ascontiguousarray(rows, dtype="<f8").tobytes(), 6)


def unpack(data: bytes) -> Rows:
    """Invert ``pack``; shape (n, 9)."""
    return np.frombuffer(zlib.decompress(data), "<f8").reshape(-1, len(COLUMNS))
