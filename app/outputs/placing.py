"""Moves files into place during a transaction, with a note on disk, so that a crash leaves nothing behind.

Neither order is safe by itself: a row without files is wrong, and files without a row are never found. A note is
therefore written to disk before the first file moves, and removed after the commit. The next start compares the note
with the database. The working process holds a lock on its note, so a second server on the same folder does not touch
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

__all__ = ["Placing", "placing", "sweep"]

_NOTE = ".placing-"
_PLACES = ("runs", "uploads")
_MOST_BYTES = 10_000


class Placing:
    """Files of one run, and of its video, that are being moved into place."""

    def __init__(self) -> None:
        self._placed: list[Path] = []

    def put(self, source: Path, place: Path) -> None:
        """Move a file or folder to its place on the same disk; it replaces leftovers without a row."""
        place.parent.mkdir(parents=True, exist_ok=True)
        for path in sorted(source.rglob("*")) if source.is_dir() else (source,):
            if path.is_file():
                sync_file(path)
        self._placed.append(place)
        source.replace(place)
        fsync_path(place.parent)

    def take_back(self) -> None:
        """Remove the files that were moved."""
        for place in self._placed:
            _remove(place)


@contextmanager
def placing(home: Path, run_id: str, upload: Path | None = None) -> Iterator[Placing]:
    """Wrap a transaction that stores a run, and perhaps its video, with their files; remove the files if it fails.

    Args:
        home: the data folder.
        run_id: the run; its folder is ``runs/<run_id>``.
        upload: path of its video, if that is moved too.
    """
    note = home / "runs" / f"{_NOTE}{run_id}"
    note.parent.mkdir(parents=True, exist_ok=True)
    with note.open("x", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        json.dump({"upload": upload and upload.name}, file)
        file.flush()
        sync_file(note)
        work = Placing()
        try:
            yield work
        except BaseException:
            work.take_back()
            raise
        finally:
            note.unlink(missing_ok=True)


def sweep(home: Path, database: Database) -> None:
    """Remove files of processes that died before their commit; called when a server starts."""
    for note in (home / "runs").glob(f"{_NOTE}*"):
        with suppress(OSError), note.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)  # fails while another process is at work
            _undo(home, database, note, file.read(_MOST_BYTES))
            note.unlink(missing_ok=True)


def _undo(home: Path, database: Database, note: Path, content: bytes) -> None:
    run_id = note.name.removeprefix(_NOTE)
    try:
        facts = json.loads(content)
        name = facts["upload"]
        upload = None if name is None else home / "uploads" / Path(str(name)).name
    except (ValueError, KeyError, TypeError):
        return  # truncated while it was written: no file had been moved yet
    with database.read() as session:
        if session.get(Run, run_id) is None:
            _remove(home / "runs" / run_id)
        if upload is not None and session.scalars(select(Video.id).where(Video.path == str(upload))).first() is None:
            _remove(upload)


def _remove(place: Path) -> None:
    if place.parent.name not in _PLACES or not place.name:
        return
    with suppress(OSError):
        if place.is_dir():
            shutil.rmtree(place, ignore_errors=True)
        else:
            place.unlink(missing_ok=True)
