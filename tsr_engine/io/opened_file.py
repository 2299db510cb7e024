"""Opens a file once: type, size, hash and bytes come from the descriptor, never again from the name.

The file at a name can be replaced between two accesses. An open file stays the same.
"""

from __future__ import annotations

import hashlib
import io
import os
from pathlib import Path
from typing import Protocol, TypeAlias

from tsr_engine.errors import VideoError

Stamp: TypeAlias = tuple[int, int, int, int]
"""Inode, size in bytes, and modification and change time in ns; an untouched file keeps them."""


class FileSource(Protocol):
    """Opens a file by more than its name, and checks each time that it is still the same."""

    @property
    def path(self) -> Path:
        """The name that people see."""

    def open(self) -> OpenedFile:
        """Open the file; the caller closes it.

        Raises:
            VideoError: it is missing, cannot be read, or has been replaced by another file.
        """


VideoSource: TypeAlias = Path | FileSource
"""A path, or an object that opens a file."""


class OpenedFile:
    """An open file; a context manager.

    Attributes:
        path: the name that people see.
    """

    def __init__(self, descriptor: int, path: Path) -> None:
        """Take over a descriptor.

        Args:
            descriptor: open for reading; closed with the object.
            path: the name that people see.
        """
        self.path = path
        self._descriptor = descriptor

    @classmethod
    def by_name(cls, path: Path) -> OpenedFile:
        """Open a file by its name, following links.

        Raises:
            VideoError: it is missing or cannot be read.
        """
        try:
            # Without O_NONBLOCK, a pipe without a writer would block.
            return cls(os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOCTTY), path)
        except ValueError:
            raise VideoError(f"{str(path)!r} is no file name. Check it.") from None
        except OSError as error:
            raise VideoError(unreadable_message(path, error)) from None

    def __enter__(self) -> OpenedFile:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __str__(self) -> str:
        return str(self.path)

    def close(self) -> None:
        """Close the file; closing twice is harmless."""
        descriptor, self._descriptor = self._descriptor, -1
        if descriptor >= 0:
            os.close(descriptor)

    @property
    def status(self) -> os.stat_result:
        """The file's status.

        Raises:
            VideoError: the file is closed.
        """
        return os.fstat(self._open())

    @property
    def stamp(self) -> Stamp:
        """The file's stamp; it differs if somebody has touched the file."""
        return stamp_of(self.status)

    @property
    def reopen_path(self) -> str:
        """A path under which libraries can open this very file again, with a separate position.

        Raises:
            VideoError: the file is closed.
        """
        return f"/proc/self/fd/{self._open()}"

    def stream(self) -> io.BufferedReader:
        """The bytes from the beginning, as a separate stream.

        Raises:
            OSError: the file cannot be read.
        """
        return open(self.reopen_path, "rb")  # noqa: PTH123 - a name of the kernel's

    def sha256(self) -> str:
        """SHA-256 of the bytes, hex; the file is read piece by piece.

        Raises:
            VideoError: the file cannot be read.
        """
        try:
            with self.stream() as stream:
                return hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError as error:
            raise VideoError(unreadable_message(self.path, error)) from None

    def _open(self) -> int:
        if self._descriptor < 0:
            raise VideoError(f"{self.path} is closed. Open it again.")
        return self._descriptor


def stamp_of(status: os.stat_result) -> Stamp:
    """The stamp of a file by its status.

    The second time changes with every write to the file, and cannot be set.
    """
    return status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns


def display_path(source: VideoSource) -> Path:
    """The name of a source that people see."""
    return source if isinstance(source, Path) else source.path


def open_source(source: VideoSource | str) -> OpenedFile:
    """Open a source; the caller closes it.

    Raises:
        VideoError: it is missing, cannot be read, or has been replaced by another file.
    """
    return OpenedFile.by_name(Path(source)) if isinstance(source, str | Path) else source.open()


def unreadable_message(path: Path, error: OSError) -> str:
    """One sentence about a file that cannot be read."""
    if isinstance(error, FileNotFoundError):
        return f"There is no video at {path}. Check the path."
    return f"Cannot read the video {path}: {error.strerror}. Check the file and its permissions."
