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
from tsr_engine.exchange.relabel import relabelled
from tsr_engine.labels.changes import Changed, join_words, next_version
from tsr_engine.labels.conflicts import ChangeError
from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import Label, LabelSet

__all__ = ["Fitted", "Overtaken", "fitted", "keep_words", "words_of"]

_LONGEST: Final = 200
_NAMED: Final = 6
"""Maximum number of new labels in the sentence of a version."""
_NUMBER = re.compile(r"[\d\s.+-]*")


def words_of(session: Session, labels: LabelSet) -> dict[str, int]:
    """Remembered mappings of names in files to label ids; -1: no label of the set."""
    rows = session.execute(select(LabelWord.word, LabelWord.label_id).where(LabelWord.set_key == labels.key))
    known = {label.id for label in labels} | {-1}
    return {word: labels.resolved(label_id) for word, label_id in rows if label_id in known}


def keep_words(session: Session, labels: LabelSet, said: Mapping[str, int | str], author: str) -> None:
    """Remember a person's mappings of names. Numbers are not kept, because their meaning differs from file to file."""
    matcher = LabelMatcher(labels, said)
    for word in said:
        found = matcher(word)
        if found is None or len(word) > _LONGEST or _NUMBER.fullmatch(word):
            continue
        row = session.get(LabelWord, (labels.key, word))
        if row is None:
            session.add(LabelWord(set_key=labels.key, word=word, label_id=found, author=author))
        elif row.label_id != found:
            row.label_id, row.author = found, author


class Overtaken(Exception):
    """The label set has changed since an import was fitted to it, so the import must be fitted again."""


@dataclass(frozen=True, slots=True)
class Fitted:
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
            Overtaken: the set has a newer version.
            Conflict: the video now uses another set.
            NotFound: the video was removed.
        """
        present = labels_of_video(session, video_id)
        if present.key != self.newest.key:
            raise Conflict(
                f"The video now uses the label set '{present.name}', but the file was read with '{self.newest.name}'. "
                "Import the file again.",
                code="other_label_set",
            )
        if present.version != self.newest.version:
            raise Overtaken
        if self.changed is None:
            return
        try:
            append(session, present, self.changed, author)
        except IntegrityError:
            raise Overtaken from None
        events.publish(session, "labels", present.key, {"version": self.changed.labels.version})


def fitted(newest: LabelSet, before: LabelSet, read: LabelSet, tracks: Sequence[Track], file: str) -> Fitted:
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
    for gone in sorted(used & known.keys() - content.keys()):
        raise Conflict(
            f"The label '{known[gone].name}' was removed from '{newest.name}' while the file was read. Import "
            "it again.",
            code="other_label_set",
        )
    if not new and not changed:
        return Fitted(list(tracks), newest, None)
    numbers: dict[int, int] = {}
    for label in changed:
        if label.id in content:
            content[label.id] = _with_attributes(content[label.id], label)
    finder, free = LabelFinder(newest), newest.next_id
    for label in new:
        match = finder.named(label.name)
        if match is not None:
            numbers[label.id] = match.label.id
            content[match.label.id] = _with_attributes(content[match.label.id], label)
        else:
            numbers[label.id], content[free] = free, label.model_copy(update={"id": free})
            free += 1
    every = tuple(content.values())
    moved = [relabelled(track, numbers) for track in tracks]
    if every == newest.labels:
        return Fitted(moved, newest, None)
    try:
        labels = next_version(newest, every, free)
    except ChangeError as error:
        raise Conflict(f"{file}: its labels are incompatible with '{newest.name}'. {error}", code="taken") from None
    return Fitted(moved, newest, Changed(labels, _sentence(new, changed, file)))


def _with_attributes(label: Label, other: Label) -> Label:
    """A label with the attributes, and their values, that only another label has."""
    own = {each.name: each for each in label.attributes}
    for each in other.attributes:
        mine = own.get(each.name)
        if mine is None:
            own[each.name] = each
        elif mine.kind == each.kind == "select":
            values = tuple(dict.fromkeys((*mine.values, *each.values)))
            own[each.name] = mine.model_copy(update={"values": values})
    return label.model_copy(update={"attributes": tuple(own.values())})


def _sentence(new: Sequence[Label], changed: Sequence[Label], file: str) -> str:
    parts = []
    for verb, labels in (("Added", new), ("Added attributes to", changed)):
        names = [f"'{label.name}'" for label in labels[:_NAMED]]
        if len(labels) > _NAMED:
            names.append(f"{len(labels) - _NAMED} more")
        if names:
            parts.append(f"{verb} {join_words(names)}")
    return f"{'; '.join(parts)} from {file[:120]}."
