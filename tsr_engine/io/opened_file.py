"""A file that is opened once: type, size, hash and bytes come from the descriptor, never from the name again.

Somebody may put another file at a name between two accesses. An open file stays the same.
"""

from __future__ import annotations

import hashlib
import io
import os
from pathlib import Path
from typing import Protocol, TypeAlias

from tsr_engine.errors import VideoError

__all__ = ["FileSource", "OpenedFile", "Stamp", "VideoSource", "named", "open_source", "stamp_of", "unreadable"]

Stamp: TypeAlias = tuple[int, int, int, int]
"""Inode, bytes, time of change of the bytes and of the file's data, both in ns: what tells an untouched file."""


class FileSource(Protocol):
    """Opens a file by more than its name, and checks each time that it is still the same."""

    @property
    def path(self) -> Path:
        """What people call it."""

    def open(self) -> OpenedFile:
        """Open it; the caller closes it.

        Raises:
            VideoError: it is missing, cannot be read, or is another file by now.
        """


VideoSource: TypeAlias = Path | FileSource
"""A file by its name, or by whoever opens it."""


class OpenedFile:
    """An open file; a context manager.

    Attributes:
        path: what people call it.
    """

    def __init__(self, descriptor: int, path: Path) -> None:
        """Take a descriptor over.

        Args:
            descriptor: open for reading; closed with the object.
            path: what people call the file.
        """
        self.path = path
        self._descriptor = descriptor

    @classmethod
    def by_name(cls, path: Path) -> OpenedFile:
        """Open a file by its name, through links.

        Raises:
            VideoError: it is missing or cannot be read.
        """
        try:
            # a pipe without a writer must not hold anybody up
            return cls(os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOCTTY), path)
        except ValueError:
            raise VideoError(f"{str(path)!r} is no file name. Check it.") from None
        except OSError as error:
            raise VideoError(unreadable(path, error)) from None

    def __enter__(self) -> OpenedFile:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __str__(self) -> str:
        return str(self.path)

    def close(self) -> None:
        """Close it; closing twice is harmless."""
        descriptor, self._descriptor = self._descriptor, -1
        if descriptor >= 0:
            os.close(descriptor)

    @property
    def status(self) -> os.stat_result:
        """What the file is.

        Raises:
            VideoError: it is closed.
        """
        return os.fstat(self._open())

    @property
    def stamp(self) -> Stamp:
        """How the file stands: another stamp means that somebody has touched it."""
        return stamp_of(self.status)

    @property
    def name_again(self) -> str:
        """A name for libraries, that opens this very file once more, with a position of its own.

        Raises:
            VideoError: it is closed.
        """
        return f"/proc/self/fd/{self._open()}"

    def stream(self) -> io.BufferedReader:
        """The bytes from the beginning, as a stream of its own.

        Raises:
            OSError: it cannot be read.
        """
        return open(self.name_again, "rb")  # noqa: PTH123 - a name of the kernel's

    def sha256(self) -> str:
        """SHA-256 of the bytes, hex; a piece of them in memory at a time.

        Raises:
            VideoError: they cannot be read.
        """
        try:
            with self.stream() as stream:
                return hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError as error:
            raise VideoError(unreadable(self.path, error)) from None

    def _open(self) -> int:
        if self._descriptor < 0:
            raise VideoError(f"{self.path} is closed. Open it again.")
        return self._descriptor


def stamp_of(status: os.stat_result) -> Stamp:
    """The stamp of a file by what the kernel says of it.

    The second time changes whatever is written to the file, and cannot be set.
    """
    return status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns


def named(source: VideoSource) -> Path:
    """What people call a source."""
    return source if isinstance(source, Path) else source.path


def open_source(source: VideoSource | str) -> OpenedFile:
    """Open a source; the caller closes it.

    Raises:
        VideoError: it is missing, cannot be read, or is another file by now.
    """
    return OpenedFile.by_name(Path(source)) if isinstance(source, str | Path) else source.open()


def unreadable(path: Path, error: OSError) -> str:
    """One sentence on a file that cannot be read."""
    if isinstance(error, FileNotFoundError):
        return f"There is no video at {path}. Check the path."
    return f"Cannot read the video {path}: {error.strerror}. Check the file and its permissions."
