"""Converts people's notes about a track to text, one line a note: ``12: looks like a lamp``."""

from __future__ import annotations

import re
from collections.abc import Sequence

_SPECIAL = re.compile("[\\\\\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]|^ | $")
_ESCAPED = re.compile(r"\\(?:\\|u([0-9a-f]{4}))")
_LINE = re.compile(r"(\d{1,9}): (.*)", re.DOTALL)


def notes_to_text(notes: Sequence[tuple[int, str]]) -> str:
    """Notes as lines ``frame: text``; line breaks and control characters inside a note are escaped."""
    return "\n".join(f"{frame}: {_SPECIAL.sub(_escape, note)}" for frame, note in notes)


def notes_from_text(value: str, frame: int) -> tuple[tuple[int, str], ...]:
    """Invert ``notes_to_text``; a line of another tool has no number and is put at ``frame``."""
    out: list[tuple[int, str]] = []
    for line in value.split("\n"):
        numbered = _LINE.fullmatch(line)
        if numbered:
            out.append((int(numbered[1]), _ESCAPED.sub(_unescape, numbered[2])))
        elif line.strip():
            out.append((frame, line.strip()))
    return tuple(out)


def _escape(found: re.Match[str]) -> str:
    return "\\\\" if found[0] == "\\" else f"\\u{ord(found[0]):04x}"


def _unescape(found: re.Match[str]) -> str:
    return chr(int(found[1], 16)) if found[1] else "\\"
