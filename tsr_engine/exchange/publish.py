"""Publishes a folder or file only when it is complete, and leaves nothing behind if the process is killed.

The output is made in a hidden, locked folder beside its destination; see ``tsr_engine.io.unfinished``.
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
from tsr_engine.io.unfinished import create_locked_folder, fsync_path, remove_leftovers

_AT_FDCWD = -100
_RENAME_EXCHANGE = 2


@contextmanager
def staging_folder(out: Path) -> Iterator[Path]:
    """A locked, empty folder beside ``out``, removed at the end; first removes folders of processes that have ended.

    Raises:
        StorageError: the folder of ``out`` is not writable.
    """
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        remove_leftovers(out)
        folder, lock = create_locked_folder(out)
    except OSError as error:
        raise storage_error(out, error) from None
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


def publish(finished: Path, out: Path) -> None:
    """Rename a finished file or folder to ``out`` in one step; an older one gets the name of ``finished``.

    Raises:
        OSError: it cannot be renamed; ``out`` is unchanged.
    """
    if finished.is_dir() and out.is_dir():
        # A folder with content cannot be renamed over another; the two are exchanged.
        _exchange(finished, out)
    else:
        finished.replace(out)
    fsync_path(out.parent)


def fsync_tree(folder: Path) -> None:
    """Flush a file, or all files and folders below a folder, to the disk before something refers to it."""
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
    # On file systems without exchange, the export is missing for a moment, but never incomplete.
    old_name = first.with_name(f"{first.name}.old")
    second.rename(old_name)
    try:
        first.rename(second)
    except OSError:
        with suppress(OSError):
            old_name.rename(second)
        raise
    old_name.rename(first)
