"""Detects truncated row files by a last line without a line end.

A number that lost its last digits is still a number, so no other rule detects it.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from tsr_engine.exchange.import_validator import ImportValidator


def last_byte(path: Path) -> bytes:
    """The last byte of a file that is read row by row; empty: the file is empty."""
    with path.open("rb") as stream:
        size = stream.seek(0, 2)
        stream.seek(max(size - 1, 0))
        return stream.read(1)


def report_truncated(ends: Iterable[tuple[str, bytes]], validator: ImportValidator) -> None:
    """Report files whose last line has no line end, unless their tool never writes one.

    Args:
        ends: name of each row file, and its content or last byte.
        validator: of the import.
    """
    last_bytes = [(file, end[-1:]) for file, end in ends if end]
    truncated = [file for file, end in last_bytes if end not in (b"\n", b"\r")]
    if 1 < len(truncated) == len(last_bytes):
        return
    for file in truncated:
        validator.count("Files without a line end after the last line; if one was cut, its last row may be wrong", file)
