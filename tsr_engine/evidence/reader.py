"""Reads evidence by range of frames, by track, and as result rows, also while another process writes.

Every query reads a block of frames in its own transaction. So a long read neither delays the writer's checkpoints nor
needs more memory for a longer run.
"""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from tsr_engine.errors import EvidenceError
from tsr_engine.evidence.decode import EventRow, StoredFrame, event_of, frame_of, region_of, track_of
from tsr_engine.evidence.earlier_versions import read_missing_as_null
from tsr_engine.evidence.encode import Row, StoredTrack, TableEntry
from tsr_engine.evidence.header import RunHeader, RunState, read_header
from tsr_engine.evidence.schema import BY_NAME, DATABASE, LOCK_FILE
from tsr_engine.evidence.writer import check_identity
from tsr_engine.io.locks import is_locked
from tsr_engine.records import Event, FrameEvidence, Region, TrackFrame
from tsr_engine.track_table import NO_CLASS

_FRAMES_PER_BLOCK = 64
_FRAME_TABLES = (
    "detections",
    "track_frames",
    "predictions",
    "gates",
    "relocalisations",
    "samples",
    "recognitions",
    "events",
    "timings",
)


class ResultRow(NamedTuple):
    """One row of the CSV that ``tsr track`` and ``tsr replay`` write; edges rounded to 2 decimals, score to 4."""

    frame: int
    track_id: int
    x1: float
    y1: float
    x2: float
    y2: float
    class_id: int
    score: float
    source: str

    def line(self) -> str:
        """The row as CSV text without a line end."""
        return (
            f"{self.frame},{self.track_id},{self.x1:.2f},{self.y1:.2f},{self.x2:.2f},{self.y2:.2f},"
            f"{self.class_id},{self.score:.4f},{self.source}"
        )


RESULT_HEADER = ",".join(ResultRow._fields)


class EvidenceReader:
    """Read access to one run.

    Raises:
        EvidenceError: there is no run, it is damaged, or it has another schema version.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)
        self.header: RunHeader = read_header(self.folder)
        path = self.folder / DATABASE
        if not path.is_file():
            raise EvidenceError(f"{path} is missing. Track the video again.")
        with self._reading():
            self._connection = _open(path)
        try:
            check_identity(self._connection, self.folder, self.header)
            with self._reading():
                read_missing_as_null(self._connection)
        except BaseException:
            self._connection.close()
            raise

    def close(self) -> None:
        """Close the store."""
        self._connection.close()

    def __enter__(self) -> EvidenceReader:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def state(self) -> RunState:
        """The state of the run; ``running`` only while a living process writes it."""
        state = read_header(self.folder).state
        return "interrupted" if state == "running" and not is_locked(self.folder / LOCK_FILE) else state

    @property
    def first_frame(self) -> int | None:
        """Ordinal of the first frame; None: no frame yet."""
        return self._value("SELECT min(frame) FROM frames")

    @property
    def last_frame(self) -> int | None:
        """Ordinal of the last committed frame; None: no frame yet."""
        return self._value("SELECT max(frame) FROM frames")

    def __len__(self) -> int:
        """Number of committed frames."""
        first, last = self.first_frame, self.last_frame
        return 0 if first is None or last is None else last - first + 1

    def frames(self, start: int = 0, stop: int | None = None, *, pixels: bool = True) -> Iterator[FrameEvidence]:
        """Yield the evidence of ``start <= frame < stop`` in order, exactly as it was appended.

        Args:
            start: first ordinal.
            stop: frame after the last; unset: all frames committed at the time of the call.
            pixels: whether to read the regions.
        """
        for first, stop_frame in self._blocks(start, stop):
            with self._snapshot():
                heads = self._rows("frames", first, stop_frame)
                tables = {name: self._grouped(name, first, stop_frame) for name in _FRAME_TABLES}
                tables["regions"] = self._grouped("regions", first, stop_frame) if pixels else {}
            for head in heads:
                rows = StoredFrame(head, {name: groups.get(head[0], []) for name, groups in tables.items()})
                yield frame_of(rows)

    def frame_table(self, start: int = 0, stop: int | None = None) -> Iterator[tuple[int, TableEntry]]:
        """Yield ordinal and frame table entry of ``start <= frame < stop``."""
        for first, stop_frame in self._blocks(start, stop, 4096):
            sql = "SELECT frame, pts, key_frame, corrupt FROM frames WHERE frame >= ? AND frame < ? ORDER BY frame"
            for frame, pts, key, corrupt in self.query(sql, (first, stop_frame)):
                yield frame, TableEntry(pts, bool(key), bool(corrupt))

    def track(self, track_id: int) -> Iterator[tuple[int, TrackFrame]]:
        """Yield ordinal and all evidence of one track, frame by frame."""
        tables = ("track_frames", "predictions", "gates", "relocalisations", "samples", "recognitions")
        span = self.query("SELECT min(frame), max(frame) FROM track_frames WHERE track_id = ?", (track_id,))[0]
        if span[0] is None:
            return
        for first, stop_frame in self._blocks(span[0], span[1] + 1):
            with self._snapshot():
                groups = {
                    name: self._grouped(name, first, stop_frame, "AND track_id = ?", (track_id,)) for name in tables
                }
            for frame, (row, *_) in groups["track_frames"].items():
                yield frame, track_of(row, {name: groups[name].get(frame, []) for name in tables[1:]})

    def tracks(self, start: int | None = None, stop: int | None = None) -> Iterator[StoredTrack]:
        """Yield summaries by track number; given ``start`` and ``stop``, of tracks in ``start <= frame < stop``."""
        low, high = -1 if start is None else start, 2**62 if stop is None else stop
        sql = "SELECT * FROM tracks WHERE first_frame < ? AND last_frame >= ? ORDER BY track_id"
        for row in self.query(sql, (high, low)):
            yield StoredTrack(*row)

    def events(
        self, start: int = 0, stop: int | None = None, *, track_id: int | None = None
    ) -> Iterator[tuple[int, Event]]:
        """Yield ordinal and event, in order."""
        condition, values = ("", ()) if track_id is None else ("AND track_id = ?", (track_id,))
        for first, stop_frame in self._blocks(start, stop, 4096):
            for row in self._rows("events", first, stop_frame, condition, values):
                yield row[0], event_of(EventRow(*row))

    def result_rows(self, confirmed_only: bool = True) -> Iterator[ResultRow]:
        """Yield the rows of the result CSV, by frame, then by track.

        Confirmed tracks appear from their first frame on, with the class fused over their whole life (-1: never
        recognised). The frame in which a track dies has no row. Boxes of an imported run can lack a score: NaN.
        """
        classes = {t.track_id: t.class_id for t in self.tracks() if t.confirmed or not confirmed_only}
        sql = (
            "SELECT frame, track_id, x1, y1, x2, y2, score, source FROM track_frames "
            "WHERE frame >= ? AND frame < ? AND state <> 'dead' ORDER BY frame, track_id"
        )
        for first, stop_frame in self._blocks(0, None, 1024):
            for frame, identity, x1, y1, x2, y2, score, source in self.query(sql, (first, stop_frame)):
                if identity in classes:
                    edges = round(x1, 2), round(y1, 2), round(x2, 2), round(y2, 2)
                    label = NO_CLASS if (known := classes[identity]) is None else known
                    score = math.nan if score is None else round(score, 4)
                    yield ResultRow(frame, identity, *edges, label, score, source)

    def last_empty_frame(self, before: int | None = None) -> int | None:
        """The last committed ordinal without a live track, below ``before`` if given; None: there is none.

        A resumed run rebuilds its state by replaying the evidence of later frames.
        """
        limit = 2**62 if before is None else before
        return self._value("SELECT max(frame) FROM frames WHERE alive = 0 AND frame < ?", (limit,))

    def query(self, sql: str, values: Sequence[object] = ()) -> list[Row]:
        """Run any SQL query on the tables of ``docs/evidence.md``; the store is read-only.

        Raises:
            EvidenceError: the store is damaged, or the SQL is wrong.
        """
        with self._reading():
            return self._connection.execute(sql, tuple(values)).fetchall()

    def regions(self, frame: int) -> tuple[Region, ...]:
        """The stored pixels of one frame; may be empty."""
        return tuple(region_of(row) for row in self._rows("regions", frame, frame + 1))

    def _blocks(self, start: int, stop: int | None, size: int = _FRAMES_PER_BLOCK) -> Iterator[tuple[int, int]]:
        first, last = self.first_frame, self.last_frame
        if first is None or last is None:
            return
        stop_frame = last + 1 if stop is None else min(stop, last + 1)
        for low in range(max(start, first), stop_frame, size):
            yield low, min(low + size, stop_frame)

    def _rows(self, table: str, first: int, stop_frame: int, condition: str = "", values: Row = ()) -> list[Row]:
        order = "frame, row" if table == "track_frames" else ", ".join(BY_NAME[table].key)
        sql = f"SELECT * FROM {table} WHERE frame >= ? AND frame < ? {condition} ORDER BY {order}"  # noqa: S608
        return self.query(sql, (first, stop_frame, *values))

    def _grouped(
        self, table: str, first: int, stop_frame: int, condition: str = "", values: Row = ()
    ) -> dict[int, list[Row]]:
        groups: dict[int, list[Row]] = {}
        for row in self._rows(table, first, stop_frame, condition, values):
            groups.setdefault(row[0], []).append(row)
        return groups

    def _value(self, sql: str, values: Row = ()) -> int | None:
        value: int | None = self.query(sql, values)[0][0]
        return value

    @contextmanager
    def _snapshot(self) -> Iterator[None]:
        """A block in which several queries see the same state."""
        with self._reading():
            self._connection.execute("BEGIN")
        try:
            yield
        finally:
            if self._connection.in_transaction:
                self._connection.rollback()

    @contextmanager
    def _reading(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.DatabaseError as error:
            raise EvidenceError(
                f"Cannot read {self.folder / DATABASE}: {error}. Track the video again if this stays."
            ) from None


def _open(path: Path) -> sqlite3.Connection:
    address = f"{path.resolve().as_uri()}?mode=ro"
    connection = _connect(address)
    try:
        connection.execute("SELECT 1 FROM sqlite_master").fetchone()
    except sqlite3.OperationalError:
        connection.close()
        wal = path.with_name(f"{path.name}-wal")
        if wal.exists() and wal.stat().st_size:
            raise
        # A finished store in a read-only folder: nothing can change it, so no shared memory is needed.
        connection = _connect(f"{address}&immutable=1")
    return connection


def _connect(address: str) -> sqlite3.Connection:
    return sqlite3.connect(address, uri=True, isolation_level=None, timeout=30.0, check_same_thread=False)
