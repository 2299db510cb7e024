"""Locks on files, which the kernel frees when their process ends, however it ends."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

__all__ = ["is_locked", "is_named"]


def is_locked(path: Path) -> bool:
    """Whether some process of this machine holds an exclusive lock on the file; no file is no lock.

    The test takes a shared lock for a moment: any number of processes may ask at the same time.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return True
    finally:
        os.close(descriptor)
    return False


def is_named(handle: int, path: Path) -> bool:
    """Whether an open file still has that name.

    To be asked after a lock was taken: between opening and locking, who held the file before may have removed its name,
    and the next one would lock another file of that name.
    """
    try:
        return os.fstat(handle).st_ino == path.stat().st_ino
    except OSError:
        return False
