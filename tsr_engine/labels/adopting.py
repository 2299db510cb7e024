"""Adds the labels that a set lacks from another set or file, with new ids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tsr_engine.labels.changes import Changed, next_version
from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import Label, LabelSet
from tsr_engine.labels.name_matching import comparable
from tsr_engine.plural import plural


@dataclass(frozen=True, slots=True)
class Adopted:
    """The result of adding another set.

    Attributes:
        changed: the next version, and the sentence about it.
        added: the new labels.
        known: key in the other set -> the label in this set.
    """

    changed: Changed
    added: Sequence[Label]
    known: dict[str, Label]


def adopt_labels(labels: LabelSet, other: LabelSet) -> Adopted:
    """Add the labels of another set that a set lacks; labels are matched by key, else by name, else by an alias.

    Labels that are merged in the other set are added as merged, so that their words still find their targets. A digit
    that another label has here is dropped.

    Args:
        labels: the newest version.
        other: the other set.

    Raises:
        ChangeError: the set would become too large.
    """
    finder = LabelFinder(labels)
    adopted: dict[int, Label] = {}
    by_key: dict[str, Label] = {}
    new_labels: list[Label] = []
    digits = {label.pinned for label in labels}
    for label in sorted(other, key=lambda each: each.merged_into is not None):
        found = _find_known(finder, label) or (None if label.merged_into is None else _find_among(new_labels, label))
        if found is not None:
            adopted[label.id] = by_key[label.key] = found
            continue
        into = None if label.merged_into is None else adopted[other.resolved(label.id)].id
        pinned = None if label.pinned in digits else label.pinned
        added = label.model_copy(update={"id": labels.next_id + len(new_labels), "merged_into": into, "pinned": pinned})
        adopted[label.id] = added
        new_labels.append(added)
    added_labels = [_with_mirror(label, other, adopted) for label in new_labels]
    if not added_labels:
        return Adopted(Changed(labels, f"All labels of '{other.name}' are here already."), (), by_key)
    content = (*labels.labels, *added_labels)
    changed = next_version(labels, content, labels.next_id + len(added_labels))
    sentence = f"Added {plural(len(added_labels), 'label')} of '{other.name}'."
    return Adopted(Changed(changed, sentence), added_labels, by_key)


def _find_known(finder: LabelFinder, label: Label) -> Label | None:
    for word in label.words:
        match = finder.named(word)
        if match is not None and match.how != "short":
            return match.label
    return None


def _find_among(new_labels: Sequence[Label], label: Label) -> Label | None:
    """A newly added label with a word of a merged one."""
    wanted = set(map(comparable, label.words))
    return next((each for each in new_labels if not wanted.isdisjoint(map(comparable, each.words))), None)


def _with_mirror(label: Label, other: LabelSet, adopted: dict[int, Label]) -> Label:
    """The label with its mirror image's key in this set."""
    if label.mirror is None:
        return label
    mirrored = other.by_key(label.mirror)
    key = None if mirrored is None else adopted[mirrored.id].key
    return label if key == label.mirror else label.model_copy(update={"mirror": key})
