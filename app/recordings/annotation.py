"""Corrections and ground truth of a run as the plain rows that a recording takes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session, undefer

from app.compare.annotation import corrected_boxes
from app.edits.documents import TrackDoc
from app.edits.track_name import track_name
from app.evidence.tables import confirmed_boxes
from app.storage.models import Truth
from app.truths.rows import unpack
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.recognition.catalogue import CATALOGUE

if TYPE_CHECKING:
    from tsr_engine.recording import BoxRows

__all__ = ["corrected_rows", "truth_of", "truth_rows"]


def corrected_rows(evidence: Path, documents: Mapping[str, TrackDoc]) -> BoxRows | None:
    """The run as people have corrected it, in the frames that it has stored; None: nobody has touched it."""
    if not documents:
        return None
    from tsr_engine.recording import BoxRows

    with EvidenceReader(evidence) as reader:
        last = reader.last_frame
        table = corrected_boxes(confirmed_boxes(reader), documents, 0 if last is None else last + 1)
    docs = {key: documents.get(key) for key in table.keys}
    labels = tuple(
        f"{track_name(key, docs[key])} {_class(label)}{_review(docs[key])}"
        for key, label in zip((table.keys[k] for k in table.track.tolist()), table.class_id.tolist(), strict=True)
    )
    return BoxRows(table.frame, table.boxes, table.class_id, labels)


def truth_of(session: Session, video_id: str, truth_id: str | None) -> BoxRows | None:
    """The ground truth of a video that was asked for; unset: the only one that there is."""
    query = select(Truth).where(Truth.video_id == video_id).options(undefer(Truth.boxes))
    if truth_id is not None:
        query = query.where(Truth.id == truth_id)
    truths = session.scalars(query).all()
    return truth_rows(truths[0].boxes) if len(truths) == 1 else None


def truth_rows(packed: bytes) -> BoxRows:
    """Ground truth as it lies in the database."""
    from tsr_engine.recording import BoxRows

    rows = unpack(packed)
    labels = tuple(f"t{int(row[1])} {_class(int(row[6]))}{' (ignored)' if row[8] else ''}" for row in rows)
    return BoxRows(rows[:, 0].astype(np.int64), np.ascontiguousarray(rows[:, 2:6]), rows[:, 6].astype(np.int64), labels)


def _class(class_id: int) -> str:
    return CATALOGUE[class_id].short if 0 <= class_id < len(CATALOGUE) else "?"


def _review(document: TrackDoc | None) -> str:
    return "" if document is None or document.review == "open" else f" [{document.review.replace('_', ' ')}]"
