"""Undoes a change of a label set without touching later ones."""

from __future__ import annotations

from collections.abc import Callable

from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.changes import Changed, listed, next_version
from tsr_engine.labels.model import Label, LabelSet
from tsr_engine.labels.refusals import ChangeError, require_free

__all__ = ["undo_change"]


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
    was, made = ({label.id: label for label in version} for version in (before, after))
    now = {label.id: label for label in labels}
    present_before = dict(now)
    kept: list[str] = []
    for label_id in {**made, **was}:
        old, new, present = was.get(label_id), made.get(label_id), now.get(label_id)
        if old == new:
            continue
        if new is None:  # the change had removed the label
            assert old is not None
            if present is not None:
                raise _changed_since(present, after.version)
            now[label_id] = old
        elif present is None:
            raise _changed_since(new, after.version)
        elif old is not None:
            now[label_id] = _restored(present, old, new, after.version)
        elif present != new:
            raise _changed_since(present, after.version)
        elif used(label_id) or any(other.merged_into == label_id for other in labels):
            now[label_id] = new.model_copy(update={"hidden": True, "pinned": None})
            kept.append(new.name)
        else:
            del now[label_id]
    for label in now.values():
        if label is not present_before.get(label.id) and label.merged_into is None:
            require_free(label, now.values())
    said = f"Took back version {after.version}: {sentence}"
    if kept:
        said += f" Tracks may use {listed(kept)}: hidden, not removed."
    restored = next_version(labels, tuple(now.values()), labels.next_id)
    if restored.labels == labels.labels:
        return Changed(labels, f"Version {after.version} is taken back already.")
    return Changed(restored, said)


def _restored(now: Label, old: Label, new: Label, version: int) -> Label:
    """The current label with the fields of ``old`` that ``new`` had changed."""
    back: JsonObject = {}
    for name in Label.model_fields:
        was, became = getattr(old, name), getattr(new, name)
        if was != became:
            if getattr(now, name) not in (was, became):
                raise _changed_since(now, version)
            back[name] = was
    return now.model_copy(update=back)


def _changed_since(label: Label, version: int) -> ChangeError:
    said = f"Version {version} cannot be taken back: a later version has changed '{label.name}' again."
    return ChangeError(f"{said} Undo that one first.", "version")
