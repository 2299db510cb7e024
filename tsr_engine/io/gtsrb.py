"""GTSRB on disk: class folders with their tables, the test table, and splits by track.

::

    ROOT/00000/GT-00000.csv        Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2;ClassId
    ROOT/00000/00003_00029.ppm     track 3 of class 0, frame 29 (far to near); .jpg and .png are read as well
    TEST/GT-final_test.csv         the same columns, ClassId optional; the pictures lie beside the table
    ROOT/Train.csv                 Width,Height,Roi.X1,...,ClassId,Path (Kaggle); the paths begin beside the table

Columns may have any order, be separated by semicolons, commas or tabs, and be written ``RoiX1`` or ``Roi_X1``. A row
may end with one more separator.

ROI corners are read as pixel edges, ``X2, Y2`` exclusive. Source: Readme of the benchmark (Stallkamp et al. 2012).
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from tsr_engine.errors import InputError
from tsr_engine.io.pictures import SUFFIXES
from tsr_engine.io.plain_numbers import parse_whole
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import Picture

_ROI_COLUMNS = ("Roi.X1", "Roi.Y1", "Roi.X2", "Roi.Y2")
_COLUMNS = ("Filename", "Path", "Width", "Height", *_ROI_COLUMNS, "ClassId")
_TRACK_NAME = re.compile(r"^(?:\d{5}_)?(\d{5})_(\d{5})$")
"""Track and frame; Kaggle puts the class before them."""


@dataclass(frozen=True, slots=True)
class CropItem:
    """A picture of a sign with its annotation."""

    path: Path
    roi: tuple[int, int, int, int] | None = None
    """The sign's box ``x1, y1, x2, y2`` in px; None: not given."""
    class_id: int | None = None
    track: tuple[int, int] | None = None
    """``(class folder, track number)``, shared by all pictures of one physical sign; None: not known."""
    frame: int | None = None
    """Running number within the track, far to near."""

    @property
    def filename(self) -> str:
        """Name without folders."""
        return self.path.name


def read_items(source: Path) -> list[CropItem]:
    """Read the crops of a tree of class folders, one class folder, a table, or a folder of loose pictures.

    Args:
        source: a folder or a ``.csv`` file.

    Returns:
        Items in the order of the tables; loose pictures by name, without ROI.

    Raises:
        InputError: nothing readable is there, or a table is damaged.
    """
    if source.is_file():
        return read_table(source)
    if not source.is_dir():
        raise InputError(f"Expected a GTSRB folder or a .csv table at {source}, found nothing. Check the path.")
    tables = sorted(source.glob("GT-*.csv"))
    if tables:
        return [item for table in tables for item in read_table(table)]
    folders = sorted(p for p in source.iterdir() if p.is_dir() and any(p.glob("GT-*.csv")))
    if folders:
        return [item for folder in folders for item in read_items(folder)]
    loose = sorted(p for p in source.iterdir() if p.suffix.lower() in SUFFIXES)
    if not loose:
        raise InputError(
            f"Expected class folders with GT-*.csv tables, or pictures, in {source}, found neither. Check the path."
        )
    return [CropItem(path) for path in loose]


def read_table(table: Path) -> list[CropItem]:
    """Read the crops listed by one table.

    Raises:
        InputError: the table is unreadable, has wrong columns, or a bad value; names file and line.
    """
    try:
        text = table.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(
            f"Expected a GTSRB table in text at {table}, got something else. Put single pictures into a folder and "
            "name that."
        ) from None
    except OSError as error:
        raise InputError(f"Cannot read the table {table}: {error.strerror}. Check the path.") from None
    items = [
        _item(table, line, row)
        for line, row in table_rows(text, lambda line, rule: InputError(f"{table}, line {line}: {rule}"))
    ]
    if not items:
        raise InputError(f"{table} lists no pictures. Use a GTSRB table with at least one row.")
    return items


def table_rows(text: str, make_error: Callable[[int, str], Exception]) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield line number and cells of a table's rows, under the benchmark's column names.

    Args:
        text: the table.
        make_error: makes an error from a line and a rule.

    Yields:
        Line and cells; ``Path`` and ``ClassId`` only if the table has them.
    """
    first_line = text.split("\n", 1)[0]
    delimiter = max(";,\t", key=first_line.count)
    names: list[str] = []
    reader = csv.reader(text.splitlines(), delimiter=delimiter)
    for cells in reader:
        values = [cell.strip() for cell in cells]
        if names and not any(values):
            continue
        while values and not values[-1] and len(values) > len(names):
            values.pop()
        if not names:
            known = {_plain(name): name for name in _COLUMNS}
            names = [known.get(_plain(cell), cell) for cell in values]
            file_column = () if {"Filename", "Path"} & set(names) else ("Filename",)
            missing = [name for name in (*file_column, *_ROI_COLUMNS) if name not in names]
            if missing:
                raise make_error(
                    1,
                    "expected the columns Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2[;ClassId], "
                    f"found {delimiter.join(values) or 'nothing'}; {', '.join(missing)} missing. Use a GTSRB table.",
                )
            continue
        if len(values) > len(names):
            raise make_error(reader.line_num, f"expected {len(names)} cells, found {len(values)}. Correct the line.")
        yield reader.line_num, dict(zip(names, values, strict=False))
    if not names:
        raise make_error(
            1, "expected the columns Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2[;ClassId], found nothing."
        )


def _plain(name: str) -> str:
    return "".join(letter for letter in name.lower() if letter.isalnum())


def _item(table: Path, line: int, row: dict[str, str]) -> CropItem:
    where = f"{table}, line {line}"
    path = row.get("Path", "").replace("\\", "/")
    name = row.get("Filename", "") or path
    if not path and (not name or Path(name).name != name):
        raise InputError(f"{where}: expected a file name without folders, found {name!r}. Correct the line.")
    if path and (path.startswith("/") or ":" in path or ".." in path.split("/")):
        raise InputError(f"{where}: expected a path below the table's folder, found {path!r}. Correct the line.")
    x1, y1, x2, y2 = (_integer(where, column, row.get(column)) for column in _ROI_COLUMNS)
    if not (0 <= x1 < x2 and 0 <= y1 < y2):
        raise InputError(
            f"{where}: expected 0 <= X1 < X2 and 0 <= Y1 < Y2, found {x1};{y1};{x2};{y2}. Correct the ROI."
        )
    class_id = _integer(where, "ClassId", row["ClassId"]) if row.get("ClassId") not in (None, "") else None
    if class_id is not None and not 0 <= class_id < CLASS_COUNT:
        raise InputError(f"{where}: expected a ClassId in 0..{CLASS_COUNT - 1}, found {class_id}. Correct the line.")
    match = _TRACK_NAME.match(Path(name).stem)
    crop = table.parent / (path or name), (x1, y1, x2, y2), class_id
    if match is None or class_id is None:
        return CropItem(*crop)
    return CropItem(*crop, track=(class_id, int(match[1])), frame=int(match[2]))


def _integer(where: str, column: str, value: str | None) -> int:
    try:
        return parse_whole(value or "")
    except ValueError:
        raise InputError(f"{where}: expected a whole number in {column}, found {value!r}. Correct the line.") from None


def read_picture(item: CropItem) -> Picture:
    """Decode a crop's picture as BGR, uint8, shape (h, w, 3).

    Raises:
        InputError: the file is missing, not a picture, or smaller than its ROI.
    """
    try:
        content = np.frombuffer(item.path.read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise InputError(f"Cannot read the picture {item.path}: {error.strerror}. Check the table beside it.") from None
    picture = cv2.imdecode(content, cv2.IMREAD_COLOR) if content.size else None
    if picture is None:
        raise InputError(f"{item.path} is not a readable picture. Restore the file.")
    height, width = picture.shape[:2]
    if item.roi is not None and (item.roi[2] > width or item.roi[3] > height):
        raise InputError(f"{item.path} is {width}x{height} px, but its ROI ends at {item.roi[2:]}. Correct the table.")
    return np.ascontiguousarray(picture, dtype=np.uint8)


def split_by_track(items: Sequence[CropItem], share: float, seed: int) -> tuple[list[CropItem], list[CropItem]]:
    """Split into training and held-out items so that no track is on both sides.

    Stratified by class: of each class with at least two tracks, at least one track is held out and one is kept.
    scikit-learn's ``StratifiedGroupKFold`` guarantees neither, and would choose other tracks than those on which the
    shipped models were evaluated.

    Args:
        items: items with a known track.
        share: share of each class's tracks to hold out, in (0, 1).
        seed: random seed.

    Returns:
        ``(training, held out)``, each in the order of ``items``.

    Raises:
        ValueError: a share outside (0, 1).
        InputError: an item without a track.
    """
    if not 0 < share < 1:
        raise ValueError(f"share must be in (0, 1). Got {share} instead.")
    generator = np.random.default_rng(seed)
    held_out: set[tuple[int, int]] = set()
    by_class: dict[int, set[tuple[int, int]]] = {}
    for item in items:
        by_class.setdefault(_track(item)[0], set()).add(_track(item))
    for class_id in sorted(by_class):
        tracks = sorted(by_class[class_id])
        if len(tracks) < 2:
            continue
        count = min(max(1, math.floor(share * len(tracks) + 0.5)), len(tracks) - 1)
        held_out.update(tracks[i] for i in generator.permutation(len(tracks))[:count])
    return [i for i in items if i.track not in held_out], [i for i in items if i.track in held_out]


def folds_by_track(items: Sequence[CropItem], count: int, seed: int) -> list[list[CropItem]]:
    """Split items into parts of about equal size, stratified by class, with each track in one part.

    The first part equals the held-out part of :func:`split_by_track` at a share of ``1 / count``.

    Args:
        items: items with a known track.
        count: number of parts, >= 2.
        seed: random seed.

    Raises:
        ValueError: fewer than two parts.
        InputError: an item without a track.
    """
    if count < 2:
        raise ValueError(f"count must be at least 2. Got {count} instead.")
    parts = []
    for remaining in range(count, 1, -1):
        items, part = split_by_track(items, 1 / remaining, seed)
        parts.append(part)
    return [*parts, list(items)]


def tracks_of(items: Iterable[CropItem]) -> dict[tuple[int, int], list[CropItem]]:
    """Items by track, far to near.

    Raises:
        InputError: an item without a track.
    """
    tracks: dict[tuple[int, int], list[CropItem]] = {}
    for item in items:
        tracks.setdefault(_track(item), []).append(item)
    return {key: sorted(tracks[key], key=lambda i: i.frame or 0) for key in sorted(tracks)}


def _track(item: CropItem) -> tuple[int, int]:
    if item.track is None:
        raise InputError(
            f"Expected a training picture named TTTTT_FFFFF with a ClassId, got {item.path}. "
            "Tracks are only known for the GTSRB training folders."
        )
    return item.track
