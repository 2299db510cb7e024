"""A contact sheet of drawings with their names: ``python -m tsr_engine.pictograms.sheet OUT.png [--set vienna]``.

For people who judge drawings; ``--size 32`` shows them as small as a page does. The ending of the file's name gives its
format: PNG or WebP.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.pictograms.drawn import draw, names

__all__ = ["main", "sheet"]

_GROUND: Final = 205
_MARGIN: Final = 4
_LINE: Final = 12
_LETTERS: Final = 0.33


def sheet(shown: Sequence[str], size: int = 110, columns: int = 14) -> NDArray[np.uint8]:
    """Drawings in rows, each above its name.

    Args:
        shown: names of drawings.
        size: side of a drawing, px.
        columns: drawings a row.

    Returns:
        (rows, columns, 3) picture, BGR.

    Raises:
        KeyError: no drawing has one of the names.
    """
    cells = [_cell(name, size) for name in shown]
    blank = np.full_like(cells[0], 255)
    cells += [blank] * (-len(cells) % columns)
    return np.vstack([np.hstack(cells[k : k + columns]) for k in range(0, len(cells), columns)])


def _cell(name: str, size: int) -> NDArray[np.uint8]:
    drawn = draw(name, size)
    alpha = drawn[..., 3:] / 255.0
    cell = np.full((size + 2 * _MARGIN + 2 * _LINE, size + 2 * _MARGIN, 3), 255, np.uint8)
    cell[_MARGIN : _MARGIN + size, _MARGIN : _MARGIN + size] = drawn[..., :3] * alpha + _GROUND * (1 - alpha)
    for k, line in enumerate(_two_lines(name.split("/", 1)[1], size // 6)):
        place = (_MARGIN, size + 2 * _MARGIN + _LINE * (k + 1) - 5)
        cv2.putText(cell, line, place, cv2.FONT_HERSHEY_SIMPLEX, _LETTERS, (0, 0, 0), 1, cv2.LINE_AA)
    return cell


def _two_lines(text: str, letters: int) -> tuple[str, str]:
    """A key cut into two lines, at a hyphen where there is one."""
    if len(text) <= letters:
        return text, ""
    cut = text.rfind("-", 0, letters) + 1 or letters
    return text[:cut], text[cut : cut + letters]


def main(arguments: Sequence[str] | None = None) -> None:
    """Write a sheet, as the command line says.

    Raises:
        SystemExit: the arguments are wrong, or the file cannot be written.
    """
    families = sorted({name.split("/", 1)[0] for name in names()})
    parser = argparse.ArgumentParser(prog="python -m tsr_engine.pictograms.sheet", description="A sheet of drawings.")
    parser.add_argument("out", help="picture to write, .png or .webp")
    parser.add_argument("--set", choices=families, help="only the drawings of this family; without it, all")
    parser.add_argument("--size", type=int, default=110, help="side of a drawing, px")
    parser.add_argument("--columns", type=int, default=14, help="drawings a row")
    given = parser.parse_args(arguments)
    if given.size < 8 or given.columns < 1:
        parser.error("--size must be at least 8 and --columns at least 1")
    shown = [name for name in names() if given.set is None or name.startswith(f"{given.set}/")]
    try:
        quality = [cv2.IMWRITE_WEBP_QUALITY, 60] if given.out.endswith(".webp") else []
        written = cv2.imwrite(given.out, sheet(shown, given.size, given.columns), quality)
    except cv2.error:
        parser.error(f"{given.out}: a picture's name must end in .png or .webp")
    if not written:
        parser.error(f"{given.out} cannot be written: make its folder first")
    print(f"{given.out}: {len(shown)} drawings")


if __name__ == "__main__":
    main()
