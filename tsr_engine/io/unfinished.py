"""Creates the temporary file of an output: a hidden sibling with a random name, locked by its writer.

Two processes that make the same output use different names, and the last one to finish wins. The kernel releases the
lock of a dead process, so the next writer of the output can distinguish leftovers from work in progress.
"""

from __future__ import annotations

import errno
import fcntl
import hashlib
import os
import re
import secrets
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Final

from tsr_engine.io.locks import is_named

_SUFFIX: Final = ".part"
_MAX_NAME_BYTES: Final = 255
"""Longest name of a file, in bytes, on the usual file systems."""
_LONG_NAME_BYTES: Final = 200
"""The temporary name of an output with a longer name, in bytes, has a digest of it."""
_NO_FOLDER_SYNC: Final = (errno.EACCES, errno.EPERM, errno.EINVAL, errno.ENOTSUP)
"""Errors of systems that cannot flush a folder's names to the disk, or must not read the folder."""


class UnfinishedFile:
    """A new, empty file beside its target; finish it with :meth:`commit` or :meth:`drop`.

    Args:
        out: the target, in an existing folder. Leftovers of dead writers of it are removed first.

    Raises:
        OSError: the folder is not writable.
    """

    def __init__(self, out: Path) -> None:
        remove_leftovers(out)
        self._out = out
        self._handle: int | None = None
        while self._handle is None:
            self.path = _random_sibling(out)
            handle = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
            self._handle = _lock_new_file(handle, self.path)

    def commit(self) -> None:
        """Flush the content to the disk and rename the file to its target, replacing an older file.

        Raises:
            OSError: the disk is full, or the file cannot be renamed.
        """
        if self._handle is None:
            raise ValueError(f"An unfinished file is committed once. {self._out} was committed or dropped before.")
        os.fsync(self._handle)
        self.path.replace(self._out)
        self.drop()
        fsync_path(self._out.parent)

    def drop(self) -> None:
        """Remove an uncommitted file; harmless after :meth:`commit` and a second time."""
        if self._handle is None:
            return
        handle, self._handle = self._handle, None
        with suppress(OSError):
            self.path.unlink(missing_ok=True)
        os.close(handle)


def create_locked_folder(out: Path) -> tuple[Path, int]:
    """A new, empty folder beside ``out``, and the descriptor that holds its lock until it is closed.

    Raises:
        OSError: the folder of ``out`` is not writable.
    """
    while True:
        folder = _random_sibling(out)
        folder.mkdir(mode=0o755)
        with suppress(FileNotFoundError):  # another process removed it between the two steps
            lock = _lock_new_file(os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC), folder)
            if lock is not None:
                return folder, lock


def remove_leftovers(out: Path) -> list[Path]:
    """Remove leftovers of dead writers of ``out``; those of living ones stay. Returns the removed paths."""
    removed: list[Path] = []
    for leftover in _list_part_files(out):
        lock = _lock_leftover(leftover)
        if lock is None:
            continue
        if leftover.is_dir():
            shutil.rmtree(leftover, ignore_errors=True)
        else:
            with suppress(OSError):
                leftover.unlink(missing_ok=True)
        os.close(lock)
        removed.append(leftover)
    return removed


def fsync_path(path: Path) -> None:
    """Flush a file's content, or the names in a folder, to the disk.

    Folders are skipped on systems that cannot flush them.

    Raises:
        OSError: the disk is full or broken.
    """
    try:
        handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
    except OSError as error:
        if error.errno not in _NO_FOLDER_SYNC or not path.is_dir():
            raise


def _random_sibling(out: Path) -> Path:
    return out.with_name(f".{_stem(out)}.{secrets.token_hex(8)}{_SUFFIX}")


def _stem(out: Path) -> str:
    """The name of the output, or a digest of it if the temporary name would exceed what a folder can hold.

    A name that is too long itself stays, so that it is refused before the work.
    """
    name = os.fsencode(out.name)
    return hashlib.sha256(name).hexdigest() if _LONG_NAME_BYTES < len(name) <= _MAX_NAME_BYTES else out.name


def _list_part_files(out: Path) -> list[Path]:
    name = re.compile(rf"\.{re.escape(_stem(out))}\.[0-9a-f]+{re.escape(_SUFFIX)}")
    with suppress(OSError), os.scandir(out.parent) as entries:
        return [out.parent / entry.name for entry in entries if name.fullmatch(entry.name)]
    return []


def _lock_new_file(handle: int, path: Path) -> int | None:
    """The descriptor with the lock of a new file; None, and closed: a sweep has removed the file."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        return None
    except OSError:
        return handle  # a file system without locks, where a sweep gets none either
    return _check_name(handle, path)


def _lock_leftover(path: Path) -> int | None:
    """A descriptor that holds the lock of a leftover; None: its writer lives, or it is gone."""
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        return None
    return _check_name(handle, path)


def _check_name(handle: int, path: Path) -> int | None:
    """The descriptor, if its file still has that name; else None, and closed."""
    if is_named(handle, path):
        return handle
    os.close(handle)
    return None
