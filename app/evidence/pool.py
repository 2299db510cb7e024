"""Keeps stores open for later requests. Readers of an unfinished run see its last committed chunk."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.evidence.schema import DATABASE

__all__ = ["ReaderPool"]

_Identity = tuple[int, int]


class ReaderPool:
    """Readers by folder; each serves one request at a time.

    Args:
        runs: number of folders that keep idle readers; the least recently used are closed first.
        idle: idle readers per folder.
    """

    def __init__(self, runs: int = 6, idle: int = 3) -> None:
        self._runs, self._idle = runs, idle
        self._lock = threading.Lock()
        self._kept: OrderedDict[Path, list[tuple[_Identity, EvidenceReader]]] = OrderedDict()

    @contextmanager
    def reading(self, folder: Path) -> Iterator[EvidenceReader]:
        """Yield a reader of one run.

        Raises:
            EvidenceError: there is no run, or a damaged one.
        """
        identity = _identity(folder)
        reader = self._take(folder, identity) or EvidenceReader(folder)
        try:
            yield reader
        except BaseException:
            reader.close()
            raise
        self._give(folder, identity, reader)

    def forget(self, folder: Path) -> None:
        """Close the idle readers of a folder that is removed."""
        with self._lock:
            kept = self._kept.pop(folder, [])
        for _, reader in kept:
            reader.close()

    def close(self) -> None:
        """Close all idle readers."""
        with self._lock:
            folders = list(self._kept)
        for folder in folders:
            self.forget(folder)

    def _take(self, folder: Path, identity: _Identity) -> EvidenceReader | None:
        stale: list[EvidenceReader] = []
        found = None
        with self._lock:
            kept = self._kept.get(folder, [])
            while kept and found is None:
                known, reader = kept.pop()
                # A repeated what-if replaces the file; a reader of the old file would show old results.
                if known == identity:
                    found = reader
                else:
                    stale.append(reader)
        for reader in stale:
            reader.close()
        return found

    def _give(self, folder: Path, identity: _Identity, reader: EvidenceReader) -> None:
        surplus: list[EvidenceReader] = []
        with self._lock:
            kept = self._kept.setdefault(folder, [])
            self._kept.move_to_end(folder)
            if len(kept) < self._idle:
                kept.append((identity, reader))
            else:
                surplus.append(reader)
            while len(self._kept) > self._runs:
                _, old = self._kept.popitem(last=False)
                surplus += [reader for _, reader in old]
        for each in surplus:
            each.close()


def _identity(folder: Path) -> _Identity:
    try:
        found = (folder / DATABASE).stat()
    except OSError:
        return (0, 0)
    return found.st_dev, found.st_ino
