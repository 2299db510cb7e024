"""Detects files of rows that were cut, by a last line without a line end.

A number that has lost its last digits is still a number, so no other rule can find it.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from tsr_engine.exchange.checks import ImportValidator

__all__ = ["last_of", "tell_open_ends"]


def last_of(path: Path) -> bytes:
    """The last byte of a file, for files that are read row by row; empty: it has none."""
    with path.open("rb") as stream:
        size = stream.seek(0, 2)
        stream.seek(max(size - 1, 0))
        return stream.read(1)


def tell_open_ends(ends: Iterable[tuple[str, bytes]], validator: ImportValidator) -> None:
    """Report files whose last line has no line end, unless the tool that wrote them never ends it.

    Args:
        ends: name of each file of rows, and its content or the last byte of it.
        validator: of the import.
    """
    known = [(file, end[-1:]) for file, end in ends if end]
    open_ones = [file for file, end in known if end not in (b"\n", b"\r")]
    if 1 < len(open_ones) == len(known):
        return
    for file in open_ones:
        validator.count("Files whose last line does not end; if one was cut, its last row may be wrong", file)
