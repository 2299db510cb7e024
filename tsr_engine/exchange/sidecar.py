"""Reads and writes the CSV beside formats without tracks: one row per box names its track."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from tsr_engine.exchange.attributes import attributes_as_json, parse_attributes
from tsr_engine.exchange.box_rules import Edges
from tsr_engine.exchange.frame_rows import FrameRows
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.notes import notes_from_text, notes_to_text
from tsr_engine.exchange.reading import open_text, rule_error
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.labels.model import AttributeValue

TRACK_COLUMNS = ("uid", "key", "occluded", "ignore", "score", "state", "source", "note")
"""Columns about the track of a box; a format puts its own before them. Only a track's first box has a ``note``."""
ATTRIBUTES_COLUMN = "attributes"
"""Column of the label's attributes, after the others; older files lack it."""


@dataclass(frozen=True, slots=True)
class SidecarRow:
    """The CSV row of one box."""

    line: int
    format_cells: Mapping[str, str]
    uid: str
    key: bool
    occluded: bool
    ignore: bool
    score: float
    state: str
    source: str
    note: str
    attributes: Mapping[str, AttributeValue]

    def add(self, validator: ImportValidator, frame: int, edges: Edges, label: int, file: str, line: int) -> None:
        """Pass the box to a validator; its track is described by its first row and by every row with a note."""
        is_known = self.uid in validator
        taken = validator.box(
            self.uid,
            frame,
            edges,
            label,
            file=file,
            line=line,
            key=self.key,
            occluded=self.occluded,
            ignore=self.ignore,
            score=self.score,
            attributes=self.attributes,
        )
        if taken and (self.note or not is_known):
            notes = notes_from_text(self.note, frame)
            validator.describe(self.uid, state=self.state, source=self.source or "imported", notes=notes)


class SidecarCells:
    """Makes the cells of ``TRACK_COLUMNS`` and ``ATTRIBUTES_COLUMN`` for the rows of a table, as text.

    Cells that depend only on the track are made once.
    """

    def __init__(self, rows: FrameRows) -> None:
        """Take all rows of a video."""
        self._rows = rows.as_lists()
        self._changing = rows.attributes_at
        self._attributes = [info.attributes for info in rows.tracks]
        self._tracks_with_note: set[int] = set()
        self._uids = [csv_line([info.uid]) for info in rows.tracks]
        self._state_and_source = [csv_line([info.state, info.source]) for info in rows.tracks]
        self._notes = [csv_line([notes_to_text(info.notes)]) if info.notes else "" for info in rows.tracks]

    def __call__(self, k: int) -> str:
        """The cells of row ``k``; a track's note is in the first of its rows that is requested."""
        rows = self._rows
        track, score = rows.track[k], rows.score[k]
        note = "" if track in self._tracks_with_note else self._notes[track]
        self._tracks_with_note.add(track)
        value = f"{score:.9g}" if score == score else ""
        return (
            f"{self._uids[track]},{rows.key[k]:d},{rows.occluded[k]:d},{rows.ignore[k]:d},{value},{self._state_and_source[track]},"
            f"{note},{csv_line([attributes_as_json({**self._attributes[track], **self._changing(k)})])}"
        )


def csv_line(cells: Sequence[object]) -> str:
    """Cells as a CSV line without its end, quoted where necessary."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(cells)
    text = out.getvalue()[:-1]
    # csv quotes the only cell of a line if it is empty.
    return "" if text == '""' and len(cells) == 1 else text


def read_rows(
    path: Path, required: Sequence[str], *, delimiter: str = ",", name: str | None = None
) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield line number and cells by column name for each row of a CSV with a header; empty lines are skipped.

    Args:
        path: the CSV.
        required: columns that it must have.
        delimiter: between cells.
        name: its name for messages; None: that of ``path``.

    Raises:
        ImportFormatError: another encoding, a missing column, or a row with too many or too few cells.
    """
    with open_text(path, name=name) as stream:
        yield from _rows_of(stream, name or path.name, required, delimiter)


def read_header(path: Path, *, delimiter: str = ",") -> list[str]:
    """The column names of a CSV; empty: it has none.

    Raises:
        ImportFormatError: another encoding.
    """
    with open_text(path) as stream:
        cells = next((cells for cells in csv.reader(stream, delimiter=delimiter) if any(map(str.strip, cells))), [])
    return [cell.strip().lower() for cell in cells]


def _rows_of(
    stream: TextIO, file: str, required: Sequence[str], delimiter: str
) -> Iterator[tuple[int, dict[str, str]]]:
    table = csv.reader(stream, delimiter=delimiter, strict=True)
    header: list[str] | None = None
    last_line = 0
    try:
        for cells in table:
            line, last_line = last_line + 1, table.line_num
            if not cells or (len(cells) == 1 and not cells[0].strip()):
                continue
            if header is None:
                header = [cell.strip().lower() for cell in cells]
                missing = [name for name in required if name not in header]
                if missing:
                    raise rule_error(file, line, f"the header must have {', '.join(required)}; missing: {missing[0]}.")
                if len(set(header)) != len(header):
                    raise rule_error(file, line, "the header has a name twice. Give each column its own.")
                continue
            if len(cells) != len(header):
                raise rule_error(
                    file, line, f"must have {len(header)} cells as the header has. Got {len(cells)}. Correct it."
                )
            yield line, dict(zip(header, cells, strict=True))
    except csv.Error as error:
        raise rule_error(file, table.line_num, f"is not a CSV file: {error}. Export it again.") from None
    if header is None:
        raise rule_error(file, 1, "is empty; must have a header. Export it again.")


def read_sidecar(path: Path, format_columns: Sequence[str]) -> Iterator[SidecarRow]:
    """Yield the rows of the CSV beside a format's files.

    Args:
        path: the CSV.
        format_columns: the format's columns.

    Raises:
        ImportFormatError: a column is missing, or a cell has an invalid value.
    """
    for line, cells in read_rows(path, [*format_columns, *TRACK_COLUMNS]):
        uid = cells["uid"]
        if not uid:
            raise rule_error(path.name, line, "uid must not be empty. Give the track a name.")
        flags = {}
        for name in ("key", "occluded", "ignore"):
            if cells[name] not in ("0", "1"):
                raise rule_error(path.name, line, f"{name} must be 0 or 1. Got {cells[name][:40]!r}.")
            flags[name] = cells[name] == "1"
        score = finite_number(cells["score"], "score", path.name, line) if cells["score"] else math.nan
        yield SidecarRow(
            line,
            {name: cells[name] for name in format_columns},
            uid,
            flags["key"],
            flags["occluded"],
            flags["ignore"],
            score,
            cells["state"],
            cells["source"],
            cells["note"],
            parse_attributes(cells.get(ATTRIBUTES_COLUMN), path.name, line),
        )


def finite_number(cell: str, name: str, file: str, line: int) -> float:
    """Parse a finite number.

    Raises:
        ImportFormatError: it is not a finite number.
    """
    try:
        value = parse_real(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise rule_error(file, line, f"{name} must be a finite number. Got {cell[:40]!r}. Correct it.")
    return value
