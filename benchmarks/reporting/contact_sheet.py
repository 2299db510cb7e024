"""A sheet of numbered cut-outs as a small PNG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from tsr_engine.records import FloatArray, Picture

SIDE = 84
"""Side of a cut-out on the sheet, px."""
LABEL = 16
"""Height of the strip with its label, px."""
LEVELS = 12
"""Steps of each colour channel; these few save two thirds of the bytes."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One cut-out.

    Attributes:
        label: short text.
        picture: BGR, uint8.
        box: ``x1, y1, x2, y2`` of the object, px.
    """

    label: str
    picture: Picture
    box: Sequence[float] | FloatArray


def cut_square(picture: Picture, box: Sequence[float] | FloatArray, margin: float, side: int) -> Picture:
    """The square around a box with ``margin`` of its longer side on each side, borders replicated.

    Returns:
        Picture of ``side`` x ``side`` px, without marks.
    """
    x1, y1, x2, y2 = (float(v) for v in box)
    half = max(x2 - x1, y2 - y1, 1.0) * (0.5 + margin)
    scale = side / (2 * half)
    move = np.array([
        [scale, 0, side / 2 - scale * (x1 + x2) / 2],
        [0, scale, side / 2 - scale * (y1 + y2) / 2],
    ])  # fmt: skip
    flags = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    view: Picture = cv2.warpAffine(picture, move, (side, side), flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return view


def grid(cells: Sequence[tuple[str, Picture]], side: int, columns: int) -> Picture:
    """Square pictures of ``side`` px in rows, each below its text."""
    rows, columns = -(-len(cells) // columns), min(columns, len(cells))
    page = np.full((rows * (side + LABEL + 4), columns * (side + 4), 3), 255, np.uint8)
    for number, (text, view) in enumerate(cells):
        row, column = divmod(number, columns)
        top, left = row * (side + LABEL + 4), column * (side + 4)
        page[top + LABEL : top + LABEL + side, left : left + side] = view
        place = (left + 2, top + LABEL - 4)
        cv2.putText(page, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.42, (0, 0, 0), 1, cv2.LINE_AA)
    return page


def write_sheet(path: Path, cells: Sequence[Cell], *, margin: float = 0.6, columns: int = 10) -> None:
    """Write the sheet, row by row; without cells, remove an existing file."""
    if not cells:
        path.unlink(missing_ok=True)
        return
    step = 255 / (LEVELS - 1)
    views = ((cell.label, cut_square(cell.picture, cell.box, margin, SIDE)) for cell in cells)
    sheet = grid([(label, np.round(np.round(view / step) * step)) for label, view in views], SIDE, columns)
    path.parent.mkdir(parents=True, exist_ok=True)
    written, data = cv2.imencode(".png", sheet, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    assert written
    path.write_bytes(data.tobytes())
