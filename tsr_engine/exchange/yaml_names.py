"""The one thing that a ``data.yaml`` of YOLO says that is needed here: the class names. Written and read without YAML.

Understood are a block map (``0: stop``), a block list (``- stop``), and both in one line (``{0: stop}``, ``[stop]``),
with plain, single-quoted and double-quoted names.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

from tsr_engine.exchange.checks import refuse

__all__ = ["names_of", "quoted_name"]

_UNPRINTABLE = re.compile("[\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff]")
_SURROGATE = re.compile("[\ud800-\udfff]")
_TOKEN = re.compile(
    r"""\s*(?:(?P<double>"(?:[^"\\]|\\.)*")|(?P<single>'(?:[^']|'')*')|(?P<mark>[\[\]{},])|(?P<plain>[^\[\]{},'"\n][^\[\]{},\n]*))"""
)
_ENTRY = re.compile(
    r"(?P<indent>\s*)(?:(?P<dash>-)\s+|(?P<key>\"\d{1,6}\"|'\d{1,6}'|\d{1,6})\s*:(?:\s+|$))(?P<value>.*)"
)
_ESCAPES = {"0": "\0", "a": "\a", "b": "\b", "t": "\t", "n": "\n", "v": "\v", "f": "\f", "r": "\r", "e": "\x1b"}
_ESCAPE = re.compile(r"\\(?:x([0-9A-Fa-f]{2})|u([0-9A-Fa-f]{4})|U([0-9A-Fa-f]{8})|(.))", re.DOTALL)


def quoted_name(name: str) -> str:
    """A name as a double-quoted scalar of YAML."""
    text = json.dumps(_SURROGATE.sub("\ufffd", name), ensure_ascii=False)
    return _UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def names_of(text: str, file: str) -> dict[int, str] | None:
    """Class names by number; None: there is no ``names``.

    Raises:
        ImportFormatError: it is written in a way that is not understood; says the line.
    """
    lines = text.splitlines()
    for at, line in enumerate(lines):
        if re.match(r"names\s*:", line):
            rest = _uncommented(line.split(":", 1)[1]).strip()
            return _in_line(lines, at, rest, file) if rest else _block(lines, at + 1, file)
    return None


def _block(lines: list[str], at: int, file: str) -> dict[int, str]:
    out: dict[int, str] = {}
    for number, line in enumerate(lines[at:], start=at + 1):
        text = _uncommented(line)
        if not text.strip():
            continue
        entry = _ENTRY.fullmatch(text)
        if entry is None or (not entry["indent"] and not entry["dash"]):
            if not text[0].isspace():
                break
            raise refuse(file, number, f"a name must be written '0: stop' or '- stop'. Got {text.strip()[:60]!r}.")
        place = len(out) if entry["dash"] else int(entry["key"].strip("\"'"))
        if place in out:
            raise refuse(file, number, f"class {place} is there twice. Give each class its own number.")
        out[place] = _scalar(entry["value"].strip(), file, number)
    return out


def _in_line(lines: list[str], at: int, rest: str, file: str) -> dict[int, str]:
    """A list or map between brackets; it may run over several lines."""
    text = rest
    end = at
    while not _closed(text) and end + 1 < len(lines):
        end += 1
        text += " " + _uncommented(lines[end]).strip()
    parts = list(_tokens(text, file, at + 1))
    if len(parts) < 2 or (parts[0], parts[-1]) not in (("[", "]"), ("{", "}")):
        raise refuse(file, at + 1, "names must be a list or a map. Write 'names: [stop, yield]'.")
    out: dict[int, str] = {}
    for part in parts[1:-1]:
        if part in ("[", "]", "{", "}"):
            raise refuse(file, at + 1, "names must be a plain list or map, without another inside.")
        if part == ",":
            continue
        if parts[0] == "[":
            out[len(out)] = _scalar(part, file, at + 1)
            continue
        entry = re.fullmatch(r"[\"']?(\d{1,6})[\"']?\s*:\s*(.*)", part)
        if entry is None or int(entry[1]) in out:
            raise refuse(file, at + 1, f"a name must be written '0: stop', each number once. Got {part[:60]!r}.")
        out[int(entry[1])] = _scalar(entry[2].strip(), file, at + 1)
    return out


def _tokens(text: str, file: str, line: int) -> Iterator[str]:
    """Brackets, commas, and what lies between; ``0: "stop"`` is one token."""
    at = 0
    held = ""
    while at < len(text.rstrip()):
        found = _TOKEN.match(text, at)
        if found is None:
            raise refuse(file, line, f"names cannot be understood at {text[at : at + 40]!r}. Quote the names.")
        at = found.end()
        if found["mark"]:
            if held:
                yield held.strip()
            held = ""
            yield found["mark"]
        else:
            held += found[0]
    if held:
        yield held.strip()


def _closed(text: str) -> bool:
    bare = re.sub(r"\"(?:[^\"\\]|\\.)*\"|'(?:[^']|'')*'", "", text)
    return bare.count("[") + bare.count("{") <= bare.count("]") + bare.count("}")


def _uncommented(line: str) -> str:
    """The line without its comment; a ``#`` within quotes is none."""
    quote = ""
    skip = False
    for at, letter in enumerate(line):
        if skip:
            skip = False
        elif quote:
            skip = letter == "\\" and quote == '"'
            quote = "" if letter == quote else quote
        elif letter in "\"'" and (at == 0 or line[at - 1] in " \t[{,:-"):
            quote = letter
        elif letter == "#" and (at == 0 or line[at - 1].isspace()):
            return line[:at]
    return line


def _scalar(text: str, file: str, line: int) -> str:
    if text.startswith('"'):
        if len(text) < 2 or not text.endswith('"'):
            raise refuse(file, line, f"the quotes of {text[:60]!r} are not closed. Close them.")
        return _ESCAPE.sub(_unescape, text[1:-1])
    if text.startswith("'"):
        if len(text) < 2 or not text.endswith("'"):
            raise refuse(file, line, f"the quotes of {text[:60]!r} are not closed. Close them.")
        return text[1:-1].replace("''", "'")
    return text.strip()


def _unescape(found: re.Match[str]) -> str:
    code = found[1] or found[2] or found[3]
    if code:
        return chr(min(int(code, 16), 0x10FFFF))
    return _ESCAPES.get(found[4], found[4])
