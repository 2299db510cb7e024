"""What an import brings into the label set of its video, and what people have said about names in files."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.labels.service import LabelService
from app.storage.models import LabelWord
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.labels import LabelMatcher
from tsr_engine.exchange.relabel import relabelled
from tsr_engine.labels.changes import Changed, listed, next_version
from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import Label, LabelSet

__all__ = ["keep_words", "store_labels", "words_of"]

_LONGEST: Final = 200
_NAMED: Final = 6
"""New labels in the sentence of a version."""
_NUMBER = re.compile(r"[\d\s.+-]*")


def words_of(session: Session, labels: LabelSet) -> dict[str, int]:
    """Names in files and the ids that people have said they stand for, -1: no label of the set."""
    rows = session.execute(select(LabelWord.word, LabelWord.label_id).where(LabelWord.set_key == labels.key))
    known = {label.id for label in labels} | {-1}
    return {word: labels.resolved(label_id) for word, label_id in rows if label_id in known}


def keep_words(session: Session, labels: LabelSet, said: Mapping[str, int | str], author: str) -> None:
    """Remember what a person has said about names. Numbers are not kept: each file counts its own way."""
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


def store_labels(
    service: LabelService, before: LabelSet, read: LabelSet, tracks: Sequence[Track], author: str, file: str
) -> list[Track]:
    """Store the labels and attributes that a file has added, on the newest version of the set.

    Args:
        service: writes.
        before: the set that the file was read onto.
        read: the same with what the file adds.
        tracks: with the numbers of ``read``.
        author: who imports.
        file: its name, for the history of the set.

    Returns:
        The tracks with the numbers that the new labels have got: somebody may have added others meanwhile.
    """
    known = {label.id: label for label in before}
    new = [label for label in read if label.id not in known]
    changed = [label for label in read if label.id in known and label.attributes != known[label.id].attributes]
    if not new and not changed:
        return list(tracks)
    numbers: dict[int, int] = {}

    def make(_: Session, newest: LabelSet) -> Changed:
        numbers.clear()
        content = {label.id: label for label in newest}
        for label in changed:
            content[label.id] = _with_attributes(content[label.id], label)
        finder, free = LabelFinder(newest), newest.next_id
        for label in new:
            match = finder.find(label.name)
            if match is not None and match.how != "number":
                numbers[label.id] = match.label.id
                content[match.label.id] = _with_attributes(content[match.label.id], label)
            else:
                numbers[label.id], content[free] = free, label.model_copy(update={"id": free})
                free += 1
        every = tuple(content.values())
        if every == newest.labels:
            return Changed(newest, "")
        return Changed(next_version(newest, every, free), _sentence(new, changed, file))

    service.write(before.key, author, make)
    return [relabelled(track, numbers) for track in tracks]


def _with_attributes(label: Label, other: Label) -> Label:
    """A label with the attributes, and values of them, that another one has more."""
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
            parts.append(f"{verb} {listed(names)}")
    return f"{'; '.join(parts)} from {file[:120]}."
