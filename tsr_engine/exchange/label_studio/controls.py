"""Converts attributes of labels to and from Label Studio's controls of a region (``perRegion``).

A checkbox or select becomes choices, a number a number, a text a text area. A region has one answer for all of its
frames, so attributes that change from frame to frame cannot be written.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path

from pydantic import ValidationError

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.added_labels import DeclaredLabel
from tsr_engine.exchange.attributes import original_name, value_as_text, written_name
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.labels import ClassMap
from tsr_engine.exchange.xml import elements, quote_attribute
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.labels.model import Attribute, AttributeValue

CONFIG_FILE = "label_config.xml"
_RESERVED_NAMES = frozenset({"box", "video", "videoLabels"})
"""Names of the configuration's own tags."""
_BOOL_CHOICES = ("true", "false")


def _control_name(name: str) -> str:
    return f"attribute:{name}" if name in _RESERVED_NAMES else written_name(name)


def controls(labels: ClassMap) -> str:
    """The controls of all whole-track attributes; an attribute of two labels gets the values of both."""
    attributes_by_name: dict[str, list[Attribute]] = {}
    for label in labels.labels:
        for each in label.attributes:
            if not each.mutable:
                attributes_by_name.setdefault(each.name, []).append(each)
    return "".join(_control(name, attributes) for name, attributes in attributes_by_name.items())


def _control(name: str, attributes: list[Attribute]) -> str:
    head = f'name={quote_attribute(_control_name(name))} toName="video" perRegion="true"'
    kinds = {each.kind for each in attributes}
    if kinds <= {"checkbox", "select"}:
        values = dict.fromkeys(value for each in attributes for value in (each.values or _BOOL_CHOICES))
        choices = "".join(f"<Choice value={quote_attribute(value)}/>" for value in values)
        return f'<Choices {head} choice="single">{choices}</Choices>'
    return f"<Number {head}/>" if kinds == {"number"} else f"<TextArea {head}/>"


def results(track: Track, labels: ClassMap) -> list[JsonObject]:
    """The answers of a track, as results beside its region."""
    found = []
    kinds = {each.name: each.kind for label in labels.labels if label.id == track.label for each in label.attributes}
    for name, value in track.attributes.items():
        kind = kinds.get(name, "text")
        type_and_value: tuple[str, JsonObject] = ("textarea", {"text": [value_as_text(value)]})
        if kind in ("checkbox", "select"):
            type_and_value = ("choices", {"choices": [value_as_text(value)]})
        elif kind == "number":
            type_and_value = ("number", {"number": value})
        head = {"id": track.uid, "from_name": _control_name(name), "to_name": "video"}
        found.append({**head, "type": type_and_value[0], "value": type_and_value[1]})
    return found


def answers_of(regions: Iterable[object]) -> dict[str, dict[str, AttributeValue]]:
    """The answers in the file by region id, then by name of the control."""
    found: dict[str, dict[str, AttributeValue]] = {}
    for region in regions:
        if not isinstance(region, dict) or not isinstance(region.get("id"), str):
            continue
        value = region.get("value")
        answer = _answer(str(region.get("type", "")), value) if isinstance(value, Mapping) else None
        if answer is not None and isinstance(region.get("from_name"), str):
            found.setdefault(region["id"], {})[original_name(region["from_name"])] = answer
    return found


def _answer(kind: str, value: JsonMapping) -> AttributeValue | None:
    answer = value.get({"textarea": "text"}.get(kind, kind))
    if kind in ("choices", "textarea"):
        texts = [answer] if isinstance(answer, str) else answer if isinstance(answer, list) else []
        return ", ".join(str(each) for each in texts) or None
    if kind in ("number", "rating"):
        return answer if isinstance(answer, int | float) and not isinstance(answer, bool) else None
    return None


def declare_controls(folder: Path, validator: ImportValidator) -> None:
    """Declare to a validator the questions of the labelling configuration beside the tasks, if there is one."""
    path = folder / CONFIG_FILE
    if not path.is_file():
        return
    attributes: list[Attribute] = []
    with suppress(ImportFormatError):  # the configuration is optional
        for node in elements(path, "View", ("Choices", "Number", "TextArea")):
            name = original_name(node.attrib.get("name", ""))
            values = tuple(dict.fromkeys(choice.attrib.get("value", "") for choice in node.all("Choice")))
            fields: JsonObject = {"name": name, "kind": {"Number": "number"}.get(node.tag, "text")}
            if node.tag == "Choices":
                fields |= (
                    {"kind": "checkbox"} if set(values) == set(_BOOL_CHOICES) else {"kind": "select", "values": values}
                )
            with suppress(ValidationError):
                attributes.append(Attribute(**fields))
    validator.declare("", DeclaredLabel(tuple(attributes)))
