"""Checks file locks, which the kernel releases when their process ends in any way."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path


def is_locked(path: Path) -> bool:
    """Whether a process of this machine holds an exclusive lock on the file; False if the file is missing.

    The test takes a shared lock for a moment, so any number of processes can test at the same time.
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

    Check this after taking a lock: the earlier holder may have removed the name between opening and locking, and the
    next process would lock another file of that name.
    """
    try:
        return os.fstat(handle).st_ino == path.stat().st_ino
    except OSError:
        return False
