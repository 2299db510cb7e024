"""Adds new labels of an import to the label set of its video, and remembers people's mappings of names."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from sqlalchemy import select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from app.errors import Conflict
from app.events import EventBus
from app.labels.store import append, labels_of_video
from app.storage.models import LabelWord
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.labels import LabelMatcher
from tsr_engine.exchange.relabel import relabel_track
from tsr_engine.labels.changes import Changed, join_words, next_version
from tsr_engine.labels.conflicts import ChangeError
from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import Label, LabelSet

_MAX_NAME_LENGTH: Final = 200
_MAX_LISTED_LABELS: Final = 6
"""Maximum number of new labels in the sentence of a version."""
_NUMBER = re.compile(r"[\d\s.+-]*")


def remembered_names(session: Session, labels: LabelSet) -> dict[str, int]:
    """Remembered mappings of names in files to label ids; -1: no label of the set."""
    rows = session.execute(select(LabelWord.word, LabelWord.label_id).where(LabelWord.set_key == labels.key))
    known = {label.id for label in labels} | {-1}
    return {name: labels.resolved(label_id) for name, label_id in rows if label_id in known}


def remember_names(session: Session, labels: LabelSet, mappings: Mapping[str, int | str], author: str) -> None:
    """Remember a person's mappings of names. Numbers are not kept, because their meaning differs from file to file."""
    matcher = LabelMatcher(labels, mappings)
    for name in mappings:
        label_id = matcher(name)
        if label_id is None or len(name) > _MAX_NAME_LENGTH or _NUMBER.fullmatch(name):
            continue
        row = session.get(LabelWord, (labels.key, name))
        if row is None:
            session.add(LabelWord(set_key=labels.key, word=name, label_id=label_id, author=author))
        elif row.label_id != label_id:
            row.label_id, row.author = label_id, author


class LabelSetChanged(Exception):
    """The label set has changed since an import was fitted to it, so the import must be fitted again."""


@dataclass(frozen=True, slots=True)
class FittedTracks:
    """Tracks with the label ids of one version of their video's set, and the labels that they add to it.

    Attributes:
        tracks: the tracks.
        newest: the version that they were fitted to.
        changed: the version after it; None: they add nothing.
    """

    tracks: list[Track]
    newest: LabelSet
    changed: Changed | None

    def store(self, session: Session, events: EventBus, video_id: str, author: str) -> None:
        """Store the added labels in the transaction that stores the tracks.

        Raises:
            LabelSetChanged: the set has a newer version.
            Conflict: the video now uses another set.
            NotFound: the video was removed.
        """
        current = labels_of_video(session, video_id)
        if current.key != self.newest.key:
            raise Conflict(
                f"The video now uses the label set '{current.name}', but the file was read with '{self.newest.name}'. "
                "Import the file again.",
                code="other_label_set",
            )
        if current.version != self.newest.version:
            raise LabelSetChanged
        if self.changed is None:
            return
        try:
            append(session, current, self.changed, author)
        except IntegrityError:
            raise LabelSetChanged from None
        events.publish(session, "labels", current.key, {"version": self.changed.labels.version})


def fit_tracks(newest: LabelSet, before: LabelSet, read: LabelSet, tracks: Sequence[Track], file: str) -> FittedTracks:
    """Fit tracks to the newest version of their video's set, which others may have changed meanwhile.

    Args:
        newest: the newest version.
        before: the set with which the file was read.
        read: ``before`` with the labels that the file adds.
        tracks: with label ids of ``read``.
        file: file name, for the history of the set.

    Raises:
        Conflict: a label of the tracks was removed from the set, or labels of the file are incompatible with it.
    """
    known = {label.id: label for label in before}
    new = [label for label in read if label.id not in known]
    changed = [label for label in read if label.id in known and label.attributes != known[label.id].attributes]
    content = {label.id: label for label in newest}
    used = {each.label for each in tracks}.union(*(each.labels.tolist() for each in tracks if each.labels is not None))
    for removed in sorted(used & known.keys() - content.keys()):
        raise Conflict(
            f"The label '{known[removed].name}' was removed from '{newest.name}' while the file was read. Import "
            "it again.",
            code="other_label_set",
        )
    if not new and not changed:
        return FittedTracks(list(tracks), newest, None)
    new_ids: dict[int, int] = {}
    for label in changed:
        if label.id in content:
            content[label.id] = _with_attributes(content[label.id], label)
    finder, next_id = LabelFinder(newest), newest.next_id
    for label in new:
        match = finder.named(label.name)
        if match is not None:
            new_ids[label.id] = match.label.id
            content[match.label.id] = _with_attributes(content[match.label.id], label)
        else:
            new_ids[label.id], content[next_id] = next_id, label.model_copy(update={"id": next_id})
            next_id += 1
    all_labels = tuple(content.values())
    renumbered = [relabel_track(track, new_ids) for track in tracks]
    if all_labels == newest.labels:
        return FittedTracks(renumbered, newest, None)
    try:
        labels = next_version(newest, all_labels, next_id)
    except ChangeError as error:
        raise Conflict(f"{file}: its labels are incompatible with '{newest.name}'. {error}", code="taken") from None
    return FittedTracks(renumbered, newest, Changed(labels, _describe(new, changed, file)))


def _with_attributes(label: Label, other: Label) -> Label:
    """A label with the attributes, and their values, that only another label has."""
    merged = {each.name: each for each in label.attributes}
    for each in other.attributes:
        existing = merged.get(each.name)
        if existing is None:
            merged[each.name] = each
        elif existing.kind == each.kind == "select":
            values = tuple(dict.fromkeys((*existing.values, *each.values)))
            merged[each.name] = existing.model_copy(update={"values": values})
    return label.model_copy(update={"attributes": tuple(merged.values())})


def _describe(new: Sequence[Label], changed: Sequence[Label], file: str) -> str:
    parts = []
    for verb, labels in (("Added", new), ("Added attributes to", changed)):
        names = [f"'{label.name}'" for label in labels[:_MAX_LISTED_LABELS]]
        if len(labels) > _MAX_LISTED_LABELS:
            names.append(f"{len(labels) - _MAX_LISTED_LABELS} more")
        if names:
            parts.append(f"{verb} {join_words(names)}")
    return f"{'; '.join(parts)} from {file[:120]}."
