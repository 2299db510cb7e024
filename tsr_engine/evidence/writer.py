"""Writes evidence: frames are collected in memory and written in chunks, one transaction each.

A process killed at any moment leaves exactly the committed chunks.
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
from tsr_engine.evidence.run_folder import connect, lock_run, storage_errors
from tsr_engine.evidence.schema import BY_NAME, DATABASE, LOCK_FILE, RUN_FILE, SCHEMA_VERSION, TABLES, create_tables
from tsr_engine.io.atomic import refuse_inputs
from tsr_engine.records import FrameEvidence

DEFAULT_CHUNK = 32
"""Frames per transaction: a kill loses about a second of video."""


class EvidenceWriter:
    """The only writer of a run's folder; created by :meth:`create` or :meth:`resume`.

    As a context manager it closes the run as ``interrupted`` after Ctrl-C, as ``failed`` after any other exception,
    and as ``complete`` otherwise.
    """

    def __init__(
        self,
        folder: Path,
        header: RunHeader,
        connection: sqlite3.Connection,
        lock: int,
        chunk: int,
        earlier_header: RunHeader | None = None,
    ) -> None:
        self.folder = folder
        self.header = header
        self.chunk = chunk
        self._connection = connection
        self._lock = lock
        self._rows: Rows = _empty_rows()
        self._pending = 0
        self._changed: dict[int, StoredTrack] = {}
        self._open: dict[int, StoredTrack] = {}
        self._closed = False
        self._append_interrupted = False
        self._earlier_header = earlier_header
        with storage_errors(folder):
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
            folder: created if missing; other files in it are kept.
            header: inputs of the run.
            chunk: frames per transaction.
            overwrite: whether to replace a run in the folder.
            shared: whether other machines read it meanwhile.

        Raises:
            EvidenceError: the folder already holds a run, or another process writes it.
            StorageError: the folder cannot be written.
        """
        folder = Path(folder)
        with storage_errors(folder):
            folder.mkdir(parents=True, exist_ok=True)
        if (folder / RUN_FILE).exists() and not overwrite:
            raise EvidenceError(f"{folder} already holds a run. Resume it, or choose an empty folder.")
        if not overwrite and _holds_frames(folder / DATABASE):
            raise EvidenceError(
                f"{folder / DATABASE} holds frames, but the {RUN_FILE} beside it is missing. Restore it, choose an "
                "empty folder, or say --restart to begin anew."
            )
        lock = lock_run(folder)
        try:
            with storage_errors(folder):
                # A store without run.json does not exist, so that file is removed first and written last.
                for name in (RUN_FILE, DATABASE, f"{DATABASE}-wal", f"{DATABASE}-shm"):
                    (folder / name).unlink(missing_ok=True)
                connection = connect(folder / DATABASE, shared=shared)
                try:
                    connection.execute("BEGIN IMMEDIATE")
                    create_tables(connection)
                    meta = [("schema_version", str(SCHEMA_VERSION)), ("identity", header.identity())]
                    connection.executemany("INSERT INTO meta VALUES (?, ?)", meta)
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
        """Continue a run after its last committed frame (:attr:`last_frame`).

        Args:
            folder: folder of the run.
            header: required inputs of the run.
            chunk: frames per transaction.
            shared: whether other machines read it meanwhile.

        Raises:
            EvidenceError: no run, a damaged one, one with another video, parameters, models or version, or one that
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
        lock = lock_run(folder)
        try:
            with storage_errors(folder):
                connection = connect(folder / DATABASE, shared=shared)
                try:
                    check_identity(connection, folder, stored)
                    write_header(folder, stored.ended("running"))
                    return cls(folder, stored.ended("running"), connection, lock, chunk, earlier_header=stored)
                except BaseException:
                    connection.close()
                    raise
        except BaseException:
            os.close(lock)
            raise

    @property
    def last_frame(self) -> int | None:
        """Ordinal of the last appended frame (after :meth:`resume`: committed); None: no frame yet."""
        return self._last

    def append(self, evidence: FrameEvidence, entry: TableEntry | None = None) -> None:
        """Add the next frame; every ``chunk`` frames are committed.

        Args:
            evidence: the frame; its ordinal must be the next one.
            entry: its row of the frame table.

        Raises:
            ValueError: the ordinal is not the next one.
            StorageError: the disk is full; committed frames stay.
        """
        if self._last is not None and evidence.ordinal != self._last + 1:
            raise ValueError(f"EvidenceWriter expects frame {self._last + 1} next. Got {evidence.ordinal} instead.")
        self._append_interrupted = True
        add_rows(self._rows, evidence, entry or TableEntry(), self.header.keep_pixels)
        self._summarise(evidence)
        self._last = int(evidence.ordinal)
        self._pending += 1
        try:
            if self._pending >= self.chunk:
                self.commit()
        except (StorageError, EvidenceError):
            self._append_interrupted = False  # the transaction was rolled back and can be tried again
            raise
        self._append_interrupted = False

    def commit(self) -> None:
        """Commit all appended frames, so that readers see them.

        Raises:
            StorageError: the disk is full; earlier commits stay.
        """
        if not self._pending:
            return
        with storage_errors(self.folder):
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                for name, rows in self._rows.items():
                    self._connection.executemany(BY_NAME[name].insert(), rows)
                upsert = BY_NAME["tracks"].insert().replace("INSERT", "INSERT OR REPLACE", 1)
                self._connection.executemany(upsert, [track.row() for track in self._changed.values()])
                self._connection.execute("COMMIT")
            except BaseException:
                # A full disk may have rolled the transaction back.
                with suppress(sqlite3.Error):
                    self._connection.execute("ROLLBACK")
                raise
        self._rows = _empty_rows()
        self._pending = 0
        self._changed = {}

    def close(self, state: RunState = "complete", reason: str = "") -> None:
        """Commit the rest and record how the run ended; a second call does nothing.

        If Ctrl-C interrupted an :meth:`append`, the rest may hold half a frame or be committed already. It is
        discarded, as after a kill.

        Raises:
            StorageError: the disk is full. The folder is released anyway, and reads as interrupted.
        """
        if self._closed:
            return
        self._closed = True
        try:
            if not self._append_interrupted:
                self.commit()
            self.header = self.header.ended(state, reason)
            write_header(self.folder, self.header)
        finally:
            with suppress(sqlite3.Error):
                self._connection.close()
            os.close(self._lock)

    def abandon(self) -> None:
        """Close a run that got no frame: a resumed one keeps its earlier end, a new one counts as failed.

        Does nothing after :meth:`close`.

        Raises:
            StorageError: the disk is full.
        """
        if self._earlier_header is None:
            self.close("failed", "The run ended before its first frame.")
        else:
            self.close(self._earlier_header.state, self._earlier_header.reason)

    def __enter__(self) -> EvidenceWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
            return
        # The first error says more than a second one from closing on a full disk.
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
        # A track that leaves the frame is removed from memory too.
        self._open = alive

    def _stored(self, track_id: int) -> StoredTrack | None:
        if track_id in self._changed:
            return self._changed[track_id]
        with storage_errors(self.folder):
            row = self._connection.execute("SELECT * FROM tracks WHERE track_id = ?", (track_id,)).fetchone()
        return None if row is None else StoredTrack(*row)


def check_identity(connection: sqlite3.Connection, folder: Path, header: RunHeader) -> None:
    """Check that the database belongs to ``run.json``.

    Raises:
        EvidenceError: it belongs to another run, or is not an evidence database.
    """
    try:
        meta = dict(connection.execute("SELECT name, value FROM meta").fetchall())
    except sqlite3.DatabaseError as error:
        raise EvidenceError(f"{folder / DATABASE} is damaged ({error}). Track the video again.") from None
    if meta.get("schema_version") != str(SCHEMA_VERSION) or meta.get("identity") != header.identity():
        raise EvidenceError(
            f"{folder / DATABASE} does not belong to the {RUN_FILE} beside it. Restore the run's files."
        )


def refuse_run_files(outputs: Iterable[Path], folder: Path) -> None:
    """Refuse an output that would replace a run's own files.

    Raises:
        UsageError: an output is one of them.
    """
    run_files = (RUN_FILE, LOCK_FILE, DATABASE, f"{DATABASE}-wal", f"{DATABASE}-shm")
    refuse_inputs(outputs, [folder / name for name in run_files], "a file of the evidence itself")


def _holds_frames(path: Path) -> bool:
    """Whether a store without ``run.json`` has a frame; False too for an empty file and other content."""
    if not path.is_file():
        return False
    try:
        with closing(sqlite3.connect(path)) as connection:
            return connection.execute("SELECT 1 FROM frames LIMIT 1").fetchone() is not None
    except sqlite3.DatabaseError:
        return False


def _empty_rows() -> Rows:
    return {table.name: [] for table in TABLES if table.name not in ("meta", "tracks")}
