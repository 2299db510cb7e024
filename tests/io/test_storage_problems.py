"""A full disk, a used-up quota, a file size limit and a failing disk have different sentences."""

from __future__ import annotations

import errno
import os
import resource
import sqlite3
from pathlib import Path

import pytest
from sqlalchemy.exc import OperationalError

from app.errors import storage_full
from app.storage.database import storage_failure
from tsr_engine.io.atomic import storage_error


@pytest.mark.parametrize(
    ("number", "kind", "words"),
    [
        (errno.ENOSPC, "full", "the disk is full. Free some space"),
        (errno.EDQUOT, "full", "the disk quota is used up. Free some space"),
        (errno.EFBIG, "limit", "the file would be larger than this process (ulimit -f)"),
        (errno.EIO, "failed", "Input/output error"),
        (errno.EACCES, "failed", "Permission denied"),
    ],
)
def test_errors_of_the_operating_system(number: int, kind: str, words: str) -> None:
    refusal = OSError(number, os.strerror(number))
    error = storage_error(Path("/out/a"), refusal)
    assert error.kind == kind
    assert words in str(error)
    answer = storage_full(refusal)
    assert (None if answer is None else answer.code) == (None if kind == "failed" else f"storage_{kind}")


@pytest.mark.parametrize(
    ("text", "code", "limited", "told"),
    [
        ("database or disk is full", sqlite3.SQLITE_FULL, False, "storage_full"),
        ("disk I/O error", sqlite3.SQLITE_IOERR_WRITE, False, "storage_failed"),
        ("disk I/O error", sqlite3.SQLITE_IOERR_WRITE, True, "storage_limit"),
        ("disk I/O error", sqlite3.SQLITE_IOERR_READ, True, "storage_failed"),
    ],
)
def test_errors_of_sqlite(text: str, code: int, limited: bool, told: str, monkeypatch: pytest.MonkeyPatch) -> None:
    soft = 4096 if limited else resource.RLIM_INFINITY
    monkeypatch.setattr(resource, "getrlimit", lambda _: (soft, resource.RLIM_INFINITY))
    cause = sqlite3.OperationalError(text)
    cause.sqlite_errorcode = code
    failure = storage_failure(OperationalError("INSERT", {}, cause))
    assert failure is not None
    assert (failure.status, failure.code) == (507, told)
