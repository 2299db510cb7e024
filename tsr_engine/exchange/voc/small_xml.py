"""Reads XML files of a few kilobytes quickly: a data set can have one for each of 100,000 pictures.

Python's C code builds the tree without a function call per element, in a quarter of the time. The tree has no
line numbers, so a reader that refuses something reads the file again with ``tsr_engine.exchange.xml.elements``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache
from typing import Final, TypeAlias
from xml.etree.ElementTree import Element, ParseError, TreeBuilder

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import XMLParser

from tsr_engine.exchange.xml import MAX_DEPTH, Node

MAX_SMALL_BYTES: Final = 1 << 16
"""Largest file that is read at once, bytes."""


class SmallNode:
    """An element of a small file."""

    __slots__ = ("_element", "line")

    def __init__(self, element: Element, line: int) -> None:
        self._element = element
        self.line = line

    @property
    def tag(self) -> str:
        """Name of the element."""
        return self._element.tag

    @property
    def text(self) -> str:
        """Stripped text directly inside."""
        return _raw(self._element).strip()

    def child(self, tag: str) -> SmallNode | None:
        """The first child element with that name."""
        found = self._element.find(tag)
        return None if found is None else SmallNode(found, self.line)

    def value(self, tag: str) -> str:
        """The child's stripped text; empty if there is no child."""
        found = self._element.find(tag)
        return "" if found is None else _raw(found).strip()

    def table(self, row: str, key: str, value: str) -> dict[str, str]:
        """Map the text of one element inside each row to that of another; the value keeps its white space."""
        out: dict[str, str] = {}
        for entry in self._element:
            if entry.tag == row:
                name, text = entry.find(key), entry.find(value)
                if name is not None and text is not None:
                    out[_raw(name).strip()] = _raw(text)
        return out


XmlNode: TypeAlias = Node | SmallNode
"""The element of a file; that of a small file has the line of its outer element."""


def small_elements(content: bytes, root: str, wanted: Iterable[str]) -> list[SmallNode] | None:
    """The wanted children of the outermost element, with their lines.

    Args:
        content: the file, or its first ``MAX_SMALL_BYTES + 1`` bytes.
        root: required name of the outermost element.
        wanted: names of children.

    Returns:
        None: the file is large or broken, or its lines cannot be counted this way; ``elements``
        reads it or reports the error.
    """
    if len(content) > MAX_SMALL_BYTES or content.count(b"\r") != content.count(b"\r\n"):
        return None
    tree = _tree(content)
    if tree is None or tree.tag != root or _is_deep(tree):
        return None
    names = frozenset(wanted)
    found = [element for element in tree if element.tag in names]
    starts = [match.start() for match in _start_tags(names).finditer(content)]
    if len(starts) != len(found):
        return None
    out, line, previous = [], 1, 0
    for element, start in zip(found, starts, strict=True):
        line, previous = line + content.count(b"\n", previous, start), start
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
        if depth > MAX_DEPTH:
            return True
        level = [inner for element in level for inner in element]
    return False


@lru_cache(maxsize=8)
def _start_tags(names: frozenset[str]) -> re.Pattern[bytes]:
    either = "|".join(map(re.escape, sorted(names)))
    return re.compile(f"<(?:{either})(?=[\\s/>])".encode())


def _raw(element: Element) -> str:
    text = element.text or ""
    return text + "".join(inner.tail or "" for inner in element) if len(element) else text
