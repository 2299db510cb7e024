"""Opens ZIP archives that are not trusted: the list of entries is measured before it is parsed."""

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

__all__ = ["ArchiveLimits", "entry_names", "is_archive", "opened"]

_ENTRY = b"PK\x01\x02"
"""Begins each entry of the list."""
_END = 1 << 17
"""Bytes at most that the search for the end of an archive reads at once."""
_DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    struct.error,
    ValueError,
    OverflowError,
)
"""What zipfile raises for an archive that breaks the format or needs what it cannot do; bad names are ValueErrors."""


@dataclass(frozen=True, slots=True)
class ArchiveLimits:
    """The limits of an unpacked archive.

    Attributes:
        entries: most files and folders.
        total: most bytes of all files together.
        single: most bytes of one file.
        ratio: most bytes that a packed byte may unfold to; text of annotations stays below 60.
        directory: most bytes of the list of entries, however long the archive says that it is.
        advice: what to do about one with more entries.
    """

    entries: int = 400_000
    total: int = 32 << 30
    single: int = 8 << 30
    ratio: int = 250
    directory: int = 64 << 20
    advice: str = "Split it."


def is_archive(path: Path) -> bool:
    """Whether a file ends as a ZIP archive does, however damaged it is before that."""
    try:
        return zipfile.is_zipfile(path)
    except zipfile.BadZipFile:
        return True  # an end of several disks: what opens it says what is wrong


@contextmanager
def opened(path: Path, limits: ArchiveLimits) -> Iterator[zipfile.ZipFile]:
    """An archive whose list of entries is within the limits.

    Raises:
        ImportFormatError: no archive, over a limit, or damaged; also for what shows while the block reads from it.
    """
    if not is_archive(path):
        raise ImportFormatError(f"{path.name}: is no ZIP archive, or its end is missing. Pack or copy it again.")
    try:
        with _Watched(path, limits) as file, zipfile.ZipFile(file) as archive:
            file.listed = True
            yield archive
    except _DAMAGED as e:
        raise ImportFormatError(f"{path.name}: the archive is damaged: {e}. Pack it again.") from None
    except OSError as e:
        if e.errno != errno.EINVAL:  # that is a place before the file's beginning, which a damaged list can name
            raise
        raise ImportFormatError(f"{path.name}: the archive is damaged: {e.strerror}. Pack it again.") from None


def entry_names(path: Path, limits: ArchiveLimits | None = None) -> list[str]:
    """The names in an archive, as they stand there: nothing is unpacked, no name is safe.

    Args:
        path: the archive.
        limits: how long the list may be; unset: ``ArchiveLimits()``.

    Raises:
        ImportFormatError: no archive, over a limit, or damaged.
    """
    with opened(path, ArchiveLimits() if limits is None else limits) as archive:
        return archive.namelist()


class _Watched(io.BufferedReader):
    """A file whose list of entries is held to the limits while zipfile reads it.

    The end of an archive states the length of the list in up to two places, and readers differ in which one they use.
    So the limits apply to the bytes that zipfile asks for, before they are read, and to those that it gets.
    """

    def __init__(self, path: Path, limits: ArchiveLimits) -> None:
        super().__init__(io.FileIO(path))
        self._path = path
        self._limits = limits
        self.listed = False
        """The list has been read; all else is unpacked, which has limits of its own."""

    def read(self, size: int | None = -1, /) -> bytes:
        """As of every file.

        Raises:
            ImportFormatError: this would be the list, and it is too long.
        """
        if self.listed:
            return super().read(size)
        if size is not None and size > max(_END, self._limits.directory):
            raise self._refused(f"a list of entries of {size} bytes")
        data = super().read(size)
        if data.startswith(_ENTRY):
            entries = data.count(_ENTRY)
            if entries > self._limits.entries or len(data) > self._limits.directory:
                raise self._refused(f"{entries} entries in a list of {len(data)} bytes")
        return data

    def _refused(self, has: str) -> ImportFormatError:
        most = f"at most {self._limits.entries} in {self._limits.directory} bytes are read"
        return ImportFormatError(f"{self._path.name}: has {has}; {most}. {self._limits.advice}", "too_large")
