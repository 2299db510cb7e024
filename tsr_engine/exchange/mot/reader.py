"""Reads MOT rows: ground truth (``gt/gt.txt``), results and detections, also of other trackers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tsr_engine.exchange.attributes import parse_attributes
from tsr_engine.exchange.box_rules import Edges, scaled
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.file_listing import first_row
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.frame_origin import FrameOrigin
from tsr_engine.exchange.ids import WHOLE_ID
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.linking import UntrackedBoxes
from tsr_engine.exchange.mot.columns import Columns, Row, Rows, find_columns
from tsr_engine.exchange.mot.row_values import RowValues
from tsr_engine.exchange.mot.sequences import SequenceFiles, class_names, find_sequences, picture_scale
from tsr_engine.exchange.nearby_manifest import is_wrapper, manifest_value
from tsr_engine.exchange.notes import notes_from_text
from tsr_engine.exchange.reading import read_text, rule_error
from tsr_engine.exchange.sidecar import ATTRIBUTES_COLUMN, finite_number, read_rows
from tsr_engine.exchange.truncated_files import last_byte, report_truncated
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.labels.model import AttributeValue

SIDECAR = "tracks.csv"
SIDECAR_COLUMNS = ("id", "uid", "state", "source", "note")
_COLUMN_COUNTS = (7, 9, 10)
_BOX_COLUMNS = range(2, 6)
"""Indices of the box's columns."""


@dataclass(frozen=True, slots=True)
class _Origins:
    """First numbers of positions and classes."""

    frame: FrameOrigin
    origin: int
    label: int | None


def read_mot(path: Path, target: ImportTarget) -> Dataset:
    """Read a folder or one file of rows.

    Raises:
        ImportFormatError: a row breaks a rule.
    """
    validator = ImportValidator(target)
    switches = target.switches
    origin = switches.get("origin", "auto")
    if origin == "auto":
        origin = manifest_value(path if path.is_dir() else path.parent, "origin") or "0"
    first = switches.get("first_class", "auto")
    origins = _Origins(
        FrameOrigin(validator, 1, is_certain=_is_ours(path)),
        int(origin == "1"),
        None if first == "auto" else int(first),
    )
    found = find_sequences(path, validator)
    loose = UntrackedBoxes(validator, path.name)
    for sequence in found:
        _read_sequence(sequence, path, origins, validator, loose)
    loose.finish()
    return validator.finish(found[0].rows.name)


def _is_ours(path: Path) -> bool:
    return bool(manifest_value(path if path.is_dir() else path.parent, "first_frame"))


def _read_sequence(
    sequence: SequenceFiles, path: Path, origins: _Origins, validator: ImportValidator, loose: UntrackedBoxes
) -> None:
    folder = path if path.is_dir() else path.parent
    file = sequence.rows.relative_to(folder).as_posix()
    scale = picture_scale(sequence, path, validator)
    names = class_names(sequence)
    rows: list[tuple[int, Row]] = []
    broken: dict[int, list[str]] = {}
    for line, cells in _rows(sequence.rows, file):
        row = [math.nan if at in _BOX_COLUMNS else _real(cell, at, file, line) for at, cell in enumerate(cells)]
        try:
            row[2:6] = map(parse_real, cells[2:6])
        except ValueError:
            broken[line] = cells
        rows.append((line, tuple(row)))
    if not rows:
        return
    if not origins.frame.decided:
        for _, values in rows:
            origins.frame.add(values[0])
        origins.frame.decide(file)
    report_truncated([(file, last_byte(sequence.rows))], validator)
    columns = _columns([values for _, values in rows], sequence, names, file, validator)
    row_values = RowValues(columns, names, origins.label, file, validator)
    zero_is_an_id = _zero_is_an_id([values for _, values in rows])
    tracks = _read_sidecar(sequence.rows.parent / SIDECAR)
    described: set[str] = set()
    for line, values in rows:
        frame = origins.frame.frame(values[0], file, line)
        number = values[1]
        if not (math.isfinite(number) and number == int(number)):
            raise rule_error(file, line, f"the track id must be a whole number. Got {number:g}.")
        edges = validator.boxes.edges(partial(_edges, values, broken.get(line), origins.origin, scale, file, line))
        label, score, ignore, occluded = row_values(values, line)
        if number < 0 or (number == 0 and not zero_is_an_id):
            loose.add(frame, edges, label, file=file, line=line, score=score, ignore=ignore, occluded=occluded)
            continue
        uid, state, source, note, attributes = tracks.get(
            int(number), (f"track{int(number)}", "open", "imported", "", dict[str, AttributeValue]())
        )
        taken = validator.box(
            uid, frame, edges, label, file=file, line=line, score=score, ignore=ignore, occluded=occluded
        )
        if taken and uid not in described:
            described.add(uid)
            validator.describe(
                uid, state=state, source=source, notes=notes_from_text(note, frame), attributes=attributes
            )


def _edges(
    values: Row, broken: list[str] | None, origin: int, scale: tuple[float, float], file: str, line: int
) -> Edges:
    """Edges of a row; ``broken`` holds its cells if one of the box is not a number."""
    x, y, w, h = values[2:6] if broken is None else (_real(broken[at], at, file, line) for at in _BOX_COLUMNS)
    x, y = x - origin, y - origin
    return scaled((x, y, x + w, y + h), scale)


def _zero_is_an_id(rows: Rows) -> bool:
    """Whether id 0 is a track, as in trackers that count from 0: no frame has it twice."""
    frames = [values[0] for values in rows if values[1] == 0]
    return len(frames) == len(set(frames))


def _columns(
    rows: Rows, sequence: SequenceFiles, names: list[str] | None, file: str, validator: ImportValidator
) -> Columns:
    option = validator.target.switches.get("columns", "auto")
    is_ground_truth = sequence.rows.name == "gt.txt" or sequence.rows.parent.name == "gt"
    is_own_export = bool(manifest_value(sequence.root, "first_frame"))
    columns = find_columns(
        rows, option, is_ground_truth=is_ground_truth, has_names=names is not None, is_own_export=is_own_export
    )
    if columns is None:
        raise rule_error(
            file, 1, f"has {len(rows[0])} columns, which columns={option} does not fit. Choose another value."
        )
    if columns.report:
        validator.repair(f"{file}: {columns.report}.")
    return columns


def _rows(path: Path, file: str) -> Iterator[tuple[int, list[str]]]:
    """Yield line number and cells of each row; all rows have as many cells as the first."""
    width = 0
    for line, content in enumerate(read_text(path).splitlines(), start=1):
        if not content.strip():
            continue
        cells = _cells(content)
        if not width:
            width = len(cells)
            if width not in _COLUMN_COUNTS:
                raise rule_error(
                    file,
                    line,
                    "must have 9 columns (frame, id, x, y, w, h, flag, class, visibility), or as results 7 or 10. "
                    f"Got {width}.",
                )
        if len(cells) != width:
            raise rule_error(file, line, f"must have {width} columns as the rows before. Got {len(cells)}.")
        yield line, cells


def _cells(content: str) -> list[str]:
    """Split a row at commas, semicolons, tabs or spaces; a trailing separator is allowed."""
    mark = next((mark for mark in ",;" if mark in content), None)
    cells = content.split(mark)
    return cells[:-1] if mark and not cells[-1].strip() else cells


def _real(cell: str, at: int, file: str, line: int) -> float:
    if at == 1 and WHOLE_ID.fullmatch(cell.strip()):
        # A float would make one id of several above 2**53.
        return int(cell)
    try:
        return parse_real(cell)
    except ValueError:
        raise rule_error(file, line, f"column {at + 1} must be a number. Got {cell.strip()[:40]!r}.") from None


def _read_sidecar(path: Path) -> dict[int, tuple[str, str, str, str, dict[str, AttributeValue]]]:
    """Name, state, source, notes and attributes by track id, from the file beside."""
    out: dict[int, tuple[str, str, str, str, dict[str, AttributeValue]]] = {}
    if not path.is_file():
        return out
    names: set[str] = set()
    for line, cells in read_rows(path, SIDECAR_COLUMNS):
        number = finite_number(cells["id"], "id", path.name, line)
        if number in out or cells["uid"] in names:
            raise rule_error(path.name, line, f"track {cells['id']} occurs twice. Give each its own id and name.")
        if not cells["uid"] or number != int(number):
            raise rule_error(path.name, line, "must have a whole id and a name. Correct it.")
        names.add(cells["uid"])
        attributes = parse_attributes(cells.get(ATTRIBUTES_COLUMN), path.name, line)
        out[int(number)] = (cells["uid"], cells["state"], cells["source"] or "imported", cells["note"], attributes)
    return out


def sniff_mot(path: Path) -> bool:
    """Whether the path is a sequence, a folder of sequences, or a file of rows."""
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
    line = first_row(path)
    try:
        values = [parse_real(cell) for cell in _cells(line)]
    except ValueError:
        return False
    # Rows of YOLO polygons have spaces too, but their second number is a relative coordinate.
    return len(values) in _COLUMN_COUNTS and (
        "," in line or (values[0] == values[0] // 1 and values[1] == values[1] // 1)
    )
