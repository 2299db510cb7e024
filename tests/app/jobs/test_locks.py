"""Locks of jobs: one holder at a time, also while others acquire and release, and on a full disk."""

from __future__ import annotations

import errno
import fcntl
import os
from pathlib import Path

import pytest

from app.jobs.locks import JobLock, holder_pid, is_alive, note_unstored_end, unstored_ends

JOB = "a" * 32


def test_one_process_holds_a_job_and_is_known(tmp_path: Path) -> None:
    first, second = JobLock(tmp_path, JOB), JobLock(tmp_path, JOB)
    assert first.acquire()
    assert not second.acquire()
    assert holder_pid(tmp_path, JOB) == os.getpid()
    first.release()
    first.release()
    assert not is_alive(tmp_path, JOB)
    assert second.acquire()
    second.release()


def test_a_lock_released_while_another_process_opens_it_is_not_held_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next holder opens the file just before it is removed: its lock would be on an unlinked file."""
    first, second, third = (JobLock(tmp_path, JOB) for _ in range(3))
    assert first.acquire()
    flock = fcntl.flock

    def free_before(handle: int, operation: int) -> None:
        monkeypatch.setattr(fcntl, "flock", flock)
        first.release()
        flock(handle, operation)

    monkeypatch.setattr(fcntl, "flock", free_before)
    assert second.acquire()
    assert is_alive(tmp_path, JOB)
    assert not third.acquire()
    second.release()


def test_a_lock_on_a_full_disk_works_without_its_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_handle: int, _data: bytes) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    lock, other = JobLock(tmp_path, JOB), JobLock(tmp_path, JOB)
    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        assert lock.acquire()
    assert is_alive(tmp_path, JOB)
    assert holder_pid(tmp_path, JOB) is None
    assert not other.acquire()
    lock.release()


def test_the_reason_of_an_unstored_end_takes_no_more_space(tmp_path: Path) -> None:
    note_unstored_end(tmp_path, JOB, "nobody holds the job")
    assert unstored_ends(tmp_path) == {}
    lock = JobLock(tmp_path, JOB)
    assert lock.acquire()
    assert unstored_ends(tmp_path) == {}
    (file,) = (tmp_path / "locks").iterdir()
    size = file.stat().st_size
    for reason in ("the disk is full", "é" * 999, "voll"):
        note_unstored_end(tmp_path, JOB, reason)
        noted = unstored_ends(tmp_path)[JOB]
        assert noted == reason[: len(noted)]
        assert (file.stat().st_size, holder_pid(tmp_path, JOB)) == (size, os.getpid())
    assert unstored_ends(tmp_path) == {JOB: "voll"}
    lock.release()
    assert unstored_ends(tmp_path) == {}
