"""Reads named, typed columns of an evidence store, for every query that does not need whole records.

The names are those of ``docs/evidence.md``. A column of a joined table has the table's name as prefix:
``gates.l_positive``. Names are checked against the schema, so a wrong one fails at once for every store.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.evidence.schema import BY_NAME
from tsr_engine.records import FloatArray
from tsr_engine.track_table import SOURCES, BoolArray, IntArray

__all__ = [
    "BOX",
    "SOURCES",
    "Columns",
    "count",
    "frame_size",
    "read_columns",
    "read_end_boxes",
    "read_runners_up",
    "sample_detections",
]  # fmt: skip

BOX = ("x1", "y1", "x2", "y2")
"""Edges of a table's own box."""
Value = int | float | str | bytes | None
_CODES: dict[str, int] = {name: code for code, name in enumerate(SOURCES)}
_VECTORS = {"votes": "<f8", "probabilities": "<f4", "covariance": "<f8"}
_TRACK_FRAME_TABLES = ("track_frames", "predictions", "gates", "relocalisations", "recognitions")
"""Tables with at most one row per track and frame."""
_CONFIRMED = "SELECT track_id FROM tracks WHERE confirmed_frame IS NOT NULL"


class Columns:
    """The selected rows, column by column.

    Every method raises ``KeyError`` for a column that was not selected.
    """

    def __init__(self, names: Sequence[str], rows: Sequence[tuple[Value, ...]]) -> None:
        self._length = len(rows)
        self._columns = dict(zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True))

    def __len__(self) -> int:
        return self._length

    def values(self, name: str) -> tuple[Value, ...]:
        """A column as stored; NULL becomes None."""
        return self._columns[name]

    def ints(self, name: str, missing: int = -1) -> IntArray:
        """A column of integers, shape (n,); NULL becomes ``missing``."""
        column = self._columns[name]
        return np.array([missing if v is None else v for v in column] if None in column else column, dtype=np.int64)

    def floats(self, name: str) -> FloatArray:
        """A column of numbers, shape (n,); NULL becomes NaN."""
        return np.array(self._columns[name], dtype=np.float64)

    def has_value(self, name: str) -> BoolArray:
        """Whether a column has a value, shape (n,)."""
        return np.array([value is not None for value in self._columns[name]], dtype=np.bool_)

    def texts(self, name: str) -> list[str]:
        """A column of texts; NULL becomes an empty text."""
        return ["" if value is None else str(value) for value in self._columns[name]]

    def boxes(self, prefix: str = "") -> FloatArray:
        """Boxes, shape (n, 4), px; NULL becomes NaN. Their edges may have a prefix: ``search_``, ``predictions.``."""
        return np.stack([self.floats(f"{prefix}{edge}") for edge in BOX], axis=1).reshape(-1, 4)

    def sources(self, name: str = "source") -> IntArray:
        """The source of each result, as an index into ``SOURCES``, shape (n,)."""
        return np.array([_CODES[str(value)] for value in self._columns[name]], dtype=np.int64)

    def vectors(self, name: str) -> list[FloatArray | None]:
        """Votes or probabilities by class, or covariances of shape (16,); NULL becomes None."""
        kind = _VECTORS[name.rpartition(".")[2]]
        return [
            np.frombuffer(value, kind).astype(np.float64) if isinstance(value, bytes) else None
            for value in self._columns[name]
        ]


def read_columns(
    reader: EvidenceReader,
    table: str,
    *names: str,
    frames: tuple[int, int] | None = None,
    tracks: tuple[int, int] | None = None,
    alive: bool = False,
    confirmed: bool = False,
    order: Literal["frame", "track", "any"] = "frame",
) -> Columns:
    """Read columns of a table, joined with other tables by track and frame.

    Args:
        reader: of the run.
        table: the table of the rows.
        names: column names; those of another table have its prefix. They are NULL if that table has no row.
        frames: only rows of ``start <= frame < stop``.
        tracks: only rows of tracks within these numbers, both inclusive.
        alive: only rows of frames in which the track is not dead.
        confirmed: only rows of tracks that were ever confirmed.
        order: by frame, then as stored; by track, then by frame; or as stored, which is fastest.

    Raises:
        EvidenceError: the store is damaged.
        ValueError: the schema has no such table or column, the two cannot be joined, or the table lacks the column of
            a filter or order.
    """
    wanted = [name if "." in name else f"{table}.{name}" for name in names]
    joined = dict.fromkeys(name.partition(".")[0] for name in wanted)
    conditions: list[str] = []
    values: list[int] = []
    if frames is not None:
        conditions.append(f"{table}.frame >= ? AND {table}.frame < ?")
        values += frames
    if tracks is not None:
        conditions.append(f"{table}.track_id BETWEEN ? AND ?")
        values += tracks
    if alive:
        joined["track_frames"] = None
        conditions.append("track_frames.state <> 'dead'")
    if confirmed:
        conditions.append("confirmed_frame IS NOT NULL" if table == "tracks" else f"{table}.track_id IN ({_CONFIRMED})")
    for name in wanted:
        other_table, _, column = name.partition(".")
        if other_table not in BY_NAME or column not in _columns_of(other_table):
            raise ValueError(f"Evidence has no column {name!r}: docs/evidence.md lists them.")
    if table not in BY_NAME:
        raise ValueError(f"Evidence has no table {table!r}: docs/evidence.md lists them.")
    own = _columns_of(table)
    for column, is_used in (("frame", frames is not None), ("track_id", bool(tracks) or confirmed or order == "track")):
        if is_used and column not in own:
            raise ValueError(f"{table} of evidence has no column {column} to filter or sort by.")
    sql = f"SELECT {', '.join(wanted)} FROM {table}"  # noqa: S608
    sql += "".join(f" LEFT JOIN {other} ON {_join(table, other)}" for other in joined if other != table)
    sql += f" WHERE {' AND '.join(conditions)}" if conditions else ""
    sql += "" if order == "any" else f" ORDER BY {', '.join(f'{table}.{key}' for key in _keys(table, order))}"
    return Columns(names, reader.query(sql, values))


def count(reader: EvidenceReader, table: str) -> int:
    """Number of rows of a table."""
    if table not in BY_NAME:
        raise ValueError(f"Evidence has no table {table!r}: docs/evidence.md lists them.")
    return int(reader.query(f"SELECT count(*) FROM {table}")[0][0])  # noqa: S608


def frame_size(reader: EvidenceReader, frame: int | None = None) -> tuple[int, int] | None:
    """Width and height of a frame (unset: the first one), px; None: the run has not stored it."""
    wanted = reader.first_frame if frame is None else frame
    if wanted is None:
        return None
    rows = read_columns(reader, "frames", "width", "height", frames=(wanted, wanted + 1))
    return (int(rows.ints("width")[0]), int(rows.ints("height")[0])) if len(rows) else None


def read_end_boxes(reader: EvidenceReader, end: Literal["first_frame", "last_frame"]) -> FloatArray:
    """The first or last box of each confirmed track, by number, shape (n, 4), px; NaN: no box."""
    rows = reader.query(
        f"SELECT f.x1, f.y1, f.x2, f.y2 FROM tracks t LEFT JOIN track_frames f ON f.track_id = t.track_id "  # noqa: S608
        f"AND f.frame = t.{end} WHERE t.confirmed_frame IS NOT NULL ORDER BY t.track_id"
    )
    return Columns(BOX, rows).boxes()


def read_runners_up(reader: EvidenceReader) -> tuple[IntArray, FloatArray]:
    """The class with the second most votes of each confirmed track, by number, and its share of all votes.

    Returns:
        Class, shape (n,), -1: no second class has votes; share, shape (n,), NaN in that case.
    """
    ids = read_columns(reader, "tracks", "track_id", "class_id", confirmed=True)
    last_recognitions = reader.query(
        "SELECT t.track_id, r.runner_up, r.votes FROM tracks t JOIN recognitions r "
        "ON r.frame = t.last_frame AND r.track_id = t.track_id WHERE t.confirmed_frame IS NOT NULL"
    )
    found = {track: (runner_up, votes) for track, runner_up, votes in last_recognitions}
    # A box that ends outside the picture is not recognised there, so its last recognition is in an earlier frame.
    earlier = (
        "SELECT r.runner_up, r.votes FROM tracks t JOIN recognitions r ON r.track_id = t.track_id "
        "AND r.frame BETWEEN t.first_frame AND t.last_frame WHERE t.track_id = ? ORDER BY r.frame DESC LIMIT 1"
    )
    seconds, shares = np.full(len(ids), -1), np.full(len(ids), np.nan)
    for index, (track, label) in enumerate(zip(ids.values("track_id"), ids.values("class_id"), strict=True)):
        row = found.get(track)
        if row is None and label is not None:
            row = next(iter(reader.query(earlier, (track,))), None)
        if row is None:
            continue
        votes = np.frombuffer(row[1], _VECTORS["votes"])
        total = float(votes.sum())
        if total > 0 and votes[row[0]] > 0:
            seconds[index], shares[index] = row[0], votes[row[0]] / total
    return seconds, shares


def sample_detections(reader: EvidenceReader, max_detections: int) -> tuple[Columns, int]:
    """At most ``max_detections`` detections with the track of each, evenly spread over the run.

    Returns:
        ``x`` and ``y`` of the centre, px, ``prior`` and ``track_id`` (NULL: no track); the number of all detections.
    """
    total = count(reader, "detections")
    step = max(1, -(-total // max_detections))
    rows = reader.query(
        "SELECT x, y, prior, track_id FROM (SELECT (d.x1 + d.x2) / 2 AS x, (d.y1 + d.y2) / 2 AS y, d.prior AS prior, "
        "t.track_id AS track_id, row_number() OVER (ORDER BY d.frame, d.row) AS number FROM detections d "
        "LEFT JOIN track_frames t ON t.frame = d.frame AND t.detection = d.row) WHERE number % ? = 0",
        (step,),
    )
    return Columns(("x", "y", "prior", "track_id"), rows), total


def _join(table: str, other: str) -> str:
    if table == "track_frames" and other == "detections":
        return "detections.frame = track_frames.frame AND detections.row = track_frames.detection"
    if table in _TRACK_FRAME_TABLES and other in _TRACK_FRAME_TABLES:
        return f"{other}.frame = {table}.frame AND {other}.track_id = {table}.track_id"
    if other == "frames":
        return f"frames.frame = {table}.frame"
    if other == "tracks" and "track_id" in _columns_of(table):
        return f"tracks.track_id = {table}.track_id"
    raise ValueError(f"{table} and {other} of evidence have no key in common.")


def _keys(table: str, order: Literal["frame", "track"]) -> tuple[str, ...]:
    own = _columns_of(table)
    if order == "track":
        return ("track_id", "frame") if "frame" in own else ("track_id",)
    return ("frame", "row") if "row" in own else BY_NAME[table].key


def _columns_of(table: str) -> set[str]:
    return {name for name, _, _ in BY_NAME[table].columns}
