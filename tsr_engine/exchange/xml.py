"""Reads and writes XML as a stream, with line numbers; refuses document types, entities and external references."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from xml.etree.ElementTree import ParseError
from xml.parsers.expat import XMLParserType
from xml.sax.saxutils import escape, quoteattr

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import XMLParser

from tsr_engine.exchange.reading import rule_error
from tsr_engine.io.plain_numbers import parse_real

_CHUNK = 1 << 16
MAX_DEPTH = 32
"""Largest depth of nested elements."""
_INVALID = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class Node:
    """An element with its place in the file.

    Attributes:
        tag: name.
        attrib: attributes.
        children: elements directly inside.
        line: where it begins, from 1.
        parts: pieces of the text directly inside; joined only on request, because a hostile file has many.
    """

    __slots__ = ("attrib", "children", "line", "parts", "tag")

    def __init__(self, tag: str, attrib: dict[str, str], line: int) -> None:
        self.tag = tag
        self.attrib = attrib
        self.line = line
        self.children: list[Node] = []
        self.parts: list[str] = []

    @property
    def raw(self) -> str:
        """Joined text directly inside, with its white space."""
        return "".join(self.parts)

    @property
    def text(self) -> str:
        """Joined, stripped text directly inside."""
        return self.raw.strip()

    def child(self, tag: str) -> Node | None:
        """The first child element with that name."""
        for node in self.children:
            if node.tag == tag:
                return node
        return None

    def value(self, path: str) -> str:
        """Text of the element at ``a/b/c`` below; empty if there is none."""
        node: Node | None = self
        for tag in path.split("/"):
            node = None if node is None else node.child(tag)
        return "" if node is None else node.text

    def table(self, row: str, key: str, value: str) -> dict[str, str]:
        """Map the text of one element inside each row to that of another; the value keeps its white space."""
        out: dict[str, str] = {}
        for entry in self.all(row):
            name, reported = entry.child(key), entry.child(value)
            if name is not None and reported is not None:
                out[name.text] = reported.raw
        return out

    def all(self, tag: str) -> Iterable[Node]:
        """The child elements with that name."""
        return (node for node in self.children if node.tag == tag)


class _Builder:
    """Keeps wanted elements whole; of all others it only knows whether they are open."""

    def __init__(self, wanted: frozenset[str], without_content: frozenset[str], file: str) -> None:
        self._wanted = wanted
        self._without_content = without_content
        self._file = file
        self.finished: list[Node] = []
        self.root = ""
        self.expat: XMLParserType

    def register_handlers(self, expat: XMLParserType) -> None:
        """Register as the parser's handlers directly: ElementTree's layer in between doubles the time.

        The handlers use plain names instead of attributes: an export of an hour's drive has six million elements.
        """
        self.expat = expat
        wanted, without_content, finished = self._wanted, self._without_content, self.finished
        stack: list[Node] = []
        depth = 0

        def start(tag: str, attrib: dict[str, str]) -> None:
            nonlocal depth
            if not depth:
                self.root = tag
            if depth >= MAX_DEPTH:
                rule = f"elements are nested deeper than {MAX_DEPTH}. Export it again."
                raise rule_error(self._file, int(expat.CurrentLineNumber), rule)
            depth += 1
            if stack:
                node = Node(tag, attrib, expat.CurrentLineNumber)
                stack[-1].children.append(node)
                stack.append(node)
            elif tag in wanted:
                stack.append(Node(tag, attrib, expat.CurrentLineNumber))
            elif tag in without_content:
                finished.append(Node(tag, attrib, expat.CurrentLineNumber))

        def end(_tag: str) -> None:
            nonlocal depth
            depth -= 1
            if stack:
                node = stack.pop()
                if not stack:
                    finished.append(node)

        def data(text: str) -> None:
            if stack:
                stack[-1].parts.append(text)

        expat.ordered_attributes = False
        expat.buffer_text = True
        expat.StartElementHandler, expat.EndElementHandler, expat.CharacterDataHandler = start, end, data

    def close(self) -> None:
        """Satisfy ``XMLParser``; ``elements`` takes ``finished`` as it fills."""


def elements(
    path: Path, root: str, wanted: Iterable[str], *, without_content: Iterable[str] = (), name: str | None = None
) -> Iterator[Node]:
    """Yield the wanted elements of a file whole, one after the other; earlier ones are not kept.

    Args:
        path: the file.
        root: required name of the outermost element.
        wanted: names of elements; one inside another wanted one is its child.
        without_content: names of elements to yield without their content.
        name: the file's name for messages; unset: that of ``path``.

    Raises:
        ImportFormatError: not well-formed, a DOCTYPE or an entity, another root; names file and line.
    """
    file = path.name if name is None else name
    builder = _Builder(frozenset(wanted), frozenset(without_content), file)
    parser = XMLParser(target=builder, forbid_dtd=True, forbid_entities=True, forbid_external=True)
    builder.register_handlers(parser.parser)
    try:
        with path.open("rb") as stream:
            while chunk := stream.read(_CHUNK):
                parser.feed(chunk)
                if builder.root and builder.root != root:
                    raise rule_error(file, 1, f"the outermost element is <{builder.root[:60]}>, must be <{root}>.")
                yield from builder.finished
                builder.finished.clear()
        parser.close()
    except DefusedXmlException:
        line = int(builder.expat.CurrentLineNumber)
        rule = "a DOCTYPE or entity declaration is not allowed; annotations need none. Delete it."
        raise rule_error(file, line, rule, "unsafe") from None
    except ParseError as error:
        line, _ = error.position
        reason = str(error).split(": line")[0]
        raise rule_error(file, line, f"is not well-formed XML: {reason}. Export it again.") from None
    except (LookupError, UnicodeError, ValueError) as error:
        raise rule_error(file, 1, f"cannot be decoded: {error}. Save it as UTF-8.") from None
    yield from builder.finished


def attribute(node: Node, name: str, file: str) -> str:
    """A required attribute.

    Raises:
        ImportFormatError: it is missing.
    """
    try:
        return node.attrib[name]
    except KeyError:
        raise rule_error(file, node.line, f"<{node.tag}> must have {name}. Export it again.") from None


def number_attribute(node: Node, name: str, file: str) -> float:
    """A required number attribute; may be NaN or infinite.

    Raises:
        ImportFormatError: it is missing, or not a number.
    """
    value = attribute(node, name, file)
    try:
        return parse_real(value)
    except ValueError:
        raise rule_error(file, node.line, f"{name} of <{node.tag}> must be a number. Got {value[:40]!r}.") from None


def escape_text(value: str) -> str:
    """Escape text between tags; characters that XML 1.0 cannot hold become U+FFFD."""
    return escape(_INVALID.sub("\ufffd", value))


def quote_attribute(value: str) -> str:
    """Escape and quote an attribute's value."""
    return quoteattr(_INVALID.sub("\ufffd", value))
