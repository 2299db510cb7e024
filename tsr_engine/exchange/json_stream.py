"""Reads JSON files piece by piece, with one element of a list in memory at a time."""

from __future__ import annotations

import codecs
import json
import re
from collections.abc import Collection, Iterator
from itertools import count
from pathlib import Path
from typing import Any, BinaryIO

from tsr_engine.exchange.reading import MAX_JSON_BYTES, refuse_large, rule_error
from tsr_engine.json_shapes import JsonObject

Member = tuple[str, int | None, Any]  # Any: a value of JSON
"""Key, place in its list, and value; see ``members``."""
LIST_START = 0
"""Place of the report that a list begins; the elements count from 1."""
CHUNK_BYTES = 4 << 20
_AFTER = frozenset(" \t\n\r,:]}")
_SPACE = re.compile(r"[ \t\n\r]*")


def members(path: Path, *, name: str | None = None, limit: int = MAX_JSON_BYTES) -> Iterator[Member]:
    """Yield the members of the object in a file, or the elements of its list.

    A value that is not a list gives ``(key, None, value)``. A list gives ``(key, 0, None)``, then ``(key, n, element)``
    for each element. A file without an object counts as an object with the empty key. NaN, which pandas
    writes for missing values, becomes null.

    Args:
        path: UTF-8, with or without byte order mark.
        name: the file's name for messages; unset: that of ``path``.
        limit: largest file in bytes.

    Raises:
        ImportFormatError: not JSON, another encoding, an infinity, a repeated key, too large or nested too deeply;
            names the line.
    """
    file = path.name if name is None else name
    refuse_large(path, name=file, limit=limit)
    with path.open("rb") as stream:
        text = _Text(stream, file)
        first = text.peek()
        if first == "{":
            yield from _object(text)
        else:
            yield from _value(text, "")
        if text.peek():
            raise text.syntax_error("there is content after its end")


def read_members(path: Path, wanted: Collection[str], *, name: str | None = None) -> JsonObject:
    """Return the wanted members of the object in a file, with whole lists; stops reading once all are found.

    Args:
        path: as for ``members``.
        wanted: their keys.
        name: as for ``members``.

    Raises:
        ImportFormatError: as ``members``.
    """
    found: JsonObject = {}
    for key, position, value in members(path, name=name):
        if key in wanted:
            if not position:
                found[key] = value if position is None else []
            else:
                found[key].append(value)
        elif len(found) == len(wanted):
            break
    return found


def _object(text: _Text) -> Iterator[Member]:
    seen: set[str] = set()
    for _ in text.items("{", "}"):
        if text.peek() != '"':
            raise text.syntax_error("a key in double quotes is missing")
        key = text.parse_value()
        if key in seen:
            raise rule_error(text.file, text.line, f"has the key {key[:60]!r} twice. Export it again.")
        seen.add(key)
        text.expect(":")
        yield from _value(text, key)


def _value(text: _Text, key: str) -> Iterator[Member]:
    if text.peek() != "[":
        yield key, None, text.parse_value()
        return
    yield key, LIST_START, None
    for position in text.items("[", "]"):
        yield key, position, text.parse_value()


class _Text:
    """The part of the file that is in memory."""

    def __init__(self, stream: BinaryIO, file: str) -> None:
        self.file = file
        self._stream = stream
        self._decoder = codecs.getincrementaldecoder("utf-8-sig")()
        self._buffer = ""
        self._position = 0
        self._buffer_line = 1
        """Line of the buffer's first character."""
        self._newlines = 0
        self._end = False
        self._json = json.JSONDecoder(parse_constant=self._constant)

    @property
    def line(self) -> int:
        """Line of the next character."""
        return self._buffer_line + self._buffer.count("\n", 0, self._position)

    def peek(self) -> str:
        """The next character other than white space; empty: end of file."""
        while True:
            found = _SPACE.match(self._buffer, self._position)
            assert found is not None
            self._position = found.end()
            if self._position < len(self._buffer):
                return self._buffer[self._position]
            if self._end:
                return ""
            self._fill()

    def expect(self, character: str) -> None:
        """Pass a character that must be next."""
        if self.peek() != character:
            raise self.syntax_error(f"{character!r} is missing")
        self._position += 1

    def items(self, opening: str, closing: str) -> Iterator[int]:
        """Pass the brackets and commas of a list; yield the place of each item, from 1, before it is parsed."""
        self.expect(opening)
        if self.peek() != closing:
            for position in count(1):
                yield position
                if self.peek() == closing:
                    break
                self.expect(",")
        self.expect(closing)

    def parse_value(self) -> Any:  # Any: a value of JSON
        """Parse the next whole value."""
        self.peek()
        while True:
            try:
                value, end = self._json.raw_decode(self._buffer, self._position)
            except json.JSONDecodeError as error:
                if self._end:
                    line = self._buffer_line + self._buffer.count("\n", 0, error.pos)
                    raise rule_error(self.file, line, f"is not JSON: {error.msg}. Export it again.") from None
            except RecursionError:
                raise rule_error(self.file, self.line, "is nested too deeply. Export it again.") from None
            except ValueError as error:
                raise rule_error(self.file, self.line, f"is not JSON: {error}. Export it again.") from None
            else:
                # A number at the end of the buffer may go on in the file.
                if self._buffer[end : end + 1] in _AFTER or self._end:
                    self._position = end
                    return value
            self._fill()

    def syntax_error(self, reason: str) -> Exception:
        """The error for invalid JSON."""
        return rule_error(self.file, self.line, f"is not JSON: {reason}. Export it again.")

    def _fill(self) -> None:
        """Read on and drop what has been passed; the steps grow while a value does not fit."""
        self._buffer_line = self.line
        remaining = self._buffer[self._position :]
        content = self._stream.read(max(CHUNK_BYTES, len(remaining)))
        if not self._newlines and content.startswith((b"\xff\xfe", b"\xfe\xff")) and not remaining:
            raise rule_error(self.file, 1, "is UTF-16; must be UTF-8. Save it again as UTF-8.")
        self._end = not content
        try:
            decoded = self._decoder.decode(content, final=self._end)
        except UnicodeDecodeError as error:
            line = 1 + self._newlines + error.object.count(b"\n", 0, error.start)
            bad = error.object[error.start]
            raise rule_error(self.file, line, f"byte 0x{bad:02x} is not UTF-8. Save the file again as UTF-8.") from None
        self._newlines += content.count(b"\n")
        self._buffer, self._position = remaining + decoded, 0

    def _constant(self, name: str) -> None:
        if name == "NaN":
            return
        found = max(self._buffer.find(name, self._position), self._position)
        line = self._buffer_line + self._buffer.count("\n", 0, found)
        raise rule_error(self.file, line, f"{name} is not a JSON number. Write finite numbers.")
