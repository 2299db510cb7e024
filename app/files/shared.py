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
"""Things that one process fetches at a time."""
_MOST_WAITING: Final = 8
"""Requests that wait for a thing at a time; the server has 40 threads for all."""
PATIENCE: Final = 6.0
"""Seconds that a request waits for a thing to come."""
_TOUCH: Final = 60.0
"""Seconds after which the use of a thing is noted again."""
UNUSED: Final = 3600.0
"""Seconds that a thing must not have been used before it makes room for others."""


@dataclass(frozen=True, slots=True)
class Kept:
    """A thing that lies here and in the shared files.

    Attributes:
        name: in the shared files.
        path: here.
        size: bytes.
        used: when it was last used, seconds since the epoch.
        note: the file that says so.
        stamp: how a single file stood when its bytes were last compared.
    """

    name: str
    path: Path
    size: int
    used: float
    note: Path
    stamp: Stamp | None


class _Fetch:
    """One thing on its way."""

    def __init__(self) -> None:
        self.over = threading.Event()
        self.error: Exception | None = None


class SharedFiles:
    """The shared files as one data folder sees them; thread-safe, and other processes of the folder keep in step.

    Args:
        store: where they are.
        settings: name the data folder.

    Attributes:
        waits: whoever asks waits until a thing is here, as a worker does; False: a request is answered with 503 while
            that takes long.
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
        """Stands in the rows of what lies in the shared files.

        Raises:
            StorageError: no server of this data folder has seen them yet.
        """
        if self._id is None:
            self._id = shared_of(self._home, self.store.address)
        if self._id is None:
            raise StorageError("This data folder has not seen the shared files yet. Start 'tsr review' on it first.")
        return self._id

    def enter(self) -> str | None:
        """Learn the number of the shared files, and empty what broken fetches have left.

        Returns:
            A sentence if they do not answer, but are known from before; None: they answer.

        Raises:
            StorageError: they do not answer, and nobody here has ever seen them; or others lie there by now.
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
        """Where a thing lies here; fetched first if it does not.

        Raises:
            FilesAwayError: the shared files do not answer, or what they hold is damaged.
            Busy: it is still on its way (not in a worker).
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
        """Where the files of a row lie here; those that lie in the shared files are fetched first.

        Args:
            place: of the row.
            name: relative to the data folder.

        Raises:
            FilesAwayError, Busy, StorageError: as of :meth:`fetch`.
        """
        return self.fetch(name) if place is not None and place == self.id else self._home / name

    def used(self, name: str) -> None:
        """Note that a thing is used here."""
        self._touch(self._read(self._note(name)))

    def stamp(self, name: str) -> Stamp | None:
        """How a fetched file stood when its bytes were last compared."""
        kept = self._read(self._note(name))
        return None if kept is None else kept.stamp

    def note(self, name: str, path: Path, size: int) -> None:
        """Remember that a thing of the shared files also lies here, and may make room for others."""
        note = self._note(name)
        note.parent.mkdir(parents=True, exist_ok=True)
        stamp = stamp_of(path.stat()) if path.is_file() else None
        part = note.with_name(f".{uuid.uuid4().hex}")
        said = {"name": name, "path": str(path.relative_to(self._home)), "size": size, "stamp": stamp}
        part.write_text(json.dumps(said), encoding="utf-8")
        part.replace(note)

    def kept(self) -> list[Kept]:
        """What lies here and there, the least recently used first."""
        notes = (self._home / "fetched").glob("[!.]*")
        return sorted((kept for note in notes if (kept := self._read(note)) is not None), key=lambda kept: kept.used)

    def drop(self, kept: Kept) -> None:
        """Remove a thing here; it stays in the shared files."""
        aside = self._home / "fetching" / uuid.uuid4().hex
        aside.parent.mkdir(parents=True, exist_ok=True)
        with self._alone(kept.name):
            with suppress(FileNotFoundError):
                kept.path.replace(aside)
            kept.note.unlink(missing_ok=True)
        _remove(aside)

    def forget(self, *names: str) -> None:
        """Remove things in the shared files, beside whatever goes on; what cannot be removed now stays there."""

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
                if not path.exists():  # else another process was faster
                    self._fetch(name, path)
        except OSError as error:
            fetch.error = storage_error(path, error)
        except Exception as error:  # noqa: BLE001 - it is raised to whoever waits
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
        """Whether what lies here can be used; a single file that somebody has touched is fetched anew."""
        if kept is None:
            return True  # it was made here
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
        """No other process of this data folder fetches or drops the thing meanwhile."""
        place = self._home / "locks" / f"shared-{name.replace('/', '-')}"
        place.parent.mkdir(parents=True, exist_ok=True)
        with place.open("w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield


@functools.cache
def shared_files(settings: Settings) -> SharedFiles | None:
    """The shared files of a data folder, one for a process; None: its files are its own.

    Raises:
        MissingExtra: what reads them is not installed.
    """
    return None if settings.files is None else SharedFiles(SharedStore(settings.files), settings)


def present(settings: Settings, place: str | None, name: str) -> Path:
    """Where the files of a row lie in the data folder; those that lie in shared files are fetched first.

    Args:
        settings: name the data folder.
        place: of the row.
        name: relative to the data folder.

    Raises:
        FilesAwayError, Busy, StorageError: as of :meth:`SharedFiles.fetch`.
    """
    files = shared_files(settings)
    return settings.home / name if files is None else files.present(place, name)


def _on_its_way() -> Busy:
    return Busy(
        "What this needs is still being fetched from the shared files. The request can be repeated.",
        code="files_coming",
    )


def _remove(place: Path) -> None:
    if place.is_dir():
        shutil.rmtree(place, ignore_errors=True)
    else:
        place.unlink(missing_ok=True)
