"""Gives tracks the attributes in the rows of a file; attributes that a label lacks are added to it or left out."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from pydantic import ValidationError

from tsr_engine.exchange.added_labels import DeclaredLabel, with_labels
from tsr_engine.exchange.dataset import Skipped, Track
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.labels.model import Attribute, AttributeKind, AttributeValue, Label, LabelSet
from tsr_engine.track_table import NO_CLASS

RowAttributes = JsonMapping | None
"""Attributes of a row by name; None: the row has none."""


def add_attributes(
    labels: LabelSet,
    tracks: list[Track],
    rows: Mapping[int, Sequence[RowAttributes]],
    declared: Mapping[int, DeclaredLabel],
    add: Callable[[int], bool],
    file: str,
) -> tuple[LabelSet, list[Skipped]]:
    """Give tracks the attributes in the rows of a file; attributes that a label lacks are added or reported.

    Args:
        labels: the label set.
        tracks: tracks with attributes in the rows are replaced.
        rows: index of a track -> attributes of each of its frames.
        declared: the file's declarations of labels, by id.
        add: whether the label with this id gets the attributes that it lacks.
        file: for messages.

    Returns:
        The label set, and what was left out.
    """
    skips = Counter[Skipped]()
    by_label: dict[int, dict[str, list[list[object]]]] = {}
    for index, row_attributes in rows.items():
        columns_by_name = by_label.setdefault(tracks[index].label, {})
        for name, column in _columns(row_attributes).items():
            columns_by_name.setdefault(name, []).append(column)
    known: dict[int, dict[str, Attribute]] = {}
    changed: dict[int, Label] = {}
    for label_id, columns_by_name in by_label.items():
        label = labels.get(label_id)
        if label is None:
            continue
        found = {each.name: each for each in label.attributes}
        if add(label_id):
            declared_attributes = {each.name: each for each in declared.get(label_id, DeclaredLabel()).attributes}
            for name, columns in columns_by_name.items():
                new = _attribute_for(found.get(name), declared_attributes.get(name), name, columns)
                if new is not None:
                    found[name] = new
            if tuple(found.values()) != label.attributes:
                changed[label_id] = label.model_copy(update={"attributes": tuple(found.values())})
        known[label_id] = found
    if changed:
        labels = with_labels(labels, tuple(changed.get(label.id, label) for label in labels), file)
    for index, row_attributes in rows.items():
        track = tracks[index]
        label = labels.get(track.label)
        tracks[index] = _with_answers(
            track, row_attributes, known.get(track.label, {}), None if label is None else label.name, skips
        )
    return labels, [
        replace(each, what=f"{each.what} ({count} times)") if count > 1 else each for each, count in skips.items()
    ]


def _columns(rows: Sequence[RowAttributes]) -> dict[str, list[object]]:
    """Values of a track's rows, by attribute name."""
    out: dict[str, list[object]] = {}
    previous: RowAttributes = None
    for row in rows:
        # All frames of one row share one object.
        if row is None or row is previous:
            continue
        previous = row
        for name, value in row.items():
            out.setdefault(name, []).append(value)
    return out


def _attribute_for(
    known: Attribute | None, declared: Attribute | None, name: str, columns: list[list[object]]
) -> Attribute | None:
    """The attribute that can hold all values; None: no attribute can."""
    attribute = known or declared
    if attribute is None:
        mutable = any(any(value != column[0] for value in column) for column in columns)
        try:
            return Attribute(name=name, kind=_kind(columns), mutable=mutable)
        except ValidationError:
            return None
    if attribute.kind != "select":
        return attribute
    new = dict.fromkeys(text for column in columns for value in column if (text := _plain(value)))
    values = (*attribute.values, *(value for value in new if value not in attribute.values))
    try:
        return Attribute(**(attribute.model_dump() | {"values": values}))
    except ValidationError:
        return attribute


def _kind(columns: list[list[object]]) -> AttributeKind:
    values = [value for column in columns for value in column]
    if all(isinstance(value, bool) or str(value).casefold() in ("true", "false") for value in values):
        return "checkbox"
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return "number"
    return "text"


def _plain(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:.12g}" if isinstance(value, int | float) else str(value).strip()


def _answer(attribute: Attribute, value: AttributeValue) -> AttributeValue:
    """A value in the form that the attribute stores.

    Raises:
        ValueError: the attribute cannot hold it; the message is part of a sentence.
    """
    result: AttributeValue = _plain(value)
    if attribute.kind == "checkbox":
        text = str(result).casefold()
        result = text in ("true", "1") if text in ("true", "false", "0", "1") else result
    elif attribute.kind == "number":
        number = math.nan
        with suppress(ValueError, OverflowError):
            number = parse_real(value) if isinstance(value, str) else float(value)
        result = number if math.isfinite(number) else result
    problem = attribute.problem(result)
    if problem is not None:
        raise ValueError(problem)
    return result


def _with_answers(
    track: Track,
    rows: Sequence[RowAttributes],
    known: Mapping[str, Attribute],
    label: str | None,
    skips: Counter[Skipped],
) -> Track:
    """The track with the values of its rows."""
    constant: dict[str, AttributeValue] = {}
    changing: JsonObject = {}
    for name in _columns(rows):
        attribute = known.get(name)
        if attribute is None:
            why = (
                f"The label {label!r} has no such attribute. Import with unknown=add to add it."
                if track.label != NO_CLASS and label is not None
                else "Tracks without a label have no attributes."
            )
            skips[Skipped(f"attribute {name[:80]!r}", why)] += 1
            continue
        values = np.full(len(track.frames), None, object)
        for k, row in enumerate(rows):
            if row is not None and name in row:
                try:
                    values[k] = _answer(attribute, row[name])
                except ValueError as error:
                    reason = f"The label set says: {str(error)[:200]}."
                    skips[Skipped(f"answers to {name[:80]!r} of {label!r}", reason)] += 1
        given = [value for value in values.tolist() if value is not None]
        if not given:
            continue
        if attribute.mutable:
            changing[name] = values
            continue
        if any(value != given[0] for value in given):
            reason = f"{label!r} has one answer for a whole track; the first one was taken."
            skips[Skipped(f"answers to {name[:80]!r} that change within a track", reason)] += 1
        constant[name] = given[0]
    return replace(track, attributes=constant, changing=changing)
