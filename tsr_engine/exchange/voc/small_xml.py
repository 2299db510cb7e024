"""Reads XML files of a few kilobytes at once: a data set can have one for each of 100,000 pictures.

Python's C code builds the tree, without a function call for each element, in a quarter of the time. The tree has no
line numbers, so a reader that refuses something reads the file again with ``tsr_engine.exchange.xml.elements``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache
from typing import Final, Protocol
from xml.etree.ElementTree import Element, ParseError, TreeBuilder

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import XMLParser

from tsr_engine.exchange.xml import DEPTH

__all__ = ["SMALL", "SmallNode", "XmlNode", "small_elements"]

SMALL: Final = 1 << 16
"""Most bytes of a file that is read in one go."""


class XmlNode(Protocol):
    """The part of an element's interface that readers of small files use."""

    @property
    def tag(self) -> str:
        """Its name."""

    @property
    def line(self) -> int:
        """Where it begins, from 1; of an element inside a ``SmallNode`` that of the outer one."""

    @property
    def text(self) -> str:
        """Text directly inside, stripped."""

    def child(self, tag: str) -> XmlNode | None:
        """The first element of that name directly inside."""

    def value(self, tag: str) -> str:
        """Its text; empty where there is none."""

    def table(self, row: str, key: str, value: str) -> dict[str, str]:
        """The text of one element inside each row, by that of another; the value with its white space."""


class SmallNode:
    """An element of a small file."""

    __slots__ = ("_element", "line")

    def __init__(self, element: Element, line: int) -> None:
        self._element = element
        self.line = line

    @property
    def tag(self) -> str:
        """Its name."""
        return self._element.tag

    @property
    def text(self) -> str:
        """Text directly inside, stripped."""
        return _raw(self._element).strip()

    def child(self, tag: str) -> SmallNode | None:
        """The first element of that name directly inside."""
        found = self._element.find(tag)
        return None if found is None else SmallNode(found, self.line)

    def value(self, tag: str) -> str:
        """Its text, stripped; empty where there is none."""
        found = self._element.find(tag)
        return "" if found is None else _raw(found).strip()

    def table(self, row: str, key: str, value: str) -> dict[str, str]:
        """The text of one element inside each row, by that of another; the value with its white space."""
        out: dict[str, str] = {}
        for entry in self._element:
            if entry.tag == row:
                name, reported = entry.find(key), entry.find(value)
                if name is not None and reported is not None:
                    out[_raw(name).strip()] = _raw(reported)
        return out


def small_elements(content: bytes, root: str, wanted: Iterable[str]) -> list[SmallNode] | None:
    """The wanted elements directly inside the outermost one, with their lines.

    Args:
        content: the file, or its first ``SMALL + 1`` bytes.
        root: what the outermost element must be called.
        wanted: names of elements.

    Returns:
        None: the file is large, broken, or made in a way in which lines cannot be counted like this; ``elements``
        reads it, or says what is wrong.
    """
    if len(content) > SMALL or content.count(b"\r") != content.count(b"\r\n"):
        return None
    tree = _tree(content)
    if tree is None or tree.tag != root or _is_deep(tree):
        return None
    names = frozenset(wanted)
    found = [element for element in tree if element.tag in names]
    begins = [match.start() for match in _starts(names).finditer(content)]
    if len(begins) != len(found):
        return None
    out, line, before = [], 1, 0
    for element, begin in zip(found, begins, strict=True):
        line, before = line + content.count(b"\n", before, begin), begin
        out.append(SmallNode(element, line))
    return out


def _tree(content: bytes) -> Element | None:
    builder = TreeBuilder()
    parser = XMLParser(target=builder, forbid_dtd=True, forbid_entities=True, forbid_external=True)
    expat = parser.parser
    expat.ordered_attributes, expat.buffer_text = False, True
    expat.StartElementHandler, expat.EndElementHandler = builder.start, builder.end
    expat.CharacterDataHandler = builder.data
    try:
        parser.feed(content)
        return parser.close()  # type: ignore[no-any-return]
    except (DefusedXmlException, ParseError, LookupError, ValueError):
        return None


def _is_deep(tree: Element) -> bool:
    level, depth = [tree], 0
    while level:
        depth += 1
        if depth > DEPTH:
            return True
        level = [inner for element in level for inner in element]
    return False


@lru_cache(maxsize=8)
def _starts(names: frozenset[str]) -> re.Pattern[bytes]:
    either = "|".join(map(re.escape, sorted(names)))
    return re.compile(f"<(?:{either})(?=[\\s/>])".encode())


def _raw(element: Element) -> str:
    text = element.text or ""
    return text + "".join(inner.tail or "" for inner in element) if len(element) else text
