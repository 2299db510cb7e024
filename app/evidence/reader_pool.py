"""Keeps stores open for later requests. Readers of an unfinished run see its last committed chunk."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.evidence.schema import DATABASE

_Identity = tuple[int, int]


class ReaderPool:
    """Readers by folder; each serves one request at a time.

    Args:
        max_folders: number of folders that keep idle readers; the least recently used are closed first.
        max_readers: idle readers per folder.
    """

    def __init__(self, max_folders: int = 6, max_readers: int = 3) -> None:
        self._max_folders, self._max_readers = max_folders, max_readers
        self._lock = threading.Lock()
        self._idle_readers: OrderedDict[Path, list[tuple[_Identity, EvidenceReader]]] = OrderedDict()

    @contextmanager
    def reading(self, folder: Path) -> Iterator[EvidenceReader]:
        """Yield a reader of one run.

        Raises:
            EvidenceError: there is no run, or a damaged one.
        """
        identity = _identity(folder)
        reader = self._pop(folder, identity) or EvidenceReader(folder)
        try:
            yield reader
        except BaseException:
            reader.close()
            raise
        self._put_back(folder, identity, reader)

    def forget(self, folder: Path) -> None:
        """Close the idle readers of a folder that is removed."""
        with self._lock:
            readers = self._idle_readers.pop(folder, [])
        for _, reader in readers:
            reader.close()

    def close(self) -> None:
        """Close all idle readers."""
        with self._lock:
            folders = list(self._idle_readers)
        for folder in folders:
            self.forget(folder)

    def _pop(self, folder: Path, identity: _Identity) -> EvidenceReader | None:
        stale: list[EvidenceReader] = []
        match = None
        with self._lock:
            readers = self._idle_readers.get(folder, [])
            while readers and match is None:
                known, reader = readers.pop()
                # A repeated what-if replaces the file; a reader of the old file would show old results.
                if known == identity:
                    match = reader
                else:
                    stale.append(reader)
        for reader in stale:
            reader.close()
        return match

    def _put_back(self, folder: Path, identity: _Identity, reader: EvidenceReader) -> None:
        surplus: list[EvidenceReader] = []
        with self._lock:
            readers = self._idle_readers.setdefault(folder, [])
            self._idle_readers.move_to_end(folder)
            if len(readers) < self._max_readers:
                readers.append((identity, reader))
            else:
                surplus.append(reader)
            while len(self._idle_readers) > self._max_folders:
                _, old = self._idle_readers.popitem(last=False)
                surplus += [reader for _, reader in old]
        for each in surplus:
            each.close()


def _identity(folder: Path) -> _Identity:
    try:
        status = (folder / DATABASE).stat()
    except OSError:
        return (0, 0)
    return status.st_dev, status.st_ino
