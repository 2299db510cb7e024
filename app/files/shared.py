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
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from app.errors import Busy
from app.files.store import SharedFilesError, SharedStore
from app.settings import Settings
from app.storage.identity import store_shared_id, stored_shared_id
from tsr_engine.errors import StorageError
from tsr_engine.io.atomic import storage_error
from tsr_engine.io.opened_file import Stamp, stamp_of

_MAX_FETCHES: Final = 4
"""Maximum number of parallel fetches of one process."""
_MAX_WAITERS: Final = 8
"""Maximum number of requests that wait for a fetch; the server has 40 threads for all requests."""
FETCH_TIMEOUT_S: Final = 6.0
"""Seconds that a request waits for a fetch."""
_PROBE_DELAY_S: Final = 2.0
"""Seconds of a fetch after which the shared files are asked whether they answer at all."""
_TOUCH_INTERVAL_S: Final = 60.0
"""Seconds after which another use of an entry is noted."""
MIN_UNUSED_S: Final = 3600.0
"""Seconds without use after which an entry may be removed to make room."""


@dataclass(frozen=True, slots=True)
class LocalCopy:
    """An entry of the shared files that also lies in the data folder.

    Attributes:
        name: name in the shared files.
        path: path in the data folder.
        size: bytes.
        used: time of its last use, seconds since the epoch.
        record: file that stores these values.
        stamp: state of a single file when its bytes were last compared.
    """

    name: str
    path: Path
    size: int
    used: float
    record: Path
    stamp: Stamp | None


class _Fetch:
    def __init__(self) -> None:
        self.over = threading.Event()
        self.error: Exception | None = None


class SharedFiles:
    """The shared files as seen by one data folder; thread-safe, and safe beside other processes of the folder.

    Attributes:
        is_blocking: callers wait until an entry is local, as in a worker; False: a slow fetch raises ``Busy``, so that
            the request is answered with 503.
    """

    def __init__(self, store: SharedStore, settings: Settings) -> None:
        self.store = store
        self.is_blocking = True
        self._home = settings.home
        self._id: str | None = None
        self._lock = threading.Lock()
        self._fetches: dict[str, _Fetch] = {}
        self._fetch_slots = threading.Semaphore(_MAX_FETCHES)
        self._waiter_slots = threading.Semaphore(_MAX_WAITERS)

    @property
    def id(self) -> str:
        """Id of the shared files, which rows of files in them carry.

        Raises:
            StorageError: no server of this data folder has used them yet.
        """
        if self._id is None:
            self._id = stored_shared_id(self._home, self.store.address)
        if self._id is None:
            raise StorageError("This data folder has never used the shared files. Start 'tsr review' on it first.")
        return self._id

    def prepare(self) -> str | None:
        """Read the id of the shared files, and remove what interrupted fetches have left.

        Returns:
            A sentence if they do not answer, but their id is known from before; None: they answer.

        Raises:
            StorageError: they do not answer and their id is unknown, or their id has changed.
        """
        shutil.rmtree(self._home / "fetching", ignore_errors=True)
        known = stored_shared_id(self._home, self.store.address)
        try:
            if known is not None:
                self.store.require_answer()  # the patience of other requests would delay the start of the server
            store_shared_id(self._home, self.store.address, self.store.store_id(known))
        except SharedFilesError as error:
            if known is None:
                raise StorageError(str(error)) from None
            return str(error)
        return None

    def fetch(self, name: str) -> Path:
        """Return the local path of an entry; fetch it first if needed.

        Raises:
            SharedFilesError: the shared files do not answer, or the entry is damaged.
            Busy: the fetch takes longer (not in a worker).
            StorageError: there is no room for it here.
        """
        path, record = self._home / name, self._record_path(name)
        if path.exists() and self._is_usable(path, self._read(record)):
            return path
        with self._lock:
            fetch = self._fetches.get(name)
            if fetch is None:
                fetch = self._fetches[name] = _Fetch()
                threading.Thread(
                    target=self._run_fetch, args=(name, path, fetch), name="tsr-fetch", daemon=True
                ).start()
        if not self.is_blocking:
            if not self._waiter_slots.acquire(blocking=False):
                raise _still_fetching()
            try:
                if not fetch.over.wait(min(_PROBE_DELAY_S, FETCH_TIMEOUT_S)):
                    self.store.require_answer()
                    if not fetch.over.wait(FETCH_TIMEOUT_S - _PROBE_DELAY_S):
                        raise _still_fetching()
            finally:
                self._waiter_slots.release()
        fetch.over.wait()
        if fetch.error is not None:
            raise fetch.error
        return path

    def mark_used(self, name: str) -> None:
        """Note a use of an entry."""
        self._touch(self._read(self._record_path(name)))

    def stamp(self, name: str) -> Stamp | None:
        """State of a fetched file when its bytes were last compared."""
        copy = self._read(self._record_path(name))
        return None if copy is None else copy.stamp

    def record_copy(self, name: str, path: Path, size: int) -> None:
        """Record that an entry of the shared files also lies here, so that it may be removed to make room."""
        record = self._record_path(name)
        record.parent.mkdir(parents=True, exist_ok=True)
        stamp = stamp_of(path.stat()) if path.is_file() else None
        part = record.with_name(f".{uuid.uuid4().hex}")
        values = {"name": name, "path": str(path.relative_to(self._home)), "size": size, "stamp": stamp}
        part.write_text(json.dumps(values), encoding="utf-8")
        part.replace(record)

    def local_copies(self) -> list[LocalCopy]:
        """The entries that lie in the data folder and in the shared files, least recently used first."""
        records = (self._home / "fetched").glob("[!.]*")
        return sorted(
            (copy for record in records if (copy := self._read(record)) is not None), key=lambda copy: copy.used
        )

    def remove_copy(self, copy: LocalCopy) -> None:
        """Remove the local copy of an entry; it stays in the shared files."""
        trash = self._home / "fetching" / uuid.uuid4().hex
        trash.parent.mkdir(parents=True, exist_ok=True)
        with self._lock_entry(copy.name):
            with suppress(FileNotFoundError):
                copy.path.replace(trash)
            copy.record.unlink(missing_ok=True)
        _remove(trash)

    def remove_in_background(self, *names: str) -> None:
        """Remove local copies now, and their entries of the shared files in the background.

        Entries that cannot be removed now stay there.
        """
        for name in names:
            # before the caller goes on: the same entry can be added again
            if (copy := self._read(self._record_path(name))) is not None:
                self.remove_copy(copy)

        def work() -> None:
            for name in names:
                with suppress(SharedFilesError):
                    self.store.remove(name)

        threading.Thread(target=work, name="tsr-forget", daemon=True).start()

    # ------------------------------------------------------------------------------------------------------ inside

    def _run_fetch(self, name: str, path: Path, fetch: _Fetch) -> None:
        try:
            with self._fetch_slots, self._lock_entry(name):
                if not path.exists():  # otherwise another process was faster
                    self._fetch(name, path)
        except OSError as error:
            fetch.error = storage_error(path, error)
        except Exception as error:  # noqa: BLE001 - raised to the callers that wait
            fetch.error = error
        finally:
            with self._lock:
                self._fetches.pop(name, None)
            fetch.over.set()

    def _fetch(self, name: str, path: Path) -> None:
        files = self.store.list_files(name)
        size = sum(size for size, _ in files.values())
        if name.startswith("videos/") and {digest for _, digest in files.values()} != {path.name}:
            raise SharedFilesError(f"The shared files list other bytes for {name}.", code="files_damaged")
        part = self._home / "fetching" / uuid.uuid4().hex
        part.parent.mkdir(parents=True, exist_ok=True)
        try:
            self.store.get(name, files, part)
            path.parent.mkdir(parents=True, exist_ok=True)
            part.replace(path)
        finally:
            _remove(part)
        self.record_copy(name, path, size)

    def _is_usable(self, path: Path, copy: LocalCopy | None) -> bool:
        """Whether the local copy can be used; a single file that was changed is fetched again."""
        if copy is None:
            return True  # it was made here, not fetched
        if copy.stamp is not None and copy.path == path and copy.stamp != stamp_of(path.stat()):
            self.remove_copy(copy)
            return False
        self._touch(copy)
        return True

    @staticmethod
    def _touch(copy: LocalCopy | None) -> None:
        if copy is not None and time.time() - copy.used > _TOUCH_INTERVAL_S:
            with suppress(OSError):
                os.utime(copy.record)

    def _record_path(self, name: str) -> Path:
        return self._home / "fetched" / name.replace("/", "-")

    def _read(self, record: Path) -> LocalCopy | None:
        try:
            used = record.stat().st_mtime
            values = json.loads(record.read_text(encoding="utf-8"))
            stamp = values["stamp"] and tuple(values["stamp"])
            return LocalCopy(values["name"], self._home / values["path"], values["size"], used, record, stamp)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    @contextmanager
    def _lock_entry(self, name: str) -> Iterator[None]:
        """Lock an entry against fetches and removals by other processes of this data folder."""
        lock = self._home / "locks" / f"shared-{name.replace('/', '-')}"
        lock.parent.mkdir(parents=True, exist_ok=True)
        with lock.open("w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield


@functools.cache
def shared_files(settings: Settings) -> SharedFiles | None:
    """The shared files of a data folder, one object per process; None: there are none.

    Raises:
        MissingExtra: the package for their file system is not installed.
    """
    return None if settings.files is None else SharedFiles(SharedStore(settings.files), settings)


def ensure_local(settings: Settings, place: str | None, name: str) -> Path:
    """Return the path of the files of a row in the data folder; fetch them first if they lie in shared files.

    Args:
        settings: with the data folder.
        place: place of the row.
        name: relative to the data folder.

    Raises:
        SharedFilesError, Busy, StorageError: as for :meth:`SharedFiles.fetch`.
    """
    files = shared_files(settings)
    is_shared = files is not None and place is not None and place == files.id
    return files.fetch(name) if files is not None and is_shared else settings.home / name


def remove_shared(settings: Settings, rows: Iterable[tuple[str | None, str]]) -> None:
    """Remove what lies in the shared files of removed rows, each with its place and the name of its files."""
    files = shared_files(settings)
    if files is not None:
        files.remove_in_background(*(name for place, name in rows if place == files.id))


def _still_fetching() -> Busy:
    return Busy(
        "The files for this are still being fetched from the shared files. Repeat the request later.",
        code="files_coming",
    )


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
