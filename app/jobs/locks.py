"""Locks of running jobs: each process locks a file, which the kernel unlocks when the process ends.

The file holds the id of the process, and why the end of its job cannot be stored, while that is so. It reserves the
space for that, because the disk may be full then.
"""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from pathlib import Path

from tsr_engine.io.locks import is_locked, is_named

_SIZE = 512
"""Bytes of a file: the id, and a sentence in UTF-8 on the next line, filled up with spaces."""


def _path(home: Path, job_id: str) -> Path:
    return home / "locks" / f"{job_id}.lock"


class JobLock:
    """The lock of one job, held by its process."""

    def __init__(self, home: Path, job_id: str) -> None:
        self._path = _path(home, job_id)
        self._file: int | None = None

    def acquire(self) -> bool:
        """Take the lock; False: another process holds it.

        Raises:
            OSError: no lock file can be made in the data folder.
        """
        self._path.parent.mkdir(parents=True, exist_ok=True)
        while self._file is None:
            file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                os.close(file)
                return False
            if is_named(file, self._path):
                self._file = file
            else:
                os.close(file)  # the previous holder has removed the file meanwhile, so nobody would see this lock
        with suppress(OSError):  # the lock works without the id; the job itself reports a full disk
            os.ftruncate(self._file, 0)
            os.write(self._file, f"{os.getpid()}\n".encode().ljust(_SIZE))
        return True

    def release(self) -> None:
        """Release the lock."""
        if self._file is None:
            return
        file, self._file = self._file, None
        with suppress(OSError):
            self._path.unlink(missing_ok=True)
        os.close(file)


def is_alive(home: Path, job_id: str) -> bool:
    """Whether a process of this machine holds the job."""
    return is_locked(_path(home, job_id))


def holder_pid(home: Path, job_id: str) -> int | None:
    """Return the id of the process that holds the job, from its file; None: nobody."""
    return last_holder_pid(home, job_id) if is_alive(home, job_id) else None


def last_holder_pid(home: Path, job_id: str) -> int | None:
    """Return the id of the process that holds the job or died with it; None: nobody."""
    try:
        return int(_path(home, job_id).read_bytes().partition(b"\n")[0])
    except (OSError, ValueError):
        return None


def note_unstored_end(home: Path, job_id: str, reason: str) -> None:
    """Tell servers why the end of a job cannot be stored; called by the process that holds the job."""
    start = f"{os.getpid()}\n".encode()
    text = reason.encode()[: _SIZE - len(start)].decode(errors="ignore")
    with suppress(OSError), _path(home, job_id).open("r+b") as file:
        file.write(start + text.encode().ljust(_SIZE - len(start)))


def unstored_ends(home: Path) -> dict[str, str]:
    """Job -> why its end cannot be stored; without the jobs whose ends can be stored, or have not come."""
    reasons = {}
    for path in (home / "locks").glob("*.lock"):
        with suppress(OSError):  # the job has ended meanwhile
            text = path.read_bytes().partition(b"\n")[2].decode(errors="replace").strip()
            if text:
                reasons[path.stem] = text
    return reasons
