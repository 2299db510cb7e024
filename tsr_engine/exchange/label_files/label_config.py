"""Label Studio's labelling configuration: labels, aliases, hotkeys, colours, and choices for each region."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from PIL import ImageColor

from tsr_engine.exchange.label_files.label_collector import FileLabels, LabelCollector
from tsr_engine.exchange.reading import refuse
from tsr_engine.exchange.xml import Node, attribute, elements, number_attribute, quote_attribute
from tsr_engine.labels.model import Attribute, Label, LabelSet

__all__ = ["MAX_BYTES", "read_label_config", "write_label_config"]

MAX_BYTES: Final = 16 << 20
_CONTROL_KINDS: Final = {"Choices": "select", "Number": "number", "TextArea": "text"}
_RGBA: Final = re.compile(r"^\s*rgba\((.*),[^,]*\)\s*$")
"""A colour with transparency, which is dropped."""
_ALL_LABELS: Final = None
"""The labels of a question that names none."""


def read_label_config(path: Path, key: str, name: str) -> FileLabels:
    """Read the labels of ``<Labels>``, ``<RectangleLabels>`` and the like; per-region controls become attributes.

    A configuration without such a list has its labels in ``<Choices>``. Exported results hold the ``alias`` instead of
    the name, so it becomes an alias of the label. A ``hotkey`` that is a digit becomes the label's digit.

    Raises:
        ImportFormatError: not XML, another root, or no labels; names the line.
    """
    if path.stat().st_size > MAX_BYTES:
        raise refuse(path.name, None, f"is larger than the {MAX_BYTES} bytes that are read.")
    taken = LabelCollector(path.name)
    (root,) = elements(path, "View", ("View",))
    inside = list(_descendants(root))
    lists = [node for node in inside if node.tag.endswith("Labels") or node.tag == "VideoRectangle"]
    entries = [entry for node in lists for entry in _descendants(node) if entry.tag == "Label"]
    questions = [node for node in inside if node.tag in _CONTROL_KINDS]
    if not entries:
        choices = [node for node in questions if node.tag == "Choices"]
        entries = [entry for node in choices for entry in _descendants(node) if entry.tag == "Choice"]
        questions = []
    asked = [found for node in questions if (found := _read_control(node, taken)) is not None]
    for entry in entries:
        value = attribute(entry, "value", path.name)
        attributes: list[Attribute] = []
        for question, about in asked:
            if (about is _ALL_LABELS or value in about) and question.name not in {each.name for each in attributes}:
                attributes.append(question)
        alias = entry.attrib.get("alias", "").strip()
        taken.add(
            value,
            entry.line,
            aliases=(alias,) if alias else (),
            colour=_colour(entry, taken),
            pinned=_digit(entry, taken),
            attributes=tuple(attributes),
        )
    return taken.finish(key, name)


def write_label_config(labels: LabelSet) -> str:
    """Write a configuration for videos; only the first alias is kept, and attributes cannot change within a track."""
    offered = labels.offered()
    lines = ["<View>", '  <Labels name="label" toName="video" allowEmpty="false">']
    for label in offered:
        facts = {
            "value": label.name,
            "alias": label.aliases[0] if label.aliases else None,
            "hotkey": None if label.pinned is None else str(label.pinned),
            "background": label.colour,
        }
        lines.append(f"    <Label{_xml_attributes(facts)}/>")
    lines += ["  </Labels>", '  <Video name="video" value="$video"/>', '  <VideoRectangle name="box" toName="video"/>']
    for question, about in _group_attributes(offered):
        lines += _write_control(question, about, len(offered))
    return "\n".join([*lines, "</View>"]) + "\n"


def _descendants(node: Node) -> Iterator[Node]:
    for inner in node.children:
        yield inner
        yield from _descendants(inner)


def _read_control(node: Node, taken: LabelCollector) -> tuple[Attribute, frozenset[str] | None] | None:
    """The attribute of a control, and the labels that it applies to."""
    name = node.attrib.get("name", "")
    if node.attrib.get("perRegion", "false").lower() != "true":
        taken.note(f"{taken.file}, line {node.line}: <{node.tag}> {name!r} is about whole tasks; it was left out.")
        return None
    if node.attrib.get("choice") == "multiple":
        taken.note(f"{taken.file}, line {node.line}: {name!r} allows several answers; an attribute has one. Left out.")
        return None
    facts: dict[str, object] = {
        "name": name,
        "kind": {"Choices": "select", "Number": "number", "TextArea": "text"}[node.tag],
    }
    if node.tag == "Choices":
        choices = [entry for entry in _descendants(node) if entry.tag == "Choice"]
        facts["values"] = tuple(attribute(entry, "value", taken.file) for entry in choices)
        chosen = [entry.attrib["value"] for entry in choices if entry.attrib.get("selected", "false").lower() == "true"]
        facts["default"] = chosen[0] if chosen else None
        if facts["values"] in (("true", "false"), ("false", "true")):
            default = None if not chosen else chosen[0] == "true"
            facts = {"name": name, "kind": "checkbox", "default": default}
    if node.tag == "TextArea" and not node.attrib.get("value", "$").startswith("$"):
        facts["default"] = node.attrib["value"]
    if node.tag == "Number":
        for limit, field in (("min", "low"), ("max", "high"), ("defaultValue", "default")):
            facts[field] = number_attribute(node, limit, taken.file) if limit in node.attrib else None
    about = node.attrib.get("whenLabelValue")
    found = taken.attribute(name, facts)
    return None if found is None else (found, _ALL_LABELS if about is None else frozenset(about.split(",")))


def _colour(entry: Node, taken: LabelCollector) -> str | None:
    said = entry.attrib.get("background")
    if said is None:
        return None
    try:
        red, green, blue = ImageColor.getrgb(_RGBA.sub(r"rgb(\1)", said))[:3]
    except ValueError:
        taken.note(f"{taken.file}, line {entry.line}: the colour {said[:40]!r} was left out; write #rrggbb.")
        return None
    return f"#{red:02x}{green:02x}{blue:02x}"


def _digit(entry: Node, taken: LabelCollector) -> int | None:
    said = entry.attrib.get("hotkey", "")
    if len(said) == 1 and said in "123456789":
        return int(said)
    if said:
        taken.note(f"{taken.file}, line {entry.line}: the hotkey {said[:20]!r} was left out; labels have 1 to 9.")
    return None


def _group_attributes(offered: list[Label]) -> list[tuple[Attribute, list[str]]]:
    """Equal attributes of several labels, joined, with the names of the labels."""
    found: dict[str, tuple[Attribute, list[str]]] = {}
    for label in offered:
        for each in label.attributes:
            found.setdefault(each.model_dump_json(exclude={"mutable"}), (each, []))[1].append(label.name)
    return list(found.values())


def _write_control(question: Attribute, about: list[str], everything: int) -> list[str]:
    """The control of an attribute."""
    facts = {"name": question.name, "toName": "video", "perRegion": "true"}
    if len(about) < everything:
        facts |= {"whenTagName": "label", "whenLabelValue": ",".join(about)}
    if question.kind == "text":
        written = None if question.default is None else str(question.default)
        return [f"  <TextArea{_xml_attributes({**facts, 'value': written})}/>"]
    if question.kind == "number":
        limits = {"min": question.low, "max": question.high, "defaultValue": question.default}
        plain = {name: None if value is None else f"{float(value):.10g}" for name, value in limits.items()}
        return [f"  <Number{_xml_attributes({**facts, **plain})}/>"]
    values = ("true", "false") if question.kind == "checkbox" else question.values
    default = str(question.default).lower() if question.kind == "checkbox" else question.default
    rows = [_xml_attributes({"value": value, "selected": "true" if value == default else None}) for value in values]
    return [
        f"  <Choices{_xml_attributes({**facts, 'choice': 'single'})}>",
        *(f"    <Choice{row}/>" for row in rows),
        "  </Choices>",
    ]


def _xml_attributes(facts: dict[str, str | None]) -> str:
    return "".join(f" {name}={quote_attribute(value)}" for name, value in facts.items() if value is not None)
