"""Moves files into place during a transaction, with a record on disk, so that a crash leaves nothing behind.

Neither order is safe by itself: a row without files is wrong, and files without a row are never found. A record is
therefore written to disk before the first file moves, and removed after the commit. The next start compares the record
with the database. The working process holds a lock on its record, so a second server on the same folder does not touch
it.
"""

from __future__ import annotations

import fcntl
import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from sqlalchemy import select

from app.outputs.folders import sync_file
from app.storage.database import Database
from app.storage.models import Run, Video
from tsr_engine.io.unfinished import fsync_path

_RECORD_PREFIX = ".placing-"
_FOLDERS = ("runs", "uploads")
_MAX_RECORD_BYTES = 10_000


class FileMoves:
    """Files of one run, and of its video, that are being moved into place."""

    def __init__(self) -> None:
        self._moved: list[Path] = []

    def move(self, source: Path, target: Path) -> None:
        """Move a file or folder to its place on the same disk; it replaces leftovers without a row."""
        target.parent.mkdir(parents=True, exist_ok=True)
        for path in sorted(source.rglob("*")) if source.is_dir() else (source,):
            if path.is_file():
                sync_file(path)
        self._moved.append(target)
        source.replace(target)
        fsync_path(target.parent)

    def undo(self) -> None:
        """Remove the files that were moved."""
        for path in self._moved:
            _remove(path)


@contextmanager
def moving_files(home: Path, run_id: str, upload: Path | None = None) -> Iterator[FileMoves]:
    """Wrap a transaction that stores a run, and perhaps its video, with their files; remove the files if it fails.

    Args:
        home: the data folder.
        run_id: the run; its folder is ``runs/<run_id>``.
        upload: path of its video, if that is moved too.
    """
    record = home / "runs" / f"{_RECORD_PREFIX}{run_id}"
    record.parent.mkdir(parents=True, exist_ok=True)
    with record.open("x", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        json.dump({"upload": upload and upload.name}, file)
        file.flush()
        sync_file(record)
        moves = FileMoves()
        try:
            yield moves
        except BaseException:
            moves.undo()
            raise
        finally:
            record.unlink(missing_ok=True)


def sweep(home: Path, database: Database) -> None:
    """Remove files of processes that died before their commit; called when a server starts."""
    for record in (home / "runs").glob(f"{_RECORD_PREFIX}*"):
        with suppress(OSError), record.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)  # fails while another process is at work
            _undo(home, database, record, file.read(_MAX_RECORD_BYTES))
            record.unlink(missing_ok=True)


def _undo(home: Path, database: Database, record: Path, content: bytes) -> None:
    run_id = record.name.removeprefix(_RECORD_PREFIX)
    try:
        values = json.loads(content)
        name = values["upload"]
        upload = None if name is None else home / "uploads" / Path(str(name)).name
    except (ValueError, KeyError, TypeError):
        return  # truncated while it was written: no file had been moved yet
    with database.read() as session:
        if session.get(Run, run_id) is None:
            _remove(home / "runs" / run_id)
        if upload is not None and session.scalars(select(Video.id).where(Video.path == str(upload))).first() is None:
            _remove(upload)


def _remove(path: Path) -> None:
    if path.parent.name not in _FOLDERS or not path.name:
        return
    with suppress(OSError):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
