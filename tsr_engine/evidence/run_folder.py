"""Holds the folder of a run while it is written: lock, database, and errors of the disk."""

from __future__ import annotations

import fcntl
import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from tsr_engine.errors import EvidenceError, StorageError
from tsr_engine.evidence.schema import DATABASE, LOCK_FILE
from tsr_engine.io.storage_problems import database_problem, storage_problem

_DAMAGE_CODES: Final = {sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB}


def connect(path: Path, *, shared: bool) -> sqlite3.Connection:
    """Open the database for writing; ``shared``: other machines read it meanwhile."""
    connection = sqlite3.connect(path, isolation_level=None, timeout=30.0)
    # SQLite's WAL needs memory that all readers share, which two machines do not have.
    connection.execute(f"PRAGMA journal_mode = {'TRUNCATE' if shared else 'WAL'}")
    connection.execute("PRAGMA synchronous = FULL")
    return connection


def lock_run(folder: Path) -> int:
    """Take the run's lock, which is held until the process ends: the kernel releases it even after kill -9.

    Returns:
        The lock's file descriptor.

    Raises:
        EvidenceError: another process holds it.
        StorageError: the folder cannot be written.
    """
    with storage_errors(folder):
        lock = os.open(folder / LOCK_FILE, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(lock)
        raise EvidenceError(f"Another process is writing {folder}. Wait for it, or choose another folder.") from None
    return lock


@contextmanager
def storage_errors(folder: Path) -> Iterator[None]:
    """Convert failures of the disk to :class:`StorageError` and of the database to :class:`EvidenceError`."""
    try:
        yield
    except OSError as error:
        advice = {"full": "Free some space and resume", "limit": "Raise the limit on files (ulimit -f) and resume"}
        kind = storage_problem(error)
        what = advice.get(kind, "Choose another folder")
        raise StorageError(f"Cannot write the evidence in {folder}: {error.strerror}. {what}.", kind) from None
    except sqlite3.DatabaseError as error:
        # Extended result codes carry the primary one in their low byte.
        if getattr(error, "sqlite_errorcode", 0) & 0xFF in _DAMAGE_CODES:
            raise EvidenceError(f"{folder / DATABASE} is damaged ({error}). Track the video again.") from None
        kind = database_problem(error)
        what = {"full": "Free some space", "limit": "Raise the limit on files (ulimit -f)"}.get(
            kind, "Look after the disk, or choose another folder"
        )
        raise StorageError(f"Cannot write the evidence in {folder}: {error}. {what}, then resume.", kind) from None
