"""Documents of tracks as they lie in the database."""

from __future__ import annotations

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.edits.documents import TrackDoc
from app.storage.models import TrackDocument

__all__ = ["doc_of", "documents_of"]


def doc_of(row: TrackDocument) -> TrackDoc:
    """The document of one row."""
    return TrackDoc.model_validate({**row.document, "revision": row.revision})


def documents_of(session: Session, run_id: str) -> dict[str, TrackDoc]:
    """What people have said about the tracks of a run, by key."""
    return {
        row.key: doc_of(row) for row in session.scalars(select(TrackDocument).where(TrackDocument.run_id == run_id))
    }
