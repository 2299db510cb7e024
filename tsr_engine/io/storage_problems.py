"""Names the reason why a write failed: no space, a limit on the file's size, or a failing disk."""

from __future__ import annotations

import errno
import resource
import sqlite3
from typing import Final

from tsr_engine.errors import StorageProblem

_WRITE_ERROR_CODES: Final = (sqlite3.SQLITE_IOERR_WRITE, sqlite3.SQLITE_IOERR_TRUNCATE, sqlite3.SQLITE_IOERR_SHMSIZE)
TOO_LARGE_MESSAGE: Final = (
    "the file would be larger than this process (ulimit -f) or the file system allows; raise the limit or choose "
    "another folder"
)
"""End of a sentence about a file that is too large."""


def storage_problem(error: BaseException) -> StorageProblem:
    """The reason for an operating system's error on writing."""
    number = getattr(error, "errno", None)
    if number in (errno.ENOSPC, errno.EDQUOT):
        return "full"
    return "limit" if number == errno.EFBIG else "failed"


def database_problem(error: sqlite3.Error) -> StorageProblem:
    """The same for SQLite, which does not state why a write failed; a limit on this process counts as the cause."""
    code = getattr(error, "sqlite_errorcode", 0)
    if code == sqlite3.SQLITE_FULL:
        return "full"
    limited = resource.getrlimit(resource.RLIMIT_FSIZE)[0] != resource.RLIM_INFINITY
    return "limit" if limited and code in _WRITE_ERROR_CODES else "failed"


def full_disk_reason(error: BaseException) -> str:
    """Whether the disk is full or the disk quota is used up, in words."""
    quota = getattr(error, "errno", None) == errno.EDQUOT
    return "the disk quota is used up" if quota else "the disk is full"
