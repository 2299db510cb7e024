"""Gives a folder or file its name only when it is whole, and leaves nothing behind if the process is killed.

The output is made in a hidden, locked folder beside its place; see ``tsr_engine.io.unfinished``.
"""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tsr_engine.io.atomic import storage_error
from tsr_engine.io.unfinished import claim_folder, fsync_path, sweep

__all__ = ["fsync_tree", "publish", "sweep", "workshop"]

_AT_FDCWD = -100
_RENAME_EXCHANGE = 2


@contextmanager
def workshop(out: Path) -> Iterator[Path]:
    """A locked, empty folder beside ``out``; removed at the end. Removes those of processes that have ended first.

    Raises:
        StorageError: the folder of ``out`` cannot be written.
    """
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        sweep(out)
        folder, lock = claim_folder(out)
    except OSError as error:
        raise storage_error(out, error) from None
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


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
    fsync_path(out.parent)


def fsync_tree(folder: Path) -> None:
    """Have a file, or every file and folder below a folder, on the disk before something points to it."""
    if folder.is_file():
        fsync_path(folder)
    for root, _, files in os.walk(folder):
        for name in files:
            fsync_path(Path(root) / name)
        fsync_path(Path(root))


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
