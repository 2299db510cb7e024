"""Writes the files of an export into a folder or directly into a ZIP archive, and counts and hashes them.

A format can have one file for each of 100,000 pictures. Such a file goes into an archive without a copy on the disk:
creating, reading, packing and removing copies took longer than the rest of an export.
"""

from __future__ import annotations

import hashlib
import io
import json
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, BinaryIO, TextIO

from tsr_engine.exchange.zip_writer import ZipWriter
from tsr_engine.json_shapes import JsonObject

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


_BUFFER_BYTES = 1 << 17


def compact_json(value: object) -> str:
    """A value as JSON on one line without spaces."""
    return json.dumps(value, allow_nan=False, separators=(",", ":"))


class OutputSink(ABC):
    """Takes the files of one export, each once; names are relative, with slashes."""

    def __init__(self) -> None:
        self._files: dict[str, tuple[int, str]] = {}

    @property
    def files(self) -> list[JsonObject]:
        """``{"name", "size", "sha256"}`` of every file that is complete, sorted by name."""
        return [{"name": n, "size": s, "sha256": d} for n, (s, d) in sorted(self._files.items())]

    def put(self, name: str, content: bytes) -> None:
        """Write a whole file.

        Raises:
            OSError: no space, or no permission.
            ValueError: the name is taken.
        """
        self._register(name, len(content), hashlib.sha256(content).hexdigest())
        self._put(name, content)

    @contextmanager
    def text(self, name: str, *, encoding: str = "utf-8", errors: str = "strict") -> Iterator[TextIO]:
        """Open a text file for writing; several can be open at a time. Line ends are not converted.

        Raises:
            OSError: no space, or no permission.
            ValueError: the name is taken.
        """
        with self._stream(name) as raw:
            hashed = _HashingWriter(raw)
            stream = io.TextIOWrapper(
                io.BufferedWriter(hashed, buffer_size=_BUFFER_BYTES), encoding=encoding, errors=errors, newline=""
            )
            try:
                yield stream
                stream.flush()
            except BaseException:
                hashed.is_discarding = True
                raise
            finally:
                # The caller who opened the raw file closes it.
                stream.detach().detach()
            self._register(name, hashed.size, hashed.digest.hexdigest())

    def _register(self, name: str, size: int, digest: str) -> None:
        if name in self._files:
            raise ValueError(f"{name} is written twice.")
        self._files[name] = (size, digest)

    @abstractmethod
    def _put(self, name: str, content: bytes) -> None: ...

    @abstractmethod
    def _stream(self, name: str) -> AbstractContextManager[IO[bytes]]: ...


class FolderSink(OutputSink):
    """Writes into a folder."""

    def __init__(self, folder: Path) -> None:
        """Take an existing folder."""
        super().__init__()
        self._folder = folder
        self._made = {""}

    def _put(self, name: str, content: bytes) -> None:
        # Plain names: for 100,000 files, Path objects take longer than the work. Buffered: on a full disk a raw write
        # takes a part of the data and raises nothing.
        with open(self._path(name), "wb") as stream:  # noqa: PTH123
            stream.write(content)

    @contextmanager
    def _stream(self, name: str) -> Iterator[IO[bytes]]:
        with open(self._path(name), "wb") as stream:  # noqa: PTH123
            yield stream

    def _path(self, name: str) -> str:
        parent = name.rpartition("/")[0]
        if parent not in self._made:
            (self._folder / parent).mkdir(parents=True, exist_ok=True)
            self._made.add(parent)
        return f"{self._folder}/{name}"


class ZipSink(OutputSink):
    """Writes into a ZIP archive; equal files in equal order give equal bytes.

    An archive takes one entry after the other, so a growing file is kept in an unnamed one beside the archive until it
    is complete.
    """

    def __init__(self, target: BinaryIO, scratch: Path, progress: Callable[[], None] = lambda: None) -> None:
        """Take an open file.

        Args:
            target: the archive.
            scratch: folder for growing files.
            progress: called after each packed megabyte; may raise to stop.
        """
        super().__init__()
        self._archive = ZipWriter(target, progress)
        self._scratch = scratch

    def __enter__(self) -> ZipSink:
        return self

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        """Write the list of entries; after an exception the archive is unusable."""
        self._archive.__exit__(kind, *rest)

    def _put(self, name: str, content: bytes) -> None:
        self._archive.put(name, content)

    @contextmanager
    def _stream(self, name: str) -> Iterator[IO[bytes]]:
        with tempfile.TemporaryFile(dir=self._scratch) as stream:
            yield stream
            size = stream.tell()
            stream.seek(0)
            self._archive.put_stream(name, stream, size)


class _HashingWriter(io.RawIOBase):
    """Passes bytes on, and hashes and counts them; once it is ``is_discarding`` it drops them."""

    def __init__(self, raw: IO[bytes]) -> None:
        self._raw = raw
        self.is_discarding = False
        self.digest = hashlib.sha256()
        self.size = 0

    def writable(self) -> bool:
        return True

    def write(self, data: ReadableBuffer) -> int:
        size = memoryview(data).nbytes
        if not self.is_discarding:
            self._raw.write(data)
            self.digest.update(data)
            self.size += size
        return size
