"""Rows of ground truth: from strict CSV, and packed for the database."""

from __future__ import annotations

import csv
import math
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.errors import Invalid
from tsr_engine.recognition.catalogue import CLASS_COUNT

__all__ = ["COLUMNS", "pack", "parse", "unpack"]

COLUMNS = ("frame", "track_id", "x1", "y1", "x2", "y2", "class_id", "visibility", "ignore")
"""Header of the CSV, and order of the packed columns."""
FAR = 1e5
MOST_ROWS = 2_000_000

Rows = NDArray[np.float64]


def parse(content: bytes, frames: int | None) -> Rows:
    """The rows of a CSV, ordered by frame, then by track.

    Args:
        content: UTF-8 text with the header ``COLUMNS``.
        frames: length of the video; unset: not known, so that no frame lies beyond it.

    Returns:
        Shape (n, 9), columns as in ``COLUMNS``.

    Raises:
        Invalid: with the first line that breaks a rule, and the rule.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _bad(content[: error.start].count(b"\n") + 1, "the text must be UTF-8") from None
    lines = text.splitlines()
    if not lines or tuple(lines[0].split(",")) != COLUMNS:
        got = lines[0][:120] if lines else "an empty file"
        raise _bad(1, f"the header must be {','.join(COLUMNS)}, got {got}")
    if len(lines) - 1 > MOST_ROWS:
        raise _bad(MOST_ROWS + 2, f"a file holds at most {MOST_ROWS} rows")
    table = np.empty((len(lines) - 1, len(COLUMNS)))
    used = 0
    seen: dict[tuple[float, float], int] = {}
    for number, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        row = _row(number, line, frames)
        if (row[0], row[1]) in seen:
            first = seen[row[0], row[1]]
            raise _bad(number, f"a track has one box a frame; line {first} has this frame and track already")
        seen[row[0], row[1]] = number
        table[used] = row
        used += 1
    table = table[:used]
    return np.ascontiguousarray(table[np.lexsort((table[:, 1], table[:, 0]))])


def pack(rows: Rows) -> bytes:
    """For the table ``truths``: little-endian float64, row by row, deflated."""
    return zlib.compress(np.ascontiguousarray(rows, dtype="<f8").tobytes(), 6)


def unpack(data: bytes) -> Rows:
    """The inverse of ``pack``; shape (n, 9)."""
    return np.frombuffer(zlib.decompress(data), "<f8").reshape(-1, len(COLUMNS))


def _row(number: int, line: str, frames: int | None) -> Sequence[float]:
    cells = next(csv.reader([line]), [])
    if len(cells) != len(COLUMNS):
        raise _bad(number, f"a row has {len(COLUMNS)} values, got {len(cells)}")
    values = []
    for name, cell in zip(COLUMNS, cells, strict=True):
        try:
            values.append(float(cell))
        except ValueError:
            raise _bad(number, f"{name} must be a number, got {cell[:40]!r}") from None
        if not math.isfinite(values[-1]):
            raise _bad(number, f"{name} must be finite, got {cell[:40]!r}")
    frame, track, x1, y1, x2, y2, label, visibility, ignore = values
    end = 2**31 if frames is None else frames
    for wrong, rule in (
        (frame != int(frame) or not 0 <= frame < end, f"frame must be a whole number from 0 to {end - 1}"),
        (track != int(track) or not 0 <= track < 2**53, "track_id must be a whole number from 0 on"),
        (not (x1 < x2 and y1 < y2), "a box needs x1 < x2 and y1 < y2"),
        (max(map(abs, (x1, y1, x2, y2))) > FAR, f"the edges of a box lie within {FAR:.0f} px"),
        (
            label != int(label) or not -1 <= label < CLASS_COUNT,
            f"class_id must be a whole number from -1 to {CLASS_COUNT - 1}",
        ),
        (not 0 <= visibility <= 1, "visibility must lie in 0 to 1"),
        (ignore not in (0, 1), "ignore must be 0 or 1"),
    ):
        if wrong:
            raise _bad(number, rule)
    return values


def _bad(line: int, rule: str) -> Invalid:
    return Invalid(f"Line {line}: {rule}. Nothing was imported.", field=f"line {line}", code="bad_truth")
