"""Imports labels of a file into a set of the library, or as a new set."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.errors import Invalid, NotFound
from app.labels.pictures import picture_exists
from app.labels.service import LabelService
from app.labels.store import newest, start
from app.labels.views import Brought, KnownLabel, RefusedLabel, label_view
from tsr_engine.exchange.label_files.label_collector import FileLabels
from tsr_engine.labels.adopting import Adopted, adopt_labels
from tsr_engine.labels.changes import Changed
from tsr_engine.labels.model import LabelSet
from tsr_engine.plural import plural


def import_file_labels(
    service: LabelService, key: str, author: str, content: FileLabels, *, create: bool = False, file: str = ""
) -> Brought:
    """Add the labels of a file that a set lacks.

    Args:
        service: of the library.
        key: key of the set.
        author: author of the change.
        content: contents of the file.
        create: make the set from the file if no set has that key; it then has the ids of the file.
        file: file name, for the history.

    Raises:
        NotFound: no such set.
        Invalid: the set would become too large, or the file has no usable label.
    """
    if not len(content.labels):
        raise Invalid(f"No label of the file can be used: {content.refused[0].reason}", field="body")
    reported = list(content.reported)
    adopted: Adopted | None = None

    def adopt(session: Session, labels: LabelSet) -> Changed:
        nonlocal adopted
        adopted = adopt_labels(labels, _without_missing_pictures(session, content.labels, reported))
        return adopted.changed

    def create_set(session: Session) -> LabelSet | None:
        """The set of the file; None: a set with that key exists."""
        try:
            newest(session, key)
        except NotFound:
            labels = _without_missing_pictures(session, content.labels, reported)
            created = labels.model_copy(update={"key": key, "version": 1})
            start(session, created, author, f"Made from {file}." if file else "Made from a file.")
            return created
        return None

    created = service.create(key, create_set) if create else None
    refused = [RefusedLabel(name=each.name, reason=each.reason) for each in content.refused]
    known: list[KnownLabel] = []
    if created is not None:
        labels, added = created, created.labels
        sentence = f"Made the set '{created.name}' (key {created.key}) with {plural(len(created), 'label')}."
    else:
        labels, changed = service.write(key, author, adopt)
        assert adopted is not None
        names = {label.key: label.name for label in content.labels}
        known = [KnownLabel(name=names[theirs], id=ours.id, key=ours.key) for theirs, ours in adopted.known.items()]
        added, sentence = tuple(adopted.added), changed.sentence
    return Brought(
        version=labels.version,
        sentence=sentence,
        created=created is not None,
        added=[label_view(labels, label) for label in added],
        known=known,
        refused=refused,
        reported=list(dict.fromkeys(reported)),  # a second attempt repeats sentences
    )


def _without_missing_pictures(session: Session, labels: LabelSet, reported: list[str]) -> LabelSet:
    """The set without pictures that the library lacks, because a file names pictures but does not contain them."""
    kept = []
    for label in labels:
        if picture_exists(session, label.pictogram):
            kept.append(label)
        else:
            reported.append(
                f"The picture of '{label.name}' was left out: the file does not contain it, and the library lacks it."
            )
            kept.append(label.model_copy(update={"pictogram": ""}))
    return labels.model_copy(update={"labels": tuple(kept)})
