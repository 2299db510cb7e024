"""Uploaded files in the data folder, named by their content; one process at a time adds or removes them.

The same bytes have the same place, from uploads, concurrent uploads and clips of bundles. A process that places or
removes such a file therefore holds the lock of its digest from its first query to the last file, so no
file that a row names is removed.
"""

from __future__ import annotations

import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from sqlalchemy import or_, select

from app.storage.database import Database
from app.storage.models import Video
from app.storage.servers import this_server


@dataclass(slots=True)
class _FileLock:
    lock: threading.Lock = field(default_factory=threading.Lock)
    users: int = 0


class Uploads:
    """The folder ``uploads``; only one server uses it, see ``server.lock``."""

    def __init__(self, home: Path, database: Database) -> None:
        self._folder = home / "uploads"
        self._database = database
        self._lock = threading.Lock()
        self._locks: dict[str, _FileLock] = {}

    @contextmanager
    def lock(self, digest: str) -> Iterator[None]:
        """Lock the file of a SHA-256 against others that would add or remove it; take it before any transaction."""
        with self._lock:
            file_lock = self._locks.setdefault(digest, _FileLock())
            file_lock.users += 1
        try:
            with file_lock.lock:
                yield
        finally:
            with self._lock:
                file_lock.users -= 1
                if not file_lock.users:
                    del self._locks[digest]

    def path_of(self, digest: str, suffix: str) -> Path:
        """Path of the file with a digest."""
        return self._folder / f"{digest}{suffix}"

    def remove(self, path: Path) -> None:
        """Remove a file that is no longer a video; hold the lock of its digest. Files elsewhere are not touched."""
        if path.parent != self._folder:
            return
        with self._database.read() as session:
            named = session.scalars(select(Video.id).where(Video.path == str(path)).limit(1)).first()
        if named is None:
            path.unlink(missing_ok=True)

    def update_paths(self) -> None:
        """Correct the rows of uploads if the data folder was moved, or restored under another name."""
        with self._database.write() as session:
            is_local = or_(Video.place.is_(None), Video.place == this_server(session))
            moved = ~Video.path.startswith(f"{self._folder}/", autoescape=True)
            for video in session.scalars(select(Video).where(Video.owned, is_local, moved)):
                path = self._folder / Path(video.path).name
                if path.is_file():
                    video.path = str(path)

    def new_part(self) -> Path:
        """New path for bytes that are being received."""
        self._folder.mkdir(parents=True, exist_ok=True)
        return self._folder / f".{uuid.uuid4().hex}.part"

    def clean_parts(self) -> None:
        """Remove files of interrupted uploads of an earlier process."""
        for part in self._folder.glob(".*.part"):
            part.unlink(missing_ok=True)
