"""Corrections and ground truth of a run as rows for a recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session, undefer

from app.compare.annotation import corrected_boxes
from app.compare.figures import FIRST_UNKNOWN_LABEL
from app.edits.documents import TrackDoc
from app.edits.track_name import track_name
from app.evidence.run_columns import confirmed_boxes, labelled_boxes
from app.storage.ground_truth_rows import unpack
from app.storage.models import GroundTruth
from tsr_engine.evaluation.track_tables import truth_table
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.labels.classes import RunClasses, resolved_labels
from tsr_engine.labels.model import LabelSet
from tsr_engine.recording import BoxRows


def corrected_rows(evidence: Path, documents: Mapping[str, TrackDoc], classes: RunClasses) -> BoxRows | None:
    """The corrected boxes in the frames that the run has stored; None: there are no corrections.

    Args:
        evidence: folder of the run.
        documents: documents of its touched tracks, by key.
        classes: maps its class numbers to the video's label set.
    """
    if not documents:
        return None

    with EvidenceReader(evidence) as reader:
        last = reader.last_frame
        strange: dict[str, int] = {}
        machine = confirmed_boxes(reader)
    found = labelled_boxes(machine, classes, lambda word: strange.setdefault(word, FIRST_UNKNOWN_LABEL - len(strange)))
    table = corrected_boxes(found, documents, 0 if last is None else last + 1)
    labels_at = resolved_labels(table.class_id, classes.labels)
    names = _shorts(classes.labels) | {number: word[:12] for word, number in strange.items()}
    docs = {key: documents.get(key) for key in table.names}
    labels = tuple(
        f"{track_name(key, docs[key])} {names.get(label, '?')}{_review(docs[key])}"
        for key, label in zip((table.names[k] for k in table.track.tolist()), labels_at.tolist(), strict=True)
    )
    return BoxRows(replace(table, class_id=labels_at), labels)


def truth_of(session: Session, video_id: str, truth_id: str | None, labels: LabelSet) -> BoxRows | None:
    """The requested ground truth of a video; unset: the video's only one, if there is exactly one."""
    query = select(GroundTruth).where(GroundTruth.video_id == video_id).options(undefer(GroundTruth.boxes))
    if truth_id is not None:
        query = query.where(GroundTruth.id == truth_id)
    ground_truths = session.scalars(query).all()
    return ground_truth_rows(ground_truths[0].boxes, labels) if len(ground_truths) == 1 else None


def ground_truth_rows(packed: bytes, labels: LabelSet) -> BoxRows:
    """Convert stored ground truth to rows with labels of a set."""
    table = truth_table(unpack(packed))
    ids, names = resolved_labels(table.class_id, labels), _shorts(labels)
    texts = tuple(
        f"t{track} {names.get(label, '?')}{' (ignored)' if ignore else ''}"
        for track, label, ignore in zip(table.track.tolist(), ids.tolist(), table.ignore.tolist(), strict=True)
    )
    return BoxRows(replace(table, class_id=ids), texts)


def _shorts(labels: LabelSet) -> dict[int, str]:
    return {label.id: label.shown_short for label in labels}


def _review(document: TrackDoc | None) -> str:
    if document is None:
        return ""
    review = "" if document.review == "open" else f" [{document.review.replace('_', ' ')}]"
    return f"{review} (ignored)" if document.ignore else review
