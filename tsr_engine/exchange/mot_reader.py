"""Reads MOT: ground truth (``gt/gt.txt``, nine columns) and results or detections (ten columns)."""

from __future__ import annotations

import configparser
import csv
import io
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.beside import is_called, is_wrapper, told_by_manifest
from tsr_engine.exchange.checks import Intake, read_text, refuse
from tsr_engine.exchange.dataset import UNSAID, Dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.linking import LooseBoxes
from tsr_engine.exchange.names import safe_stem
from tsr_engine.exchange.notes import notes_from_text
from tsr_engine.exchange.sidecar import read_rows, real
from tsr_engine.io.plain_numbers import real_number

__all__ = ["NAMES", "SIDE", "SIDE_COLUMNS", "read_mot", "sniff_mot"]

NAMES = "labels.txt"
SIDE = "tracks.csv"
SIDE_COLUMNS = ("id", "uid", "state", "source", "note")
_SEQUENCE = "seqinfo.ini"
_OCCLUDED = 0.5
"""Signs that are less visible count as occluded."""
_SUBSETS = ("train", "val", "test")
_BOX = range(2, 6)
"""Columns of the box, from 0."""


@dataclass(frozen=True, slots=True)
class _Sequence:
    """Where the parts of a sequence lie; ``root`` has ``seqinfo.ini``."""

    root: Path
    rows: Path


@dataclass(frozen=True, slots=True)
class _Counting:
    """Where numbers begin."""

    frame: int
    place: int
    label: int


def read_mot(path: Path, target: ImportTarget) -> Dataset:
    """Read a folder or one file of rows.

    Raises:
        ImportFormatError: a broken rule.
    """
    intake = Intake(target)
    switches = target.switches
    origin = switches.get("origin", "auto")
    if origin == "auto":
        origin = told_by_manifest(path if path.is_dir() else path.parent, "origin") or "0"
    counting = _Counting(
        int(switches.get("first_frame", "1")), int(origin == "1"), int(switches.get("first_class", "1"))
    )
    found = _sequences(path, target)
    loose = LooseBoxes(intake, path.name)
    for sequence in found:
        _read_sequence(sequence, path, counting, intake, loose)
    loose.settle()
    return intake.finish(found[0].rows.name)


def _sequences(path: Path, target: ImportTarget) -> list[_Sequence]:
    if path.is_file():
        root = path.parent.parent if path.parent.name in ("gt", "det") else path.parent
        return [_Sequence(root, path)]
    for part in ("gt/gt.txt", "det/det.txt", "gt.txt", "det.txt"):
        if (path / part).is_file():
            return [_Sequence(path, path / part)]
    parts = sorted(path.rglob("gt/gt.txt"))
    if not parts:
        raise refuse(path.name, None, "has neither gt/gt.txt nor det/det.txt. Export as MOT 1.1 again.")
    own = [part for part in parts if is_called(path, target.video, part.parent.parent.name)] or [
        part for part in parts if part.parent.parent.parent == path and part.parent.parent.name in _SUBSETS
    ]
    if not own and len(parts) == 1:
        own = parts
    if not own:
        names = ", ".join(part.parent.parent.name for part in parts[:5])
        raise ImportFormatError(
            f"{path.name}: has {len(parts)} sequences ({names}), none called "
            f"{safe_stem(target.video.name)}. Import the folder of one of them."
        )
    return [_Sequence(part.parent.parent, part) for part in own]


def _read_sequence(sequence: _Sequence, path: Path, counting: _Counting, intake: Intake, loose: LooseBoxes) -> None:
    inside = path if path.is_dir() else path.parent
    file = sequence.rows.relative_to(inside).as_posix()
    scale = _scale(sequence.root / _SEQUENCE, intake)
    names = _names(sequence)
    uids = _described(sequence.rows.parent / SIDE)
    told: set[str] = set()
    for line, cells in _rows(sequence.rows, file):
        values = [math.nan if at in _BOX else _real(cell, at, file, line) for at, cell in enumerate(cells)]
        frame = intake.frame(values[0], file, line, origin=counting.frame)
        number = values[1]
        if not (math.isfinite(number) and number == int(number)):
            raise refuse(file, line, f"the track id must be a whole number. Got {cells[1].strip()[:40]!r}.")
        edges = intake.edges(partial(_edges, cells, counting.place, scale, file, line))
        label, score, ignore, occluded = _rest(values, cells, names, counting, intake, file, line)
        if number <= 0:
            loose.add(frame, edges, label, file=file, line=line, score=score, ignore=ignore, occluded=occluded)
            continue
        uid, state, source, note = uids.get(int(number), (f"track{int(number)}", "open", "imported", ""))
        taken = intake.box(
            uid, frame, edges, label, file=file, line=line, score=score, ignore=ignore, occluded=occluded
        )
        if taken and uid not in told:
            told.add(uid)
            intake.describe(uid, state=state, source=source, notes=notes_from_text(note, frame))


def _edges(
    cells: list[str], origin: int, scale: tuple[float, float], file: str, line: int
) -> tuple[float, float, float, float]:
    x, y, w, h = (_real(cells[at], at, file, line) for at in _BOX)
    x, y = x - origin, y - origin
    return x * scale[0], y * scale[1], (x + w) * scale[0], (y + h) * scale[1]


def _rest(
    values: list[float],
    cells: list[str],
    names: list[str] | None,
    counting: _Counting,
    intake: Intake,
    file: str,
    line: int,
) -> tuple[int, float, bool, bool]:
    """Class, score, ignored and occluded of a row."""
    if len(values) != 9:
        # Results: confidence, then three columns for positions in space.
        score = values[6] if len(values) > 6 else math.nan
        return UNSAID, math.nan if score == -1 else score, False, False
    flag, number, visibility = values[6:]
    if flag not in (0.0, 1.0):
        raise refuse(
            file, line, f"column 7 must be 0 (ignore) or 1. Got {cells[6].strip()[:40]!r}; results have 10 columns."
        )
    if not -1 <= visibility <= 1:
        raise refuse(file, line, f"the visibility must be in 0 to 1, or -1. Got {cells[8].strip()[:40]!r}.")
    if not (math.isfinite(number) and number == int(number)):
        raise refuse(file, line, f"the class must be a whole number. Got {cells[7].strip()[:40]!r}.")
    if number == -1:  # what the columns that nobody uses hold
        label = UNSAID
    elif names is None:
        label = intake.label(str(int(number)), file, line)
        intake.count("Rows without labels.txt took their class number as the tool's", file, line)
    else:
        place = int(number) - counting.label
        if not 0 <= place < len(names):
            raise refuse(
                file,
                line,
                f"class {int(number)} must be {counting.label} to {len(names) - 1 + counting.label}, the lines of "
                f"{NAMES}. Import with first_class={1 - counting.label} if it counts from there.",
            )
        label = intake.label(names[place], file, line)
    return label, math.nan, flag == 0.0, 0 <= visibility < _OCCLUDED


def _rows(path: Path, file: str) -> Iterator[tuple[int, list[str]]]:
    """Cells of each row with its line; all rows have as many as the first."""
    width = 0
    for line, content in enumerate(read_text(path).splitlines(), start=1):
        if not content.strip():
            continue
        cells = content.split(",") if "," in content else content.split()
        if not width:
            width = len(cells)
            if width not in (7, 9, 10):
                raise refuse(
                    file,
                    line,
                    "must have 9 columns (frame, id, x, y, w, h, flag, class, visibility), or as results 7 or 10. "
                    f"Got {width}.",
                )
        if len(cells) != width:
            raise refuse(file, line, f"must have {width} columns as the rows before. Got {len(cells)}.")
        yield line, cells


def _real(cell: str, at: int, file: str, line: int) -> float:
    try:
        return real_number(cell)
    except ValueError:
        raise refuse(file, line, f"column {at + 1} must be a number. Got {cell.strip()[:40]!r}.") from None


def _names(sequence: _Sequence) -> list[str] | None:
    for place in (sequence.rows.parent / NAMES, sequence.root / "gt" / NAMES, sequence.root / NAMES):
        if place.is_file():
            names = [line.strip() for line in read_text(place, limit=1 << 24).splitlines()]
            while names and not names[-1]:
                names.pop()
            return names
    return None


def _described(path: Path) -> dict[int, tuple[str, str, str, str]]:
    """Name, state, source and notes of each track id, from the file beside."""
    out: dict[int, tuple[str, str, str, str]] = {}
    if not path.is_file():
        return out
    names: set[str] = set()
    for line, cells in read_rows(path, SIDE_COLUMNS):
        number = real(cells["id"], "id", path.name, line)
        if number in out or cells["uid"] in names:
            raise refuse(path.name, line, f"track {cells['id']} is there twice. Give each its own id and name.")
        if not cells["uid"] or number != int(number):
            raise refuse(path.name, line, "must have a whole id and a name. Correct it.")
        names.add(cells["uid"])
        out[int(number)] = (cells["uid"], cells["state"], cells["source"] or "imported", cells["note"])
    return out


def _scale(path: Path, intake: Intake) -> tuple[float, float]:
    """By ``seqinfo.ini`` if there is one."""
    if not path.is_file():
        return 1.0, 1.0
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_file(io.StringIO(read_text(path, limit=1 << 20)))
        width, height = (real_number(parser["Sequence"][name]) for name in ("imWidth", "imHeight"))
    except (configparser.Error, KeyError, ValueError) as error:
        first = str(error).splitlines()[0]
        raise refuse(path.name, None, f"must have [Sequence] with imWidth and imHeight: {first}. Correct it.") from None
    return intake.scale(width, height, path.name)


def sniff_mot(path: Path) -> bool:
    """Whether it is a sequence, a folder of such, or a file of rows."""
    if path.is_dir():
        if is_wrapper(path) and not (path / "gt").is_dir() and not (path / "det").is_dir():
            return False
        if any((path / part).is_file() for part in ("gt/gt.txt", "det/det.txt", "det.txt")):
            return True
        if any(path.glob("*/gt/gt.txt")) or any(path.glob("*/*/gt/gt.txt")):
            return True
        return (path / "gt.txt").is_file() and _looks_like_rows(path / "gt.txt")
    return path.is_file() and path.suffix.lower() in (".txt", ".csv") and _looks_like_rows(path)


def _looks_like_rows(path: Path) -> bool:
    with path.open("rb") as stream:
        start = stream.read(1 << 12)
    line = next((part for part in start.decode("latin-1").splitlines() if part.strip()), "")
    cells = next(csv.reader([line]), [])
    try:
        return len(cells) in (7, 9, 10) and all(math.isfinite(real_number(cell)) or cell for cell in cells)
    except ValueError:
        return False
