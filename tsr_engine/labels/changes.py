"""Changes of a label set: each returns the next version and a sentence about the change."""

from __future__ import annotations

import json
import re
import unicodedata
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Final

from pydantic import ValidationError

from tsr_engine.json_shapes import JsonMapping
from tsr_engine.labels.conflicts import ChangeError, NoLabelError, claims_of, require_free, require_unclaimed
from tsr_engine.labels.model import MAX_LABELS, Label, LabelSet
from tsr_engine.labels.name_matching import comparable, first_problem

UPDATABLE: Final = (
    *("name", "short", "aliases", "shape", "category", "attributes", "teach", "colour", "size_mm", "mirror", "pinned"),
)
"""Fields that :func:`update_label` can change."""
_MAX_KEY_LENGTH = 80
_NON_WORD = re.compile(r"[^\w]+|_+")


@dataclass(frozen=True, slots=True)
class Changed:
    """The result of a change.

    Attributes:
        labels: the next version; the old version if nothing changes.
        sentence: one sentence about the change, for people.
        label: the changed label; None: several labels changed, or the label is gone.
    """

    labels: LabelSet
    sentence: str
    label: Label | None = None


def key_of(name: str, taken: Callable[[str], bool] = lambda key: False) -> str:
    """Make a key from a name: lower case, letters and digits of any script, hyphens between words.

    Args:
        name: name for people.
        taken: whether a key is in use; a number is appended until one is free.
    """
    parts = _NON_WORD.split(unicodedata.normalize("NFKC", name).casefold())
    key = "-".join(part for part in parts if part)[:_MAX_KEY_LENGTH].strip("-") or "label"
    number, unique = 1, key
    while taken(unique):
        number += 1
        unique = f"{key}-{number}"
    return unique


def add_label(labels: LabelSet, fields: JsonMapping) -> Changed:
    """Add one label with the next id.

    Args:
        labels: the newest version.
        fields: fields of :class:`Label` as JSON values, without ``id``; an absent ``key`` is made from the name.

    Raises:
        TakenError: another label has the key, the name, an alias or the digit.
        ChangeError: a field is invalid, or the set is full.
    """
    claims = claims_of(labels)
    fields = dict(fields)
    if fields.get("key") is None:
        keys = {label.key.casefold() for label in labels}
        # The name is checked below; here it must not block a key made from it.
        own_word = comparable(str(fields.get("name", "")))
        fields["key"] = key_of(
            str(fields.get("name", "")),
            lambda key: key.casefold() in keys or (comparable(key) in claims and comparable(key) != own_word),
        )
        require_unclaimed(claims, str(fields.get("name", "")), "name")
    label = _label({**fields, "id": labels.next_id})
    require_free(label, labels, claims)
    _require_mirror(labels, label)
    added = next_version(labels, (*labels.labels, label), labels.next_id + 1)
    return Changed(added, f"Added '{label.name}'.", label)


def update_label(labels: LabelSet, label_id: int, fields: JsonMapping) -> Changed:
    """Change fields of one label.

    Args:
        labels: the newest version.
        label_id: which label.
        fields: fields of ``UPDATABLE`` as JSON values.

    Raises:
        NoLabelError: there is no such label.
        TakenError: another label has the name, an alias or the digit.
        ChangeError: a field is invalid, or the label is merged into another.
    """
    before = _unmerged_label(labels, label_id)
    unknown_field = next((name for name in fields if name not in UPDATABLE), None)
    if unknown_field is not None:
        raise ChangeError(f"The field {unknown_field!r} of a label cannot be changed.", unknown_field)
    after = _label({**before.model_dump(mode="json"), **fields})
    if after == before:
        return Changed(labels, f"'{before.name}' stays as it is.", before)
    require_free(after, labels)
    _require_mirror(labels, after)
    return Changed(_with_label(labels, after), _describe_change(before, after), after)


def set_picture(labels: LabelSet, label_id: int, pictogram: str) -> Changed:
    """Set another pictogram of a label; see ``Label.pictogram``.

    Raises:
        NoLabelError: there is no such label.
        ChangeError: the label is merged into another.
    """
    before = _unmerged_label(labels, label_id)
    after = _label({**before.model_dump(mode="json"), "pictogram": pictogram})
    if after == before:
        return Changed(labels, f"'{before.name}' keeps its picture.", before)
    sentence = "Gave '{}' a picture." if pictogram else "Took the picture of '{}' away."
    return Changed(_with_label(labels, after), sentence.format(before.name), after)


def merge_labels(labels: LabelSet, label_id: int, into: int) -> Changed:
    """Replace one label by another from now on; stored tracks are not rewritten.

    Raises:
        NoLabelError: one of the labels does not exist.
        ChangeError: a label is merged with itself, or is merged already.
    """
    before, target = _unmerged_label(labels, label_id), _existing_label(labels, into, "into")
    if labels.resolved(into) == label_id:
        reason = "" if into == label_id else f": '{target.name}' is merged into it"
        raise ChangeError(f"'{before.name}' cannot be merged into itself{reason}.", "into")
    target = _existing_label(labels, labels.resolved(into), "into")
    after = before.model_copy(update={"merged_into": target.id, "pinned": None})
    return Changed(_with_label(labels, after), f"Merged '{before.name}' into '{target.name}'.", after)


def hide_label(labels: LabelSet, label_id: int) -> Changed:
    """Stop offering a label; tracks that have it keep it.

    Raises:
        NoLabelError: there is no such label.
        ChangeError: the label is merged into another.
    """
    before = _unmerged_label(labels, label_id)
    if before.hidden:
        return Changed(labels, f"'{before.name}' is hidden already.", before)
    after = before.model_copy(update={"hidden": True, "pinned": None})
    return Changed(_with_label(labels, after), f"Hid '{before.name}'.", after)


def show_label(labels: LabelSet, label_id: int) -> Changed:
    """Offer a hidden label again.

    Raises:
        NoLabelError: there is no such label.
        ChangeError: the label is merged into another.
    """
    before = _unmerged_label(labels, label_id)
    if not before.hidden:
        return Changed(labels, f"'{before.name}' is not hidden.", before)
    after = before.model_copy(update={"hidden": False})
    return Changed(_with_label(labels, after), f"Shows '{before.name}' again.", after)


def next_version(labels: LabelSet, content: tuple[Label, ...], next_id: int) -> LabelSet:
    """The version after ``labels`` with other content.

    Raises:
        ChangeError: the content breaks a rule of label sets.
    """
    if len(content) > MAX_LABELS:
        raise ChangeError(f"The set would have {len(content)} labels; it can have at most {MAX_LABELS}.")
    try:
        return LabelSet(key=labels.key, name=labels.name, version=labels.version + 1, next_id=next_id, labels=content)
    except ValidationError as error:
        raise ChangeError(f"{_sentence(first_problem(error)[1])}.") from None


def _require_mirror(labels: LabelSet, label: Label) -> None:
    if label.mirror is not None and label.mirror != label.key and labels.by_key(label.mirror) is None:
        message = f"The mirror image of '{label.name}' is {label.mirror!r}, which is not a key of the set."
        raise ChangeError(message, "mirror")


def _existing_label(labels: LabelSet, label_id: int, field: str = "id") -> Label:
    found = labels.get(label_id)
    if found is None:
        raise NoLabelError(f"The set '{labels.name}' has no label {label_id}.", field)
    return found


def _unmerged_label(labels: LabelSet, label_id: int) -> Label:
    """A label that exists and is not merged."""
    found = _existing_label(labels, label_id)
    if found.merged_into is not None:
        target = _existing_label(labels, labels.resolved(label_id))
        message = f"'{found.name}' is merged into '{target.name}' (label {target.id})."
        raise ChangeError(f"{message} Change that one, or undo the merge.", "id")
    return found


def _label(fields: JsonMapping) -> Label:
    try:
        return Label.model_validate_json(json.dumps(fields))
    except ValidationError as error:
        place, problem = first_problem(error)
        field = place.partition(".")[0] or None
        raise ChangeError(f"{_sentence(f'{place}: {problem}' if place else problem)}.", field) from None


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:].rstrip(".")


def _with_label(labels: LabelSet, label: Label) -> LabelSet:
    content = tuple(label if other.id == label.id else other for other in labels)
    return next_version(labels, content, labels.next_id)


def _describe_change(before: Label, after: Label) -> str:
    changed = [name for name in UPDATABLE if getattr(before, name) != getattr(after, name)]
    if changed == ["name"]:
        return f"Renamed '{before.name}' to '{after.name}'."
    words = join_words([{"size_mm": "size", "pinned": "digit"}.get(name, name) for name in changed])
    renamed = f", now '{after.name}'" if "name" in changed else ""
    return f"Changed {words} of '{before.name}'{renamed}."


def join_words(words: Collection[str]) -> str:
    """Join words for a sentence: ``a, b and c``."""
    *others, last = words
    return f"{', '.join(others)} and {last}" if others else last
