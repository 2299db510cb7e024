"""Imports labels of a file into a set of the library, or as a new set."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.errors import Invalid, NotFound
from app.labels.pictures import is_there
from app.labels.service import LabelService
from app.labels.store import newest, start
from app.labels.views import Brought, KnownLabel, RefusedLabel, label_view
from tsr_engine.exchange.label_files.label_collector import FileLabels
from tsr_engine.labels.adopting import Adopted, adopt_labels
from tsr_engine.labels.changes import Changed
from tsr_engine.labels.model import LabelSet
from tsr_engine.plural import plural

__all__ = ["bring_labels"]


def bring_labels(
    service: LabelService, key: str, author: str, found: FileLabels, *, create: bool = False, file: str = ""
) -> Brought:
    """Add the labels of a file that a set lacks.

    Args:
        service: of the library.
        key: key of the set.
        author: author of the change.
        found: contents of the file.
        create: make the set from the file if no set has that key; it then has the ids of the file.
        file: file name, for the history.

    Raises:
        NotFound: no such set.
        Invalid: the set would become too large, or the file has no usable label.
    """
    if not len(found.labels):
        raise Invalid(f"No label of the file can be used: {found.refused[0].reason}", field="body")
    reported = list(found.reported)
    adopted: Adopted | None = None

    def make(session: Session, labels: LabelSet) -> Changed:
        nonlocal adopted
        adopted = adopt_labels(labels, _with_pictures_here(session, found.labels, reported))
        return adopted.changed

    def first(session: Session) -> LabelSet | None:
        """The set of the file; None: a set with that key exists."""
        try:
            newest(session, key)
        except NotFound:
            content = _with_pictures_here(session, found.labels, reported)
            made = content.model_copy(update={"key": key, "version": 1})
            start(session, made, author, f"Made from {file}." if file else "Made from a file.")
            return made
        return None

    made = service.begin(key, first) if create else None
    refused = [RefusedLabel(name=each.name, reason=each.reason) for each in found.refused]
    if made is not None:
        views = [label_view(made, label) for label in made]
        sentence = f"Made the set '{made.name}' (key {made.key}) with {plural(len(made), 'label')}."
        return Brought(
            version=1, sentence=sentence, created=True, added=views, known=[], refused=refused, reported=_once(reported)
        )
    labels, changed = service.write(key, author, make)
    assert adopted is not None
    names = {label.key: label.name for label in found.labels}
    known = [KnownLabel(name=names[theirs], id=ours.id, key=ours.key) for theirs, ours in adopted.known.items()]
    return Brought(
        version=labels.version,
        sentence=changed.sentence,
        created=False,
        added=[label_view(labels, label) for label in adopted.added],
        known=known,
        refused=refused,
        reported=_once(reported),
    )


def _with_pictures_here(session: Session, labels: LabelSet, reported: list[str]) -> LabelSet:
    """The set without pictures that the library lacks, because a file names pictures but does not contain them."""
    content = []
    for label in labels:
        if is_there(session, label.pictogram):
            content.append(label)
        else:
            reported.append(
                f"The picture of '{label.name}' was left out: the file does not contain it, and the library lacks it."
            )
            content.append(label.model_copy(update={"pictogram": ""}))
    return labels.model_copy(update={"labels": tuple(content)})


def _once(sentences: list[str]) -> list[str]:
    """Sentences without repetitions from a second attempt."""
    return list(dict.fromkeys(sentences))
