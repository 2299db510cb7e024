"""The data folder as a cache of the shared files: fetched on demand, once at a time, atomically."""

from __future__ import annotations

import fcntl
import functools
import json
import os
import shutil
import threading
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from app.errors import Busy
from app.files.store import FilesAwayError, SharedStore
from app.settings import Settings
from app.storage.identity import note_shared, shared_of
from tsr_engine.errors import StorageError
from tsr_engine.io.atomic import storage_error
from tsr_engine.io.opened_file import Stamp, stamp_of

__all__ = ["PATIENCE", "UNUSED", "Kept", "SharedFiles", "present", "shared_files"]

_AT_ONCE: Final = 4
"""Maximum number of parallel fetches of one process."""
_MOST_WAITING: Final = 8
"""Maximum number of requests that wait for a fetch; the server has 40 threads for all requests."""
PATIENCE: Final = 6.0
"""Seconds that a request waits for a fetch."""
_TOUCH: Final = 60.0
"""Seconds after which another use of an entry is noted."""
UNUSED: Final = 3600.0
"""Seconds without use after which an entry may be removed to make room."""


@dataclass(frozen=True, slots=True)
class Kept:
    """An entry of the shared files that also lies here.

    Attributes:
        name: name in the shared files.
        path: path here.
        size: bytes.
        used: time of its last use, seconds since the epoch.
        note: file that stores these values.
        stamp: state of a single file when its bytes were last compared.
    """

    name: str
    path: Path
    size: int
    used: float
    note: Path
    stamp: Stamp | None


class _Fetch:
    def __init__(self) -> None:
        self.over = threading.Event()
        self.error: Exception | None = None


class SharedFiles:
    """The shared files as seen by one data folder; thread-safe, and safe beside other processes of the folder.

    Args:
        store: the shared files.
        settings: with the data folder.

    Attributes:
        waits: callers wait until an entry is here, as in a worker; False: a slow fetch raises ``Busy``, so that the
            request is answered with 503.
    """

    def __init__(self, store: SharedStore, settings: Settings) -> None:
        self.store = store
        self.waits = True
        self._home = settings.home
        self._id: str | None = None
        self._lock = threading.Lock()
        self._under_way: dict[str, _Fetch] = {}
        self._turns = threading.Semaphore(_AT_ONCE)
        self._waiting = threading.Semaphore(_MOST_WAITING)

    @property
    def id(self) -> str:
        """Id of the shared files, which rows of files in them carry.

        Raises:
            StorageError: no server of this data folder has used them yet.
        """
        if self._id is None:
            self._id = shared_of(self._home, self.store.address)
        if self._id is None:
            raise StorageError("This data folder has never used the shared files. Start 'tsr review' on it first.")
        return self._id

    def enter(self) -> str | None:
        """Read the id of the shared files, and remove what interrupted fetches have left.

        Returns:
            A sentence if they do not answer, but their id is known from before; None: they answer.

        Raises:
            StorageError: they do not answer and their id is unknown, or their id has changed.
        """
        shutil.rmtree(self._home / "fetching", ignore_errors=True)
        known = shared_of(self._home, self.store.address)
        try:
            note_shared(self._home, self.store.address, self.store.number(known))
        except FilesAwayError as error:
            if known is None:
                raise StorageError(str(error)) from None
            return str(error)
        return None

    def fetch(self, name: str) -> Path:
        """Return the local path of an entry; fetch it first if needed.

        Raises:
            FilesAwayError: the shared files do not answer, or the entry is damaged.
            Busy: the fetch takes longer (not in a worker).
            StorageError: there is no room for it here.
        """
        path, note = self._home / name, self._note(name)
        if path.exists() and self._sound(path, self._read(note)):
            return path
        with self._lock:
            fetch = self._under_way.get(name)
            if fetch is None:
                fetch = self._under_way[name] = _Fetch()
                threading.Thread(target=self._work, args=(name, path, fetch), name="tsr-fetch", daemon=True).start()
        if not self.waits:
            if not self._waiting.acquire(blocking=False):
                raise _on_its_way()
            try:
                if not fetch.over.wait(PATIENCE):
                    raise _on_its_way()
            finally:
                self._waiting.release()
        fetch.over.wait()
        if fetch.error is not None:
            raise fetch.error
        return path

    def present(self, place: str | None, name: str) -> Path:
        """Return the local path of the files of a row; fetch them first if they lie in the shared files.

        Args:
            place: place of the row.
            name: relative to the data folder.

        Raises:
            FilesAwayError, Busy, StorageError: as for :meth:`fetch`.
        """
        return self.fetch(name) if place is not None and place == self.id else self._home / name

    def used(self, name: str) -> None:
        """Note a use of an entry."""
        self._touch(self._read(self._note(name)))

    def stamp(self, name: str) -> Stamp | None:
        """State of a fetched file when its bytes were last compared."""
        kept = self._read(self._note(name))
        return None if kept is None else kept.stamp

    def note(self, name: str, path: Path, size: int) -> None:
        """Record that an entry of the shared files also lies here, so that it may be removed to make room."""
        note = self._note(name)
        note.parent.mkdir(parents=True, exist_ok=True)
        stamp = stamp_of(path.stat()) if path.is_file() else None
        part = note.with_name(f".{uuid.uuid4().hex}")
        said = {"name": name, "path": str(path.relative_to(self._home)), "size": size, "stamp": stamp}
        part.write_text(json.dumps(said), encoding="utf-8")
        part.replace(note)

    def kept(self) -> list[Kept]:
        """The entries that lie here and in the shared files, least recently used first."""
        notes = (self._home / "fetched").glob("[!.]*")
        return sorted((kept for note in notes if (kept := self._read(note)) is not None), key=lambda kept: kept.used)

    def drop(self, kept: Kept) -> None:
        """Remove the local copy of an entry; it stays in the shared files."""
        aside = self._home / "fetching" / uuid.uuid4().hex
        aside.parent.mkdir(parents=True, exist_ok=True)
        with self._alone(kept.name):
            with suppress(FileNotFoundError):
                kept.path.replace(aside)
            kept.note.unlink(missing_ok=True)
        _remove(aside)

    def forget(self, *names: str) -> None:
        """Remove entries of the shared files in the background; entries that cannot be removed now stay there."""

        def work() -> None:
            for name in names:
                self._note(name).unlink(missing_ok=True)
                with suppress(FilesAwayError):
                    self.store.remove(name)

        threading.Thread(target=work, name="tsr-forget", daemon=True).start()

    # ------------------------------------------------------------------------------------------------------ inside

    def _work(self, name: str, path: Path, fetch: _Fetch) -> None:
        try:
            with self._turns, self._alone(name):
                if not path.exists():  # otherwise another process was faster
                    self._fetch(name, path)
        except OSError as error:
            fetch.error = storage_error(path, error)
        except Exception as error:  # noqa: BLE001 - raised to the callers that wait
            fetch.error = error
        finally:
            with self._lock:
                self._under_way.pop(name, None)
            fetch.over.set()

    def _fetch(self, name: str, path: Path) -> None:
        files = self.store.listed(name)
        size = sum(size for size, _ in files.values())
        if name.startswith("videos/") and {digest for _, digest in files.values()} != {path.name}:
            raise FilesAwayError(f"The shared files list other bytes for {name}.", code="files_damaged")
        part = self._home / "fetching" / uuid.uuid4().hex
        part.parent.mkdir(parents=True, exist_ok=True)
        try:
            self.store.get(name, files, part)
            path.parent.mkdir(parents=True, exist_ok=True)
            part.replace(path)
        finally:
            _remove(part)
        self.note(name, path, size)

    def _sound(self, path: Path, kept: Kept | None) -> bool:
        """Whether the local copy can be used; a single file that was changed is fetched again."""
        if kept is None:
            return True  # it was made here, not fetched
        if kept.stamp is not None and kept.path == path and kept.stamp != stamp_of(path.stat()):
            self.drop(kept)
            return False
        self._touch(kept)
        return True

    @staticmethod
    def _touch(kept: Kept | None) -> None:
        if kept is not None and time.time() - kept.used > _TOUCH:
            with suppress(OSError):
                os.utime(kept.note)

    def _note(self, name: str) -> Path:
        return self._home / "fetched" / name.replace("/", "-")

    def _read(self, note: Path) -> Kept | None:
        try:
            used = note.stat().st_mtime
            said = json.loads(note.read_text(encoding="utf-8"))
            stamp = said["stamp"] and tuple(said["stamp"])
            return Kept(said["name"], self._home / said["path"], said["size"], used, note, stamp)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    @contextmanager
    def _alone(self, name: str) -> Iterator[None]:
        """Lock an entry against fetches and removals by other processes of this data folder."""
        place = self._home / "locks" / f"shared-{name.replace('/', '-')}"
        place.parent.mkdir(parents=True, exist_ok=True)
        with place.open("w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield


@functools.cache
def shared_files(settings: Settings) -> SharedFiles | None:
    """The shared files of a data folder, one object per process; None: there are none.

    Raises:
        MissingExtra: the package for their file system is not installed.
    """
    return None if settings.files is None else SharedFiles(SharedStore(settings.files), settings)


def present(settings: Settings, place: str | None, name: str) -> Path:
    """Return the path of the files of a row in the data folder; fetch them first if they lie in shared files.

    Args:
        settings: with the data folder.
        place: place of the row.
        name: relative to the data folder.

    Raises:
        FilesAwayError, Busy, StorageError: as for :meth:`SharedFiles.fetch`.
    """
    files = shared_files(settings)
    return settings.home / name if files is None else files.present(place, name)


def _on_its_way() -> Busy:
    return Busy(
        "The files for this are still being fetched from the shared files. Repeat the request later.",
        code="files_coming",
    )


def _remove(place: Path) -> None:
    if place.is_dir():
        shutil.rmtree(place, ignore_errors=True)
    else:
        place.unlink(missing_ok=True)
