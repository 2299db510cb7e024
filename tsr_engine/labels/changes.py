"""Changes of a label set: each gives the next version of the set, and says in one sentence what it did."""

from __future__ import annotations

import json
import re
import unicodedata
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from pydantic import ValidationError

from tsr_engine.errors import InputError
from tsr_engine.labels.model import MOST_LABELS, Label, LabelSet
from tsr_engine.labels.wording import comparable, first_problem

__all__ = [
    "UPDATABLE",
    "ChangeError",
    "Changed",
    "NoLabelError",
    "TakenError",
    "add_label",
    "hide_label",
    "key_of",
    "merge_labels",
    "next_version",
    "require_free",
    "set_picture",
    "show_label",
    "undo_change",
    "update_label",
]

UPDATABLE: Final = (
    "name",
    "short",
    "aliases",
    "shape",
    "category",
    "attributes",
    "teach",
    "colour",
    "size_mm",
    "mirror",
    "pinned",
)
"""Fields that :func:`update_label` changes."""
_MOST_OF_KEY = 80
_NO_WORD = re.compile(r"[^\w]+|_+")


class ChangeError(InputError):
    """A change that breaks a rule of label sets.

    Attributes:
        field: of the change; None: it is about the whole change.
    """

    def __init__(self, message: str, field: str | None = None) -> None:
        super().__init__(message)
        self.field = field


class NoLabelError(ChangeError):
    """The change is about a label that the set does not have."""


class TakenError(ChangeError):
    """Another label has the key, the name, the alias or the digit already.

    Attributes:
        label: that label.
    """

    def __init__(self, message: str, field: str, label: Label) -> None:
        super().__init__(message, field)
        self.label = label


@dataclass(frozen=True, slots=True)
class Changed:
    """What a change gives.

    Attributes:
        labels: the next version; the version that was there where the change changes nothing.
        sentence: what was done, for people.
        label: the label that the change is about, as it is now; None: it is about several, or the label is gone.
    """

    labels: LabelSet
    sentence: str
    label: Label | None = None


def key_of(name: str, taken: Callable[[str], bool] = lambda key: False) -> str:
    """A key made from a name: lower case, letters and digits of any script, hyphens between words.

    Args:
        name: what people read.
        taken: whether a key cannot be used; a number is appended until one can.
    """
    parts = _NO_WORD.split(unicodedata.normalize("NFKC", name).casefold())
    key = "-".join(part for part in parts if part)[:_MOST_OF_KEY].strip("-") or "label"
    number, unique = 1, key
    while taken(unique):
        number += 1
        unique = f"{key}-{number}"
    return unique


def add_label(labels: LabelSet, facts: Mapping[str, Any]) -> Changed:
    """Add one label with the next id.

    Args:
        labels: the newest version.
        facts: fields of :class:`Label` as JSON values, without ``id``; ``key`` is made from the name where it is absent.

    Raises:
        TakenError: another label has the key, the name, an alias or the digit.
        ChangeError: a field is wrong, or the set is full.
    """
    claims = _claims(labels)
    facts = dict(facts)
    if facts.get("key") is None:
        keys = {label.key.casefold() for label in labels}
        # the name itself is checked below; here it must not be in the way of a key made from it
        own = comparable(str(facts.get("name", "")))
        facts["key"] = key_of(
            str(facts.get("name", "")),
            lambda key: key.casefold() in keys or (comparable(key) in claims and comparable(key) != own),
        )
        _require_unclaimed(claims, str(facts.get("name", "")), "name")
    label = _label({**facts, "id": labels.next_id})
    require_free(labels, label, claims)
    _require_mirror(labels, label)
    added = next_version(labels, (*labels.labels, label), labels.next_id + 1)
    return Changed(added, f"Added '{label.name}'.", label)


def update_label(labels: LabelSet, label_id: int, facts: Mapping[str, Any]) -> Changed:
    """Change fields of one label.

    Args:
        labels: the newest version.
        label_id: which label.
        facts: fields of ``UPDATABLE`` as JSON values.

    Raises:
        NoLabelError: there is no such label.
        TakenError: another label has the name, an alias or the digit.
        ChangeError: a field is wrong, or the label is merged into another.
    """
    before = _live(labels, label_id)
    wrong = next((name for name in facts if name not in UPDATABLE), None)
    if wrong is not None:
        raise ChangeError(f"The field {wrong!r} of a label cannot be changed.", wrong)
    after = _label({**before.model_dump(mode="json"), **facts})
    if after == before:
        return Changed(labels, f"'{before.name}' stays as it is.", before)
    require_free(labels, after)
    _require_mirror(labels, after)
    return Changed(_replaced(labels, after), _told(before, after), after)


def set_picture(labels: LabelSet, label_id: int, pictogram: str) -> Changed:
    """Give a label another pictogram; see ``Label.pictogram``.

    Raises:
        NoLabelError: there is no such label.
        ChangeError: the label is merged into another.
    """
    before = _live(labels, label_id)
    after = _label({**before.model_dump(mode="json"), "pictogram": pictogram})
    if after == before:
        return Changed(labels, f"'{before.name}' keeps its picture.", before)
    done = "Gave '{}' a picture." if pictogram else "Took the picture of '{}' away."
    return Changed(_replaced(labels, after), done.format(before.name), after)


def merge_labels(labels: LabelSet, label_id: int, into: int) -> Changed:
    """Let one label stand for another from now on; stored tracks are not rewritten.

    Raises:
        NoLabelError: one of them does not exist.
        ChangeError: a label is merged with itself, or is merged already.
    """
    before, target = _live(labels, label_id), _present(labels, into, "into")
    if labels.resolved(into) == label_id:
        way = "" if into == label_id else f": '{target.name}' is merged into it"
        raise ChangeError(f"'{before.name}' cannot be merged into itself{way}.", "into")
    target = _present(labels, labels.resolved(into), "into")
    after = before.model_copy(update={"merged_into": target.id, "pinned": None})
    return Changed(_replaced(labels, after), f"Merged '{before.name}' into '{target.name}'.", after)


def hide_label(labels: LabelSet, label_id: int) -> Changed:
    """Offer a label no more; tracks that have it keep it.

    Raises:
        NoLabelError: there is no such label.
        ChangeError: the label is merged into another.
    """
    before = _live(labels, label_id)
    if before.hidden:
        return Changed(labels, f"'{before.name}' is hidden already.", before)
    after = before.model_copy(update={"hidden": True, "pinned": None})
    return Changed(_replaced(labels, after), f"Hid '{before.name}'.", after)


def show_label(labels: LabelSet, label_id: int) -> Changed:
    """Offer a hidden label again.

    Raises:
        NoLabelError: there is no such label.
        ChangeError: the label is merged into another.
    """
    before = _live(labels, label_id)
    if not before.hidden:
        return Changed(labels, f"'{before.name}' is not hidden.", before)
    after = before.model_copy(update={"hidden": False})
    return Changed(_replaced(labels, after), f"Shows '{before.name}' again.", after)


def undo_change(
    labels: LabelSet, before: LabelSet, after: LabelSet, sentence: str, used: Callable[[int], bool]
) -> Changed:
    """Take the change between two versions back; what was changed in other labels since then stays.

    A label that the change had added goes, unless something uses it: then it is hidden. Its id is not given out again.

    Args:
        labels: the newest version.
        before: the version before the change.
        after: the version that the change made.
        sentence: what the change says of itself.
        used: whether something that is stored names a label by its id.

    Raises:
        TakenError: a word that the undo brings back belongs to another label by now.
        ChangeError: a later version has changed the same.
    """
    was, made = ({label.id: label for label in version} for version in (before, after))
    now = {label.id: label for label in labels}
    present_before = dict(now)
    kept: list[str] = []
    for label_id in [*made, *(label_id for label_id in was if label_id not in made)]:
        old, new, present = was.get(label_id), made.get(label_id), now.get(label_id)
        if old == new:
            continue
        if old is None or new is None:
            if present != new:
                raise _changed_since(present or new or old, after.version)
            if old is not None:
                now[label_id] = old
            elif used(label_id) or any(other.merged_into == label_id for other in labels):
                assert new is not None
                now[label_id] = new.model_copy(update={"hidden": True, "pinned": None})
                kept.append(new.name)
            else:
                del now[label_id]
        elif present is None:
            raise _changed_since(new, after.version)
        else:
            now[label_id] = _restored(present, old, new, after.version)
    for label in now.values():
        if label is not present_before.get(label.id) and label.merged_into is None:
            require_free(
                labels, label, _claims_of(other for other in now.values() if other.id != label.id), now.values()
            )
    said = f"Took back version {after.version}: {sentence}"
    if kept:
        said += f" Tracks use {_listed(kept)}: hidden, not removed."
    restored = next_version(labels, tuple(now.values()), labels.next_id)
    if restored.labels == labels.labels:
        return Changed(labels, f"Version {after.version} is taken back already.")
    return Changed(restored, said)


def next_version(labels: LabelSet, content: tuple[Label, ...], next_id: int) -> LabelSet:
    """The version after ``labels`` with other content.

    Raises:
        ChangeError: the content breaks a rule of label sets.
    """
    if len(content) > MOST_LABELS:
        raise ChangeError(f"The set would have {len(content)} labels; {MOST_LABELS} are the most.")
    try:
        return LabelSet(key=labels.key, name=labels.name, version=labels.version + 1, next_id=next_id, labels=content)
    except ValidationError as error:
        raise ChangeError(f"{_sentence(first_problem(error)[1])}.") from None


def require_free(
    labels: LabelSet, label: Label, claims: Mapping[str, Label] | None = None, others: Iterable[Label] | None = None
) -> None:
    """Refuse a label whose words or digit another label has.

    Args:
        labels: the set.
        label: new, or one of the set as it shall be.
        claims: of the other labels, where they are known: comparable word -> label.
        others: all labels, where they are not those of the set.

    Raises:
        TakenError: says which label has what.
    """
    claims = _claims(labels, without=label.id) if claims is None else claims
    everything = labels.labels if others is None else list(others)
    same_key = next(
        (other for other in everything if other.id != label.id and other.key.casefold() == label.key.casefold()), None
    )
    if same_key is not None:
        raise _taken(label.key, "key", same_key)
    for word, field in (
        (label.key, "key"),
        (label.name, "name"),
        *((alias, "aliases") for alias in label.aliases),
    ):
        _require_unclaimed(claims, word, field)
    if label.pinned is not None:
        for other in everything:
            if other.pinned == label.pinned and other.id != label.id:
                raise TakenError(
                    f"The digit {label.pinned} is that of '{other.name}' (label {other.id}). Take it off there first.",
                    "pinned",
                    other,
                )


def _claims(labels: LabelSet, without: int | None = None) -> dict[str, Label]:
    return _claims_of(label for label in labels if label.id != without)


def _claims_of(labels: Iterable[Label]) -> dict[str, Label]:
    """Which label a word belongs to; words of merged labels are free."""
    claims: dict[str, Label] = {}
    for label in labels:
        if label.merged_into is None:
            for word in (label.key, label.name, *label.aliases):
                claims.setdefault(comparable(word), label)
    return claims


def _require_unclaimed(claims: Mapping[str, Label], word: str, field: str) -> None:
    other = claims.get(comparable(word))
    if other is not None:
        raise _taken(word, field, other)


def _taken(word: str, field: str, other: Label) -> TakenError:
    state = "merged into another" if other.merged_into is not None else "hidden" if other.hidden else ""
    also = f", {state}" if state else ""
    what = {"key": "key", "name": "name", "aliases": "alias"}[field]
    return TakenError(
        f"The {what} '{word}' belongs to '{other.name}' (label {other.id}, key {other.key}{also}).", field, other
    )


def _require_mirror(labels: LabelSet, label: Label) -> None:
    if label.mirror is not None and label.mirror != label.key and labels.by_key(label.mirror) is None:
        raise ChangeError(
            f"The mirror image of '{label.name}' is {label.mirror!r}, which is no key of the set.", "mirror"
        )


def _present(labels: LabelSet, label_id: int, field: str = "id") -> Label:
    found = labels.get(label_id)
    if found is None:
        raise NoLabelError(f"The set '{labels.name}' has no label {label_id}.", field)
    return found


def _live(labels: LabelSet, label_id: int) -> Label:
    """A label that can be changed."""
    found = _present(labels, label_id)
    if found.merged_into is not None:
        target = _present(labels, labels.resolved(label_id))
        raise ChangeError(
            f"'{found.name}' is merged into '{target.name}' (label {target.id}). Change that one, or undo the merge.",
            "id",
        )
    return found


def _label(facts: Mapping[str, Any]) -> Label:
    try:
        return Label.model_validate_json(json.dumps(facts))
    except ValidationError as error:
        place, problem = first_problem(error)
        field = place.partition(".")[0] or None
        raise ChangeError(f"{_sentence(f'{place}: {problem}' if place else problem)}.", field) from None


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:].rstrip(".")


def _replaced(labels: LabelSet, label: Label) -> LabelSet:
    content = tuple(label if other.id == label.id else other for other in labels)
    return next_version(labels, content, labels.next_id)


def _told(before: Label, after: Label) -> str:
    changed = [name for name in UPDATABLE if getattr(before, name) != getattr(after, name)]
    if changed == ["name"]:
        return f"Renamed '{before.name}' to '{after.name}'."
    words = _listed([{"size_mm": "size", "pinned": "digit"}.get(name, name) for name in changed])
    now = f", now '{after.name}'" if "name" in changed else ""
    return f"Changed {words} of '{before.name}'{now}."


def _listed(words: Collection[str]) -> str:
    *most, last = words
    return f"{', '.join(most)} and {last}" if most else last


def _restored(now: Label, old: Label, new: Label, version: int) -> Label:
    """A label of now with the fields of ``old`` that ``new`` had changed."""
    back: dict[str, Any] = {}
    for name in Label.model_fields:
        was, became = getattr(old, name), getattr(new, name)
        if was != became:
            if getattr(now, name) not in (was, became):
                raise _changed_since(now, version)
            back[name] = was
    return now.model_copy(update=back)


def _changed_since(label: Label | None, version: int) -> ChangeError:
    name = "a label" if label is None else f"'{label.name}'"
    return ChangeError(
        f"Version {version} cannot be taken back: a later version has changed {name} again. Undo that one first.",
        "version",
    )
