"""CVAT's raw labels: the JSON that its label constructor shows under "Raw"."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Final

from tsr_engine.exchange.attributes import original_name, written_name
from tsr_engine.exchange.cvat.common import OPTIONAL_ATTRIBUTES, TOOL_ATTRIBUTES, tool_attributes
from tsr_engine.exchange.json_stream import members
from tsr_engine.exchange.label_files.label_collector import FileLabels, LabelCollector
from tsr_engine.exchange.reading import rule_error
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.model import Attribute, LabelSet

MAX_BYTES: Final = 16 << 20
_COLOUR = re.compile("#[0-9a-f]{6}")
_UNLIMITED: Final = 10**9
"""Written for a missing limit of a number: CVAT needs both limits."""
_BOX_TYPES = frozenset({"any", "rectangle"})


def read_cvat_labels(path: Path, key: str, name: str) -> FileLabels:
    """Read labels with colours and attributes; CVAT's ``id`` is ignored.

    Raises:
        ImportFormatError: not a list of labels; names the line or the place.
    """
    collector = LabelCollector(path.name)
    for member, position, found in members(path, limit=MAX_BYTES):
        if member or position is None:
            raise rule_error(path.name, None, "must be a list of labels, as CVAT's tab Raw shows it.")
        if position:
            _read_label(found, f"label {position}", collector)
    return collector.finish(key, name)


def write_cvat_labels(labels: LabelSet) -> str:
    """Write the labels that are offered, without aliases and pictograms.

    Each declares this tool's attributes too: CVAT drops those of an import that the labels of its task lack.
    """
    own = [_attribute_as_json(attribute, attribute.name) for attribute in tool_attributes(OPTIONAL_ATTRIBUTES)]
    content = [
        {
            "name": label.name,
            **({} if label.colour is None else {"color": label.colour}),
            "type": "any",
            "attributes": [*own, *(_attribute_as_json(each, written_name(each.name)) for each in label.attributes)],
        }
        for label in labels.offered()
    ]
    return json.dumps(content, ensure_ascii=False, indent=2) + "\n"


def _read_label(found: object, where: str, collector: LabelCollector) -> None:
    if not isinstance(found, dict) or not isinstance(name := found.get("name"), str):
        raise rule_error(collector.file, where, "must be an object with a name. Copy it from CVAT again.")
    kind, colour, listed = found.get("type", "any"), found.get("color"), found.get("attributes") or []
    if kind not in _BOX_TYPES:
        collector.note(f"{collector.file}: {name!r} is a label for {str(kind)[:40]}; it was taken as one for boxes.")
    if colour is not None and not (isinstance(colour, str) and _COLOUR.fullmatch(colour.lower())):
        collector.note(
            f"{collector.file}: the colour of {name!r} was left out: {str(colour)[:40]!r} is not in the form #rrggbb."
        )
        colour = None
    if not isinstance(listed, list):
        raise rule_error(collector.file, where, "attributes must be a list. Copy it from CVAT again.")
    attributes: list[Attribute] = []
    if not all(isinstance(each, dict) for each in listed):
        raise rule_error(collector.file, where, "an attribute must be an object. Copy it from CVAT again.")
    # In files of others these names are attributes of labels.
    own_names = TOOL_ATTRIBUTES if any(each.get("name") == "uid" for each in listed) else frozenset()
    for each in (each for each in listed if str(each.get("name")) not in own_names):
        attribute = collector.attribute(name, _attribute_fields(each, name, where, collector))
        if attribute is not None and attribute.name in {known.name for known in attributes}:
            collector.note(
                f"{collector.file}, label {name!r}: the attribute {attribute.name!r} occurs twice; the first counts."
            )
        elif attribute is not None:
            attributes.append(attribute)
    collector.add(name, where, colour=colour and colour.lower(), attributes=tuple(attributes))


def _attribute_fields(each: JsonObject, label: str, where: str, collector: LabelCollector) -> JsonObject:
    """Fields of an attribute."""
    kind, default = each.get("input_type"), each.get("default_value")
    values = each.get("values") or []
    if not isinstance(values, list) or kind not in ("checkbox", "select", "radio", "number", "text"):
        rule = "an attribute must have the input_type checkbox, select, radio, number or text, and a list of values."
        raise rule_error(collector.file, where, rule)
    values = [str(value) for value in values]
    written = each.get("name")
    fields = {
        "name": original_name(written) if isinstance(written, str) else written,
        "mutable": each.get("mutable") is True,
    }
    default = None if default is None or default == "" else default
    if kind == "checkbox":
        checked = None if default is None else str(default).lower() == "true"
        return {**fields, "kind": "checkbox", "default": checked}
    if kind == "text":
        return {**fields, "kind": "text", "default": None if default is None else str(default)}
    if kind == "number":
        low, high, step = [*(_number(value, label, where, collector) for value in values[:3]), None, None, None][:3]
        if step not in (None, 1.0):
            collector.note(f"{collector.file}, label {label!r}: the step of {each.get('name')!r} is not kept.")
        limits = {"low": None if low == -_UNLIMITED else low, "high": None if high == _UNLIMITED else high}
        given = None if default is None else _number(str(default), label, where, collector)
        return {**fields, "kind": "number", "default": given, **limits}
    if default is not None and str(default) not in values:
        problem = f"the default of {each.get('name')!r} is not one of its values; it was left out."
        collector.note(f"{collector.file}, label {label!r}: {problem}")
        default = None
    chosen = None if default is None else str(default)
    return {**fields, "kind": "select", "values": tuple(values), "default": chosen}


def _number(value: str, label: str, where: str, collector: LabelCollector) -> float:
    try:
        return parse_real(value)
    except ValueError:
        raise rule_error(
            collector.file, where, f"{value[:40]!r} in an attribute of {label!r} must be a number."
        ) from None


def _attribute_as_json(attribute: Attribute, name: str) -> JsonObject:
    """An attribute in CVAT's form, in which each has a default, under the name that exports write."""
    default, values = attribute.default, list(attribute.values)
    if attribute.kind == "checkbox":
        shown = str(default is True).lower()
        values = [shown]
    elif attribute.kind == "number":
        low = -_UNLIMITED if attribute.low is None else attribute.low
        high = _UNLIMITED if attribute.high is None else attribute.high
        shown = _plain(min(max(0.0, low), high) if default is None else float(default))
        values = [_plain(low), _plain(high), "1"]
    elif attribute.kind == "select":
        shown = values[0] if default is None else str(default)
    else:
        shown = "" if default is None else str(default)
        values = [shown]
    return {
        "name": name,
        "mutable": attribute.mutable,
        "input_type": attribute.kind,
        "default_value": shown,
        "values": values,
    }


def _plain(value: float) -> str:
    return str(int(value)) if value == int(value) else repr(value)
