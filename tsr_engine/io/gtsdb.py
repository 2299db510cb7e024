"""Reader of the German Traffic Sign Detection Benchmark (Houben et al., IJCNN 2013).

A folder holds the scenes and ``gt.txt`` with one line a sign::

    00000.jpg;774;411;815;446;11        file;left;top;right;bottom;class

The four numbers are *inclusive* pixel indices: on round signs of 28 px and more the centre of the rim lies a
median 0.5 px right of and below ``(left + right) / 2, (top + bottom) / 2`` in pixel-edge coordinates, which is
where the inclusive reading puts it. A box therefore is ``left, top, right + 1, bottom + 1``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import InputError
from tsr_engine.io.pictures import announced_size
from tsr_engine.records import FloatArray

CLASSES = 43
GROUND_TRUTH_FILE = "gt.txt"
_SUFFIXES = (".ppm", ".png", ".jpg", ".jpeg")


@dataclass(frozen=True, slots=True)
class Scene:
    """One annotated picture.

    Attributes:
        name: file name of the picture, for example ``00000.jpg``.
        path: the picture.
        boxes: shape (n, 4), float64, pixel edges; n may be 0.
        class_ids: shape (n,), int64, in 0..42.
        ignored: shape (m, 4), px: regions without annotation, which training leaves alone.
    """

    name: str
    path: Path
    boxes: FloatArray
    class_ids: NDArray[np.int64]
    ignored: FloatArray = field(default_factory=lambda: np.zeros((0, 4)))

    @property
    def occupied(self) -> FloatArray:
        """All regions that are not background: signs and ignored regions, shape (n + m, 4)."""
        return np.concatenate([self.boxes, self.ignored]) if len(self.ignored) else self.boxes


def read_gtsdb(folder: Path) -> list[Scene]:
    """Read all scenes of a GTSDB folder, sorted by name, including scenes without signs.

    A row's picture is found by its stem, so the original ``gt.txt``, which names ``.ppm`` files, also fits a folder of
    converted pictures.

    Args:
        folder: the folder with the pictures and ``gt.txt``.

    Raises:
        InputError: a missing folder, no ``gt.txt``, no pictures, an invalid row (with its line number), a row whose
            picture is missing or smaller than its box, or one box with two classes.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"Expected a folder of GTSDB scenes at {folder}, found none. Name an existing folder.")
    pictures = {p.stem: p for p in sorted(folder.iterdir()) if p.suffix.lower() in _SUFFIXES}
    truth = folder / GROUND_TRUTH_FILE
    try:
        lines = truth.read_text(encoding="utf-8-sig").splitlines()
    except FileNotFoundError:
        raise InputError(
            f"Expected {GROUND_TRUTH_FILE} beside the scenes in {folder}, found none. Name a GTSDB folder."
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"Cannot read {truth} as text: {error}. Save it as UTF-8 text.") from None
    if not pictures:
        raise InputError(f"Expected GTSDB scenes (.ppm, .png or .jpg) in {folder}, found none. Unpack them there.")
    rows = _read_rows(lines, truth, pictures)
    return [_scene(path, rows.get(stem, [])) for stem, path in sorted(pictures.items())]


def _scene(path: Path, rows: list[tuple[int, ...]]) -> Scene:
    table = np.array(rows, dtype=np.int64).reshape(-1, 5)
    boxes = table[:, :4] + np.array([0, 0, 1, 1])
    return Scene(path.name, path, boxes.astype(np.float64), table[:, 4].copy())


def _read_rows(lines: Iterable[str], truth: Path, pictures: dict[str, Path]) -> dict[str, list[tuple[int, ...]]]:
    """Parse rows ``left, top, right, bottom, class``, by the stem of their picture.

    A row that is there twice is read twice: one of the benchmark's is.
    """
    rows: dict[str, list[tuple[int, ...]]] = {}
    read: dict[tuple[str, tuple[int, ...]], tuple[int, int]] = {}
    sizes: dict[str, tuple[int, int] | None] = {}
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        stem, values = _parse(line, f"{truth}, line {number}")
        if stem not in pictures:
            raise InputError(
                f"{truth}, line {number}: the picture {line.split(';')[0]} is not in {truth.parent}. "
                "Restore it or remove its lines."
            )
        if stem not in sizes:
            sizes[stem] = announced_size(pictures[stem])
        width, height = sizes[stem] or (values[2] + 1, values[3] + 1)
        if values[2] >= width or values[3] >= height:
            raise InputError(
                f"{truth}, line {number}: the box ends outside {pictures[stem].name}, which has {width}x{height} px. "
                "Correct the line, or use the picture that was annotated."
            )
        class_id, first = read.setdefault((stem, values[:4]), (values[4], number))
        if class_id != values[4]:
            raise InputError(
                f"{truth}, line {number}: the box of line {first} is here again, with class {values[4]} in place of "
                f"{class_id}. Remove the wrong line."
            )
        rows.setdefault(stem, []).append(values)
    return rows


def _parse(line: str, where: str) -> tuple[str, tuple[int, ...]]:
    fields = [part.strip() for part in line.split(";")]
    try:
        if len(fields) != 6:
            raise ValueError(f"{len(fields)} fields")
        left, top, right, bottom, class_id = (int(part) for part in fields[1:])
    except ValueError:
        raise InputError(
            f"{where}: expected file;left;top;right;bottom;class with whole numbers, got {line.strip()!r}. "
            "Correct the line."
        ) from None
    if not (0 <= left <= right and 0 <= top <= bottom):
        raise InputError(f"{where}: expected 0 <= left <= right and 0 <= top <= bottom, got {line.strip()!r}.")
    if not 0 <= class_id < CLASSES:
        raise InputError(f"{where}: expected a class in 0..{CLASSES - 1}, got {class_id}. Correct the line.")
    return Path(fields[0]).stem, (left, top, right, bottom, class_id)
