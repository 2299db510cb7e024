"""Undoes a change of a label set without touching later ones."""

from __future__ import annotations

from collections.abc import Callable

from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.changes import Changed, join_words, next_version
from tsr_engine.labels.conflicts import ChangeError, require_free
from tsr_engine.labels.model import Label, LabelSet


def undo_change(
    labels: LabelSet, before: LabelSet, after: LabelSet, sentence: str, used: Callable[[int], bool]
) -> Changed:
    """Undo the change between two versions; later changes of other labels stay.

    A label that the change added is removed, or hidden if it is used. Its id is not used again.

    Args:
        labels: the newest version.
        before: the version before the change.
        after: the version after the change.
        sentence: the sentence about the change.
        used: whether stored data names a label by its id.

    Raises:
        TakenError: a word that the undo restores belongs to another label by now.
        ChangeError: a later version has changed the same label.
    """
    old_labels, new_labels = ({label.id: label for label in version} for version in (before, after))
    current = {label.id: label for label in labels}
    present_before = dict(current)
    hidden: list[str] = []
    for label_id in {**new_labels, **old_labels}:
        old, new, present = old_labels.get(label_id), new_labels.get(label_id), current.get(label_id)
        if old == new:
            continue
        if new is None:  # the change had removed the label
            assert old is not None
            if present is not None:
                raise _changed_since(present, after.version)
            current[label_id] = old
        elif present is None:
            raise _changed_since(new, after.version)
        elif old is not None:
            current[label_id] = _restored(present, old, new, after.version)
        elif present != new:
            raise _changed_since(present, after.version)
        elif used(label_id) or any(other.merged_into == label_id for other in labels):
            current[label_id] = new.model_copy(update={"hidden": True, "pinned": None})
            hidden.append(new.name)
        else:
            del current[label_id]
    for label in current.values():
        if label is not present_before.get(label.id) and label.merged_into is None:
            require_free(label, current.values())
    sentence_of_undo = f"Took back version {after.version}: {sentence}"
    if hidden:
        sentence_of_undo += f" Tracks may use {join_words(hidden)}: hidden, not removed."
    restored = next_version(labels, tuple(current.values()), labels.next_id)
    if restored.labels == labels.labels:
        return Changed(labels, f"Version {after.version} is taken back already.")
    return Changed(restored, sentence_of_undo)


def _restored(current: Label, old: Label, new: Label, version: int) -> Label:
    """The current label with the fields of ``old`` that ``new`` had changed."""
    restored: JsonObject = {}
    for name in Label.model_fields:
        old_value, new_value = getattr(old, name), getattr(new, name)
        if old_value != new_value:
            if getattr(current, name) not in (old_value, new_value):
                raise _changed_since(current, version)
            restored[name] = old_value
    return current.model_copy(update=restored)


def _changed_since(label: Label, version: int) -> ChangeError:
    message = f"Version {version} cannot be taken back: a later version has changed '{label.name}' again."
    return ChangeError(f"{message} Undo that one first.", "version")
