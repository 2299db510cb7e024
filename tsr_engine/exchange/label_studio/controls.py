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

__all__ = ["CONFIG_FILE", "answers_of", "controls", "declare_controls", "results"]

CONFIG_FILE = "label_config.xml"
_RESERVED_NAMES = frozenset({"box", "video", "videoLabels"})
"""Names of the configuration's own tags."""
_BOOL_CHOICES = ("true", "false")


def _control_name(name: str) -> str:
    return f"attribute:{name}" if name in _RESERVED_NAMES else written_name(name)


def controls(labels: ClassMap) -> str:
    """The controls of all whole-track attributes; an attribute of two labels gets the values of both."""
    found: dict[str, list[Attribute]] = {}
    for label in labels.labels:
        for each in label.attributes:
            if not each.mutable:
                found.setdefault(each.name, []).append(each)
    return "".join(_control(name, asked) for name, asked in found.items())


def _control(name: str, asked: list[Attribute]) -> str:
    head = f'name={quote_attribute(_control_name(name))} toName="video" perRegion="true"'
    kinds = {each.kind for each in asked}
    if kinds <= {"checkbox", "select"}:
        values = dict.fromkeys(value for each in asked for value in (each.values or _BOOL_CHOICES))
        choices = "".join(f"<Choice value={quote_attribute(value)}/>" for value in values)
        return f'<Choices {head} choice="single">{choices}</Choices>'
    return f"<Number {head}/>" if kinds == {"number"} else f"<TextArea {head}/>"


def results(track: Track, labels: ClassMap) -> list[JsonObject]:
    """The answers of a track, as results beside its region."""
    found = []
    kinds = {each.name: each.kind for label in labels.labels if label.id == track.label for each in label.attributes}
    for name, value in track.attributes.items():
        kind = kinds.get(name, "text")
        what: tuple[str, JsonObject] = ("textarea", {"text": [value_as_text(value)]})
        if kind in ("checkbox", "select"):
            what = ("choices", {"choices": [value_as_text(value)]})
        elif kind == "number":
            what = ("number", {"number": value})
        head = {"id": track.uid, "from_name": _control_name(name), "to_name": "video"}
        found.append({**head, "type": what[0], "value": what[1]})
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
    said = value.get({"textarea": "text"}.get(kind, kind))
    if kind in ("choices", "textarea"):
        texts = [said] if isinstance(said, str) else said if isinstance(said, list) else []
        return ", ".join(str(each) for each in texts) or None
    if kind in ("number", "rating"):
        return said if isinstance(said, int | float) and not isinstance(said, bool) else None
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
            about: JsonObject = {"name": name, "kind": {"Number": "number"}.get(node.tag, "text")}
            if node.tag == "Choices":
                about |= (
                    {"kind": "checkbox"} if set(values) == set(_BOOL_CHOICES) else {"kind": "select", "values": values}
                )
            with suppress(ValidationError):
                attributes.append(Attribute(**about))
    validator.declare("", DeclaredLabel(tuple(attributes)))
