"""A folder or file that takes its name only when it is whole, and leaves nothing behind when its maker is killed.

Everything is made in a hidden sibling folder that its maker holds locked. The kernel drops the lock of a dead process,
so whoever publishes next to it can tell rubbish from work in progress.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tsr_engine.io.atomic import storage_error

__all__ = ["fsync_tree", "publish", "sweep", "workshop"]

_AT_FDCWD = -100
_RENAME_EXCHANGE = 2
_SUFFIX = ".part"


@contextmanager
def workshop(out: Path) -> Iterator[Path]:
    """A locked, empty folder beside ``out``; removed at the end. Removes those of dead makers first.

    Raises:
        StorageError: the folder of ``out`` cannot be written.
    """
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        sweep(out)
        folder, lock = _make(out)
    except OSError as error:
        raise storage_error(out, error) from None
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


def sweep(out: Path) -> list[Path]:
    """Remove what dead makers of ``out`` left beside it; what a living one holds stays. Returns what was removed."""
    removed: list[Path] = []
    for rest in out.parent.glob(f".{_escaped(out.name)}.*{_SUFFIX}"):
        lock = _locked(rest)
        if lock is None:
            continue
        shutil.rmtree(rest, ignore_errors=True)
        os.close(lock)
        removed.append(rest)
    return removed


def publish(made: Path, out: Path) -> None:
    """Give a finished file or folder its name in one step; what had the name before takes the other one.

    Raises:
        OSError: it cannot be renamed; ``out`` is as before.
    """
    if made.is_dir() and out.is_dir():
        # A folder with content cannot be renamed over; the two change places.
        _exchange(made, out)
    else:
        made.replace(out)
    _fsync(out.parent)


def fsync_tree(folder: Path) -> None:
    """Have a file, or every file and folder below a folder, on the disk before something points to it."""
    if folder.is_file():
        _fsync(folder)
    for root, _, files in os.walk(folder):
        for name in files:
            _fsync(Path(root) / name)
        _fsync(Path(root))


def _make(out: Path) -> tuple[Path, int]:
    while True:
        folder = out.with_name(f".{out.name}.{secrets.token_hex(8)}{_SUFFIX}")
        folder.mkdir(mode=0o755)
        lock = _locked(folder)
        if lock is not None:
            return folder, lock
        # A sweep came between the two steps and took the folder for rubbish; the next name is a new chance.


def _locked(folder: Path) -> int | None:
    """A descriptor that holds the lock of a folder; None: somebody else holds it, or the folder is gone."""
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        same = os.fstat(handle).st_ino == folder.stat().st_ino
    except OSError:
        same = False
    if same:
        return handle
    os.close(handle)
    return None


def _exchange(first: Path, second: Path) -> None:
    libc = ctypes.CDLL(None, use_errno=True)
    names = [os.fsencode(first), os.fsencode(second)]
    if hasattr(libc, "renameat2"):
        if libc.renameat2(_AT_FDCWD, names[0], _AT_FDCWD, names[1], _RENAME_EXCHANGE) == 0:
            return
        code = ctypes.get_errno()
        if code not in (errno.EINVAL, errno.ENOSYS):
            raise OSError(code, os.strerror(code), str(second))
    # File systems without exchange: for a moment there is no export, never half of one.
    aside = first.with_name(f"{first.name}.old")
    second.rename(aside)
    try:
        first.rename(second)
    except OSError:
        with suppress(OSError):
            aside.rename(second)
        raise
    aside.rename(first)


def _fsync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _escaped(name: str) -> str:
    return "".join(f"[{letter}]" if letter in "*?[" else letter for letter in name)
