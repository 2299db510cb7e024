"""Keeps the small files of an unpacked archive in one file on the disk.

A data set can have a text file for each of 100,000 pictures. Making, opening and removing so many files takes longer
than reading them. So files whose names differ only in a number are kept in one file until they are asked for. If there
are few, each one is a file on the disk.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Final

from tsr_engine.exchange.file_listing import is_system_file, list_files

_NUMBERED: Final = re.compile(r"[0-9]\.(?:xml|txt)", re.IGNORECASE | re.ASCII)
_MAX_ENTRY_BYTES: Final = 1 << 16
"""Largest entry that may be stored here, in bytes as the archive states."""
_ALWAYS_ON_DISK: Final = 50
"""Number of files per folder that are always on the disk: a format is recognised by them."""


class SmallFileStore:
    """Stores files by their names below a folder; a context manager that removes them."""

    def __init__(self, folder: Path, path: Path) -> None:
        """Create the store.

        Args:
            folder: the folder that seems to hold the files.
            path: path of the store's file; must not exist.

        Raises:
            OSError: the file cannot be created.
        """
        self._root = f"{folder}/"
        self._stream = path.open("xb+")
        self._spans: dict[str, tuple[int, int]] = {}
        self._counts: dict[str, int] = {}
        self._end = 0

    def __enter__(self) -> SmallFileStore:
        return self

    def __exit__(self, *_: object) -> None:
        self._stream.close()

    def accepts(self, name: str, size: int) -> bool:
        """Whether a file of an archive may be stored; call it once per file, in order.

        Args:
            name: relative to the folder, with slashes.
            size: bytes as the archive states.
        """
        parent, _, last = name.rpartition("/")
        self._counts[parent] = count = self._counts.get(parent, 0) + 1
        return (
            count > _ALWAYS_ON_DISK
            and size <= _MAX_ENTRY_BYTES
            and _NUMBERED.search(last, max(0, len(last) - 5)) is not None
        )

    def put(self, name: str, content: bytes) -> None:
        """Store a file.

        Raises:
            OSError: no space.
        """
        self._stream.write(content)
        self._spans[name] = (self._end, len(content))
        self._end += len(content)

    def flush_content(self) -> None:
        """Flush all stored content to the file.

        Raises:
            OSError: no space.
        """
        self._stream.flush()

    def list_files(self, folder: Path) -> list[str]:
        """Names of the stored files below a folder, relative to it."""
        start = f"{folder}/"
        if not start.startswith(self._root):
            return []
        start = start[len(self._root) :]
        return [name[len(start) :] for name in self._spans if name.startswith(start)]

    def content(self, path: str) -> bytes | None:
        """The content of a file; None: it is not stored here."""
        found = self._spans.get(path.removeprefix(self._root))
        return None if found is None else os.pread(self._stream.fileno(), found[1], found[0])

    def on_disk(self, path: str) -> Path:
        """The file on the disk; it is written first if it is stored here."""
        content = self.content(path)
        if content is not None and not Path(path).exists():
            Path(path).parent.mkdir(parents=True, exist_ok=True)
            Path(path).write_bytes(content)
        return Path(path)


def list_all_files(folder: Path, store: SmallFileStore | None) -> list[str]:
    """Names of all files below a folder, relative to it, with slashes, sorted."""
    on_disk = [name for name in list_files(folder) if not is_system_file(name)]
    return on_disk if store is None else sorted({*on_disk, *store.list_files(folder)})


def read_content(path: str, store: SmallFileStore | None, limit: int = -1) -> bytes:
    """The first ``limit`` bytes of a file, or all of them.

    Raises:
        OSError: the file cannot be read.
    """
    stored = None if store is None else store.content(path)
    if stored is not None:
        return stored if limit < 0 else stored[:limit]
    with open(path, "rb", buffering=0) as stream:  # noqa: PTH123 - creating a Path takes as long as reading the file
        return stream.read(limit)
