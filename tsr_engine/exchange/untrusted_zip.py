"""Opens untrusted ZIP archives: the list of entries is measured before it is parsed."""

from __future__ import annotations

import errno
import io
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tsr_engine.errors import ImportFormatError

_ENTRY_SIGNATURE = b"PK\x01\x02"
"""Signature at the start of each entry in the list."""
_END_BYTES = 1 << 17
"""Largest block that the search for an archive's end reads at once, bytes."""
_ZIP_ERRORS = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, struct.error, ValueError, OverflowError)
"""Exceptions of zipfile for invalid or unsupported archives; bad names raise ValueError."""


@dataclass(frozen=True, slots=True)
class ArchiveLimits:
    """The limits of an unpacked archive.

    Attributes:
        entries: largest number of files and folders.
        total: largest size of all files together, bytes.
        single: largest size of one file, bytes.
        ratio: largest ratio of unpacked to packed size; text of annotations stays below 60.
        directory: largest list of entries, bytes, whatever length the archive states.
        advice: what to do about an archive with more entries.
    """

    entries: int = 400_000
    total: int = 32 << 30
    single: int = 8 << 30
    ratio: int = 250
    directory: int = 64 << 20
    advice: str = "Split it."


def is_archive(path: Path) -> bool:
    """Whether a file ends as a ZIP archive does, even if the rest is damaged."""
    try:
        return zipfile.is_zipfile(path)
    except zipfile.BadZipFile:
        return True  # the archive has several disks: opening it reports what is wrong


@contextmanager
def open_zip(path: Path, limits: ArchiveLimits) -> Iterator[zipfile.ZipFile]:
    """Open an archive whose list of entries is within the limits.

    Raises:
        ImportFormatError: not an archive, over a limit, or damaged; also for errors while the block reads.
    """
    if not is_archive(path):
        raise ImportFormatError(f"{path.name}: is not a ZIP archive, or its end is missing. Pack or copy it again.")
    try:
        with _LimitedFile(path, limits) as file, zipfile.ZipFile(file) as archive:
            file.directory_was_read = True
            yield archive
    except _ZIP_ERRORS as e:
        raise ImportFormatError(f"{path.name}: the archive is damaged: {e}. Pack it again.") from None
    except OSError as e:
        if e.errno != errno.EINVAL:  # a damaged list can name a place before the file's beginning
            raise
        raise ImportFormatError(f"{path.name}: the archive is damaged: {e.strerror}. Pack it again.") from None


def entry_names(path: Path) -> list[str]:
    """The names in an archive as stored; nothing is unpacked, and names may be unsafe.

    Raises:
        ImportFormatError: not an archive, over a limit, or damaged.
    """
    with open_zip(path, ArchiveLimits()) as archive:
        return archive.namelist()


class _LimitedFile(io.BufferedReader):
    """A file whose list of entries is checked against the limits while zipfile reads it.

    The end of an archive states the length of the list in up to two places, and readers differ in which one they use.
    So the limits apply to the size that zipfile requests, and to the bytes that it gets.
    """

    def __init__(self, path: Path, limits: ArchiveLimits) -> None:
        super().__init__(io.FileIO(path))
        self._path = path
        self._limits = limits
        self.directory_was_read = False
        """Whether the list has been read; everything else is unpacked under limits of its own."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Read bytes as any file does.

        Raises:
            ImportFormatError: the bytes are the list, and it is too long.
        """
        if self.directory_was_read:
            return super().read(size)
        if size is not None and size > max(_END_BYTES, self._limits.directory):
            raise self._limit_error(f"a list of entries of {size} bytes")
        data = super().read(size)
        if data.startswith(_ENTRY_SIGNATURE):
            entries = data.count(_ENTRY_SIGNATURE)
            if entries > self._limits.entries or len(data) > self._limits.directory:
                raise self._limit_error(f"{entries} entries in a list of {len(data)} bytes")
        return data

    def _limit_error(self, content: str) -> ImportFormatError:
        limit = f"at most {self._limits.entries} in {self._limits.directory} bytes are read"
        return ImportFormatError(f"{self._path.name}: has {content}; {limit}. {self._limits.advice}", "too_large")
