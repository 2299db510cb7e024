"""A sheet of numbered cut-outs as a small PNG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from tsr_engine.records import FloatArray, Picture

__all__ = ["Cell", "cut_square", "write_sheet"]

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


def write_sheet(path: Path, cells: Sequence[Cell], *, margin: float = 0.6, columns: int = 10) -> None:
    """Write the sheet, row by row; without cells, remove an existing file."""
    if not cells:
        path.unlink(missing_ok=True)
        return
    rows = -(-len(cells) // columns)
    columns = min(columns, len(cells))
    sheet = np.full((rows * (SIDE + LABEL + 4), columns * (SIDE + 4), 3), 255, np.uint8)
    for number, cell in enumerate(cells):
        row, column = divmod(number, columns)
        top, left = row * (SIDE + LABEL + 4), column * (SIDE + 4)
        view = cut_square(cell.picture, cell.box, margin, SIDE)
        step = 255 / (LEVELS - 1)
        sheet[top + LABEL : top + LABEL + SIDE, left : left + SIDE] = np.round(np.round(view / step) * step)
        place = (left + 2, top + LABEL - 4)
        cv2.putText(sheet, cell.label, place, cv2.FONT_HERSHEY_SIMPLEX, 0.42, (0, 0, 0), 1, cv2.LINE_AA)
    path.parent.mkdir(parents=True, exist_ok=True)
    written, data = cv2.imencode(".png", sheet, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    assert written
    path.write_bytes(data.tobytes())
