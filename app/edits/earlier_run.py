"""Corrections of an earlier run of a video that have not been carried over to a later one."""

from __future__ import annotations

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.body_model import Model
from app.edits.documents import TrackDoc
from app.edits.log_store import documents_of
from app.errors import Busy, Conflict, NotFound
from app.evidence.service import EvidenceService
from app.storage.lookup import require_run
from app.storage.models import Edit, Run
from app.storage.servers import is_local
from tsr_engine.errors import EvidenceError, StorageError


class Earlier(Model):
    """The corrections of an earlier run.

    Attributes:
        run_id: the earlier run.
        tracks: number of corrected tracks in it.
        seq: number of its newest operation, which identifies its state for the page.
    """

    run_id: str
    tracks: int
    seq: int


def earlier_corrections(session: Session, evidence: EvidenceService, run_id: str) -> Earlier | None:
    """Find the newest earlier run of the same video with corrections; None: there is none, or all were carried over.

    A what-if is only a view of its run, and an unfinished run cannot take corrections over: both get None.

    Raises:
        NotFound: no such run.
    """
    run = require_run(session, run_id)
    if run.kind == "whatif" or run.state != "complete":
        return None
    newest = (
        select(Run.id, func.max(Edit.seq))
        .join(Edit, Edit.run_id == Run.id)
        .where(Run.video_id == run.video_id, Run.id != run.id, Run.order < run.order, Run.state == "complete")
        .where(is_local(session, Run.place))
        .group_by(Run.id, Run.order)
        .order_by(Run.order.desc())
    )
    for other, seq in session.execute(newest).all():
        docs = documents_of(session, other).values()
        try:
            tracks = sum(_has_corrections(doc, evidence, other) for doc in docs)
        except (Busy, Conflict, EvidenceError, NotFound, StorageError):
            # its evidence is damaged or missing, or cannot be fetched now: nothing can be carried over, and its page
            # reports that
            continue
        if tracks:
            return None if _was_adopted(session, run.id, other, seq) else Earlier(run_id=other, tracks=tracks, seq=seq)
    return None


def _was_adopted(session: Session, run_id: str, other: str, seq: int) -> bool:
    """Whether corrections were carried over after the newest of them was made."""
    adoption = Edit.kind == "adopt", Edit.command["from_run"].as_string() == other
    last = session.scalar(select(func.max(Edit.seq)).where(Edit.run_id == run_id, *adoption))
    return last is not None and last > seq


def _has_corrections(doc: TrackDoc, evidence: EvidenceService, run_id: str) -> bool:
    """Whether a track differs from the engine's; tracks drawn and deleted again, or merged away, do not count."""
    if doc.merged_into is not None or (doc.gone and not doc.key.startswith("m")):
        return False
    span = evidence.span(run_id, int(doc.key[1:])) if doc.key.startswith("m") else None
    return not doc.untouched(span)
