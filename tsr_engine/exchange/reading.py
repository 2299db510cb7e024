"""Reads text and JSON files of other tools, and words the error for a broken rule."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from tsr_engine.errors import ImportFormatError, ImportProblem

MAX_JSON_BYTES = 512 << 20
"""Largest text file that is read into memory, bytes."""


def rule_error(file: str, line: int | str | None, rule: str, kind: ImportProblem = "broken") -> ImportFormatError:
    """The error for a broken rule: ``FILE, line N: rule``; a text instead of a number describes the place."""
    return ImportFormatError(f"{location_of(file, line)}: {rule}", kind)


def too_many_error(what: str, limit: int, file: str, line: int | str | None = None) -> ImportFormatError:
    """The error for an import with too many items of a kind."""
    return rule_error(
        file, line, f"holds more than {limit} {what}, the most that one import takes. Split it.", "too_large"
    )


def _too_large_error(file: str, size: int, limit: int) -> ImportFormatError:
    return rule_error(file, None, f"has {size} bytes, more than the {limit} that are read. Split it.", "too_large")


def refuse_large(path: Path, *, name: str | None = None, limit: int = MAX_JSON_BYTES) -> None:
    """Refuse a file of more than ``limit`` bytes; ``name`` is its name for messages, unset: that of ``path``.

    Raises:
        ImportFormatError: it is larger.
    """
    size = path.stat().st_size
    if size > limit:
        raise _too_large_error(name or path.name, size, limit)


def location_of(file: str, line: int | str | None) -> str:
    """A place in a file in words: ``FILE, line N``."""
    return file if line is None else f"{file}, line {line}" if isinstance(line, int) else f"{file}, {line}"


def read_text(path: Path, *, limit: int = MAX_JSON_BYTES) -> str:
    """Read a UTF-8 text file, with or without byte order mark.

    Raises:
        ImportFormatError: more than ``limit`` bytes, or another encoding; names the line.
    """
    refuse_large(path, limit=limit)
    return decode_text(path.read_bytes(), path.name)


def read_names(path: Path) -> list[str]:
    """Read a list with one name a line, stripped, without empty lines at the end.

    Raises:
        ImportFormatError: as ``read_text``.
    """
    return [line.strip() for line in read_text(path, limit=1 << 24).rstrip().splitlines()]


def decode_text(content: bytes, file: str) -> str:
    """Decode the content of a file.

    Raises:
        ImportFormatError: as ``read_text``, with the limit ``MAX_JSON_BYTES``.
    """
    if len(content) > MAX_JSON_BYTES:
        raise _too_large_error(file, len(content), MAX_JSON_BYTES)
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise rule_error(file, 1, "is UTF-16; must be UTF-8. Save it again as UTF-8.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        bad = content[error.start]
        raise rule_error(file, line, f"byte 0x{bad:02x} is not UTF-8. Save the file again as UTF-8.") from None


@contextmanager
def open_text(path: Path, *, name: str | None = None) -> Iterator[TextIO]:
    """Open a UTF-8 text file as a stream that keeps its line ends; ``name`` is its name for messages.

    Raises:
        ImportFormatError: as ``read_text``, raised when the stream reaches the place.
    """
    refuse_large(path, name=name)
    with path.open(encoding="utf-8-sig", newline="") as stream:
        try:
            yield stream
        except UnicodeDecodeError:
            decode_text(path.read_bytes(), name or path.name)  # names the line
            raise


def read_json(path: Path, *, limit: int = MAX_JSON_BYTES) -> object:
    """Read a JSON file in UTF-8; NaN becomes null, infinities are refused.

    Raises:
        ImportFormatError: not JSON, too large or nested too deeply; names the line.
    """

    def constant(name: str) -> None:
        if name == "NaN":
            return
        raise rule_error(path.name, None, f"{name} is not a JSON number. Write finite numbers.")

    try:
        return json.loads(read_text(path, limit=limit), parse_constant=constant)
    except json.JSONDecodeError as error:
        raise rule_error(path.name, error.lineno, f"is not JSON: {error.msg}. Export it again.") from None
    except RecursionError:
        raise rule_error(path.name, None, "is nested too deeply. Export it again.") from None
    except ValueError as error:
        raise rule_error(path.name, None, f"is not JSON: {error}. Export it again.") from None
