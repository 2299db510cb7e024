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
from tsr_engine.exchange.additions import Declared
from tsr_engine.exchange.attributes import as_text, restored, written
from tsr_engine.exchange.checks import ImportValidator
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.labels import ClassMap
from tsr_engine.exchange.xml import elements, quoted
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.labels.model import Attribute, AttributeValue

__all__ = ["CONFIG", "answers_of", "controls", "declare_controls", "results"]

CONFIG = "label_config.xml"
_NAMES = frozenset({"box", "video", "videoLabels"})
"""Names of the configuration's own tags."""
_TRUTH = ("true", "false")


def _name(name: str) -> str:
    return f"attribute:{name}" if name in _NAMES else written(name)


def controls(labels: ClassMap) -> str:
    """The controls of all whole-track attributes; an attribute of two labels gets the values of both."""
    found: dict[str, list[Attribute]] = {}
    for label in labels.labels:
        for each in label.attributes:
            if not each.mutable:
                found.setdefault(each.name, []).append(each)
    return "".join(_control(name, asked) for name, asked in found.items())


def _control(name: str, asked: list[Attribute]) -> str:
    head = f'name={quoted(_name(name))} toName="video" perRegion="true"'
    kinds = {each.kind for each in asked}
    if kinds <= {"checkbox", "select"}:
        values = dict.fromkeys(value for each in asked for value in (each.values or _TRUTH))
        choices = "".join(f"<Choice value={quoted(value)}/>" for value in values)
        return f'<Choices {head} choice="single">{choices}</Choices>'
    return f"<Number {head}/>" if kinds == {"number"} else f"<TextArea {head}/>"


def results(track: Track, labels: ClassMap) -> list[JsonObject]:
    """The answers of a track, as results beside its region."""
    found = []
    kinds = {each.name: each.kind for label in labels.labels if label.id == track.label for each in label.attributes}
    for name, value in track.attributes.items():
        kind = kinds.get(name, "text")
        what: tuple[str, JsonObject] = ("textarea", {"text": [as_text(value)]})
        if kind in ("checkbox", "select"):
            what = ("choices", {"choices": [as_text(value)]})
        elif kind == "number":
            what = ("number", {"number": value})
        head = {"id": track.uid, "from_name": _name(name), "to_name": "video"}
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
            found.setdefault(region["id"], {})[restored(region["from_name"])] = answer
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
    path = folder / CONFIG
    if not path.is_file():
        return
    attributes: list[Attribute] = []
    with suppress(ImportFormatError):  # the configuration is optional
        for node in elements(path, "View", ("Choices", "Number", "TextArea")):
            name = restored(node.attrib.get("name", ""))
            values = tuple(dict.fromkeys(choice.attrib.get("value", "") for choice in node.all("Choice")))
            about: JsonObject = {"name": name, "kind": {"Number": "number"}.get(node.tag, "text")}
            if node.tag == "Choices":
                about |= {"kind": "checkbox"} if set(values) == set(_TRUTH) else {"kind": "select", "values": values}
            with suppress(ValidationError):
                attributes.append(Attribute(**about))
    validator.declare("", Declared(tuple(attributes)))
