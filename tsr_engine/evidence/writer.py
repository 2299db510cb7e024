"""Writes evidence: frames are collected in memory and written in chunks, one transaction each.

After a kill at any moment the store holds exactly the committed chunks.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable
from contextlib import closing, suppress
from pathlib import Path
from types import TracebackType

from tsr_engine.errors import EvidenceError, StorageError
from tsr_engine.evidence.encode import Rows, StoredTrack, TableEntry, add_rows
from tsr_engine.evidence.header import RunHeader, RunState, read_header, write_header
from tsr_engine.evidence.held_folder import acquire, connect, storage
from tsr_engine.evidence.schema import BY_NAME, DATABASE, LOCK_FILE, RUN_FILE, SCHEMA_VERSION, TABLES, create_tables
from tsr_engine.io.atomic import refuse_inputs
from tsr_engine.records import FrameEvidence

DEFAULT_CHUNK = 32
"""Frames a transaction: about a second of video is lost by a kill."""


class EvidenceWriter:
    """The only writer of one run's folder; made by :meth:`create` or :meth:`resume`.

    Used as a context manager it closes the run as ``interrupted`` if Ctrl-C leaves the block, as ``failed`` for any
    other exception, and as ``complete`` otherwise.
    """

    def __init__(
        self,
        folder: Path,
        header: RunHeader,
        connection: sqlite3.Connection,
        lock: int,
        chunk: int,
        before: RunHeader | None = None,
    ) -> None:
        self.folder = folder
        self.header = header
        self.chunk = chunk
        self._connection = connection
        self._lock = lock
        self._rows: Rows = _no_rows()
        self._pending = 0
        self._changed: dict[int, StoredTrack] = {}
        self._open: dict[int, StoredTrack] = {}
        self._closed = False
        self._torn = False
        self._before = before
        with storage(folder):
            last = connection.execute("SELECT max(frame) FROM frames").fetchone()[0]
        self._last: int | None = last

    @classmethod
    def create(
        cls,
        folder: Path,
        header: RunHeader,
        *,
        chunk: int = DEFAULT_CHUNK,
        overwrite: bool = False,
        shared: bool = False,
    ) -> EvidenceWriter:
        """Start a new run.

        Args:
            folder: made if missing; other files in it are left alone.
            header: what the run is made of.
            chunk: frames a transaction.
            overwrite: replace a run that the folder already holds.
            shared: other machines read it meanwhile.

        Raises:
            EvidenceError: the folder already holds a run, or another process writes it.
            StorageError: the folder cannot be written.
        """
        folder = Path(folder)
        with storage(folder):
            folder.mkdir(parents=True, exist_ok=True)
        if (folder / RUN_FILE).exists() and not overwrite:
            raise EvidenceError(f"{folder} already holds a run. Resume it, or choose an empty folder.")
        if not overwrite and _holds_frames(folder / DATABASE):
            raise EvidenceError(
                f"{folder / DATABASE} holds frames, but the {RUN_FILE} beside it is missing. Restore it, choose an "
                "empty folder, or say --restart to begin anew."
            )
        lock = acquire(folder)
        try:
            with storage(folder):
                # Without run.json a store does not exist: its file goes first when replaced, and comes last when made.
                for name in (RUN_FILE, DATABASE, f"{DATABASE}-wal", f"{DATABASE}-shm"):
                    (folder / name).unlink(missing_ok=True)
                connection = connect(folder / DATABASE, shared=shared)
                try:
                    connection.execute("BEGIN IMMEDIATE")
                    create_tables(connection)
                    facts = [("schema_version", str(SCHEMA_VERSION)), ("identity", header.identity())]
                    connection.executemany("INSERT INTO meta VALUES (?, ?)", facts)
                    connection.execute("COMMIT")
                    header = header.ended("running")
                    write_header(folder, header)
                    return cls(folder, header, connection, lock, chunk)
                except BaseException:
                    connection.close()
                    raise
        except BaseException:
            os.close(lock)
            raise

    @classmethod
    def resume(
        cls, folder: Path, header: RunHeader, *, chunk: int = DEFAULT_CHUNK, shared: bool = False
    ) -> EvidenceWriter:
        """Go on with a run after its last committed frame (:attr:`last_frame`).

        Args:
            folder: of the run.
            header: what it must be made of.
            chunk: frames a transaction.
            shared: other machines read it meanwhile.

        Raises:
            EvidenceError: no run, a damaged one, one of another video, parameters, models or version, or one that
                another process is writing.
            StorageError: the folder cannot be written.
        """
        folder = Path(folder)
        stored = read_header(folder)
        if found := stored.differences(header):
            shown = "; ".join(found[:3]) + ("; ..." if len(found) > 3 else "")
            raise EvidenceError(
                f"{folder} belongs to another run ({shown}). Resume with its own, use a new folder, or say --restart "
                "to begin anew."
            )
        if not (folder / DATABASE).is_file():
            raise EvidenceError(f"{folder / DATABASE} is missing. Track the video again.")
        lock = acquire(folder)
        try:
            with storage(folder):
                connection = connect(folder / DATABASE, shared=shared)
                try:
                    check_identity(connection, folder, stored)
                    write_header(folder, stored.ended("running"))
                    return cls(folder, stored.ended("running"), connection, lock, chunk, before=stored)
                except BaseException:
                    connection.close()
                    raise
        except BaseException:
            os.close(lock)
            raise

    @property
    def last_frame(self) -> int | None:
        """Ordinal of the last frame appended (after :meth:`resume`: committed); None: none yet."""
        return self._last

    def append(self, evidence: FrameEvidence, entry: TableEntry | None = None) -> None:
        """Add the next frame; every ``chunk`` frames are committed.

        Args:
            evidence: the frame; its ordinal must follow the last one.
            entry: its row of the frame table.

        Raises:
            ValueError: a gap or a repetition in the ordinals.
            StorageError: the disk is full; what was committed stays.
        """
        if self._last is not None and evidence.ordinal != self._last + 1:
            raise ValueError(f"EvidenceWriter expects frame {self._last + 1} next. Got {evidence.ordinal} instead.")
        self._torn = True
        add_rows(self._rows, evidence, entry or TableEntry(), self.header.keep_pixels)
        self._summarise(evidence)
        self._last = int(evidence.ordinal)
        self._pending += 1
        try:
            if self._pending >= self.chunk:
                self.commit()
        except (StorageError, EvidenceError):
            self._torn = False  # what the disk refused was rolled back, and may be tried again
            raise
        self._torn = False

    def commit(self) -> None:
        """Make everything appended so far permanent and visible to readers.

        Raises:
            StorageError: the disk is full; what was committed earlier stays.
        """
        if not self._pending:
            return
        with storage(self.folder):
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                for name, rows in self._rows.items():
                    self._connection.executemany(BY_NAME[name].insert(), rows)
                upsert = BY_NAME["tracks"].insert().replace("INSERT", "INSERT OR REPLACE", 1)
                self._connection.executemany(upsert, [track.row() for track in self._changed.values()])
                self._connection.execute("COMMIT")
            except BaseException:
                # A full disk may have rolled back by itself.
                with suppress(sqlite3.Error):
                    self._connection.execute("ROLLBACK")
                raise
        self._rows = _no_rows()
        self._pending = 0
        self._changed = {}

    def close(self, state: RunState = "complete", reason: str = "") -> None:
        """Commit the rest and record how the run ended; a second call does nothing.

        After an :meth:`append` that did not end, as when Ctrl-C broke in, the rest may hold half a frame or be on the
        disk already: it is given up, as a kill would have it.

        Raises:
            StorageError: the disk is full. The folder is released all the same, and reads as interrupted.
        """
        if self._closed:
            return
        self._closed = True
        try:
            if not self._torn:
                self.commit()
            self.header = self.header.ended(state, reason)
            write_header(self.folder, self.header)
        finally:
            with suppress(sqlite3.Error):
                self._connection.close()
            os.close(self._lock)

    def abandon(self) -> None:
        """Close a run that got no frame: a resumed one ends as it had ended before, a new one as failed.

        Does nothing after :meth:`close`.

        Raises:
            StorageError: the disk is full.
        """
        if self._before is None:
            self.close("failed", "The run ended before its first frame.")
        else:
            self.close(self._before.state, self._before.reason)

    def __enter__(self) -> EvidenceWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
            return
        # The error on its way out says more than a second one from closing on a full disk.
        with suppress(StorageError):
            if isinstance(error, KeyboardInterrupt):
                self.close("interrupted", "Interrupted from the keyboard.")
            else:
                self.close("failed", str(error))

    def _summarise(self, evidence: FrameEvidence) -> None:
        k = int(evidence.ordinal)
        alive: dict[int, StoredTrack] = {}
        for track in evidence.tracks:
            identity = int(track.track_id)
            summary = self._open.get(identity) or self._stored(identity) or StoredTrack(identity, k, k)
            summary.extend(k, track)
            self._changed[identity] = summary
            alive[identity] = summary
        # A track that leaves the frame leaves the memory as well.
        self._open = alive

    def _stored(self, track_id: int) -> StoredTrack | None:
        if track_id in self._changed:
            return self._changed[track_id]
        with storage(self.folder):
            row = self._connection.execute("SELECT * FROM tracks WHERE track_id = ?", (track_id,)).fetchone()
        return None if row is None else StoredTrack(*row)


def check_identity(connection: sqlite3.Connection, folder: Path, header: RunHeader) -> None:
    """Prove that the database belongs to ``run.json``.

    Raises:
        EvidenceError: it does not, or it is no evidence database.
    """
    try:
        facts = dict(connection.execute("SELECT name, value FROM meta").fetchall())
    except sqlite3.DatabaseError as error:
        raise EvidenceError(f"{folder / DATABASE} is damaged ({error}). Track the video again.") from None
    if facts.get("schema_version") != str(SCHEMA_VERSION) or facts.get("identity") != header.identity():
        raise EvidenceError(
            f"{folder / DATABASE} does not belong to the {RUN_FILE} beside it. Restore the run's files."
        )


def refuse_run_files(outputs: Iterable[Path], folder: Path) -> None:
    """Refuse an output that would take the place of a run's own files.

    Raises:
        UsageError: an output names one of them.
    """
    own = (RUN_FILE, LOCK_FILE, DATABASE, f"{DATABASE}-wal", f"{DATABASE}-shm")
    refuse_inputs(outputs, [folder / name for name in own], "a file of the evidence itself")


def _holds_frames(path: Path) -> bool:
    """Whether a store without its ``run.json`` has any frame; one that was never begun, or is none, has not."""
    if not path.is_file():
        return False
    try:
        with closing(sqlite3.connect(path)) as connection:
            return connection.execute("SELECT 1 FROM frames LIMIT 1").fetchone() is not None
    except sqlite3.DatabaseError:
        return False


def _no_rows() -> Rows:
    return {table.name: [] for table in TABLES if table.name not in ("meta", "tracks")}
