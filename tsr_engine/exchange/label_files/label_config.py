"""Label Studio's labelling configuration: labels, aliases, hotkeys, colours, and choices for each region."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from PIL import ImageColor

from tsr_engine.exchange.label_files.label_collector import FileLabels, LabelCollector
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.xml import Node, attribute, elements, number_attribute, quote_attribute
from tsr_engine.labels.model import Attribute, Label, LabelSet

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
        raise rule_error(path.name, None, f"is larger than the {MAX_BYTES} bytes that are read.")
    collector = LabelCollector(path.name)
    (root,) = elements(path, "View", ("View",))
    nodes = list(_descendants(root))
    lists = [node for node in nodes if node.tag.endswith("Labels") or node.tag == "VideoRectangle"]
    entries = [entry for node in lists for entry in _descendants(node) if entry.tag == "Label"]
    controls = [node for node in nodes if node.tag in _CONTROL_KINDS]
    if not entries:
        choices = [node for node in controls if node.tag == "Choices"]
        entries = [entry for node in choices for entry in _descendants(node) if entry.tag == "Choice"]
        controls = []
    control_attributes = [found for node in controls if (found := _read_control(node, collector)) is not None]
    for entry in entries:
        value = attribute(entry, "value", path.name)
        attributes: dict[str, Attribute] = {}
        for each, label_names in control_attributes:
            if label_names is _ALL_LABELS or value in label_names:
                attributes.setdefault(each.name, each)
        alias = entry.attrib.get("alias", "").strip()
        collector.add(
            value,
            entry.line,
            aliases=(alias,) if alias else (),
            colour=_colour(entry, collector),
            pinned=_digit(entry, collector),
            attributes=tuple(attributes.values()),
        )
    return collector.finish(key, name)


def write_label_config(labels: LabelSet) -> str:
    """Write a configuration for videos; only the first alias is kept, and attributes cannot change within a track."""
    offered = labels.offered()
    lines = ["<View>", '  <Labels name="label" toName="video" allowEmpty="false">']
    for label in offered:
        xml_attributes = {
            "value": label.name,
            "alias": label.aliases[0] if label.aliases else None,
            "hotkey": None if label.pinned is None else str(label.pinned),
            "background": label.colour,
        }
        lines.append(f"    <Label{_xml_attributes(xml_attributes)}/>")
    # Without a rate Label Studio counts 24 frames a second.
    video = '  <Video name="video" value="$video" framerate="$fps"/>'
    lines += ["  </Labels>", video, '  <VideoRectangle name="box" toName="video"/>']
    for attribute_of_labels, label_names in _group_attributes(offered):
        lines += _write_control(attribute_of_labels, label_names, len(offered))
    return "\n".join([*lines, "</View>"]) + "\n"


def _descendants(node: Node) -> Iterator[Node]:
    for inner in node.children:
        yield inner
        yield from _descendants(inner)


def _read_control(node: Node, collector: LabelCollector) -> tuple[Attribute, frozenset[str] | None] | None:
    """The attribute of a control, and the labels that it applies to."""
    name = node.attrib.get("name", "")
    if node.attrib.get("perRegion", "false").lower() != "true":
        collector.note(
            f"{collector.file}, line {node.line}: <{node.tag}> {name!r} is about whole tasks; it was left out."
        )
        return None
    if node.attrib.get("choice") == "multiple":
        collector.note(
            f"{collector.file}, line {node.line}: {name!r} allows several answers; an attribute has one. Left out."
        )
        return None
    fields: dict[str, object] = {"name": name, "kind": _CONTROL_KINDS[node.tag]}
    if node.tag == "Choices":
        choices = [entry for entry in _descendants(node) if entry.tag == "Choice"]
        fields["values"] = tuple(attribute(entry, "value", collector.file) for entry in choices)
        chosen = [entry.attrib["value"] for entry in choices if entry.attrib.get("selected", "false").lower() == "true"]
        fields["default"] = chosen[0] if chosen else None
        if fields["values"] in (("true", "false"), ("false", "true")):
            default = None if not chosen else chosen[0] == "true"
            fields = {"name": name, "kind": "checkbox", "default": default}
    if node.tag == "TextArea" and not node.attrib.get("value", "$").startswith("$"):
        fields["default"] = node.attrib["value"]
    if node.tag == "Number":
        for limit, field in (("min", "low"), ("max", "high"), ("defaultValue", "default")):
            fields[field] = number_attribute(node, limit, collector.file) if limit in node.attrib else None
    label_names = node.attrib.get("whenLabelValue")
    found = collector.attribute(name, fields)
    return None if found is None else (found, _ALL_LABELS if label_names is None else frozenset(label_names.split(",")))


def _colour(entry: Node, collector: LabelCollector) -> str | None:
    background = entry.attrib.get("background")
    if background is None:
        return None
    try:
        red, green, blue = ImageColor.getrgb(_RGBA.sub(r"rgb(\1)", background))[:3]
    except ValueError:
        collector.note(
            f"{collector.file}, line {entry.line}: the colour {background[:40]!r} was left out; write #rrggbb."
        )
        return None
    return f"#{red:02x}{green:02x}{blue:02x}"


def _digit(entry: Node, collector: LabelCollector) -> int | None:
    hotkey = entry.attrib.get("hotkey", "")
    if len(hotkey) == 1 and hotkey in "123456789":
        return int(hotkey)
    if hotkey:
        collector.note(
            f"{collector.file}, line {entry.line}: the hotkey {hotkey[:20]!r} was left out; labels have 1 to 9."
        )
    return None


def _group_attributes(offered: list[Label]) -> list[tuple[Attribute, list[str]]]:
    """Equal attributes of several labels, joined, with the names of the labels."""
    found: dict[str, tuple[Attribute, list[str]]] = {}
    for label in offered:
        for each in label.attributes:
            found.setdefault(each.model_dump_json(exclude={"mutable"}), (each, []))[1].append(label.name)
    return list(found.values())


def _write_control(attribute_of_labels: Attribute, label_names: list[str], label_count: int) -> list[str]:
    """The control of an attribute."""
    xml_attributes = {"name": attribute_of_labels.name, "toName": "video", "perRegion": "true"}
    if len(label_names) < label_count:
        xml_attributes |= {"whenTagName": "label", "whenLabelValue": ",".join(label_names)}
    if attribute_of_labels.kind == "text":
        default_text = None if attribute_of_labels.default is None else str(attribute_of_labels.default)
        return [f"  <TextArea{_xml_attributes({**xml_attributes, 'value': default_text})}/>"]
    if attribute_of_labels.kind == "number":
        limits = {
            "min": attribute_of_labels.low,
            "max": attribute_of_labels.high,
            "defaultValue": attribute_of_labels.default,
        }
        limit_texts = {name: None if value is None else f"{float(value):.10g}" for name, value in limits.items()}
        return [f"  <Number{_xml_attributes({**xml_attributes, **limit_texts})}/>"]
    values = ("true", "false") if attribute_of_labels.kind == "checkbox" else attribute_of_labels.values
    default = attribute_of_labels.default
    selected = str(default).lower() if attribute_of_labels.kind == "checkbox" else default
    rows = [_xml_attributes({"value": value, "selected": "true" if value == selected else None}) for value in values]
    return [
        f"  <Choices{_xml_attributes({**xml_attributes, 'choice': 'single'})}>",
        *(f"    <Choice{row}/>" for row in rows),
        "  </Choices>",
    ]


def _xml_attributes(attributes: dict[str, str | None]) -> str:
    return "".join(f" {name}={quote_attribute(value)}" for name, value in attributes.items() if value is not None)
