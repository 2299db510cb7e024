"""Documents of a run's tracks as they stand: stored, or those of engine tracks that nobody has touched."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from sqlalchemy import Select, select
from sqlalchemy.orm import Session

from app.edits.documents import OPEN_END, TrackDoc, engine_doc
from app.edits.stored import doc_of
from app.evidence.service import EvidenceService
from app.storage.models import Run, TrackDocument

__all__ = ["PresentDocuments"]

_FEW = 50
"""Documents that are asked for one by one; most are in the session already."""
_AT_ONCE = 500
"""Keys of one query."""


class PresentDocuments:
    """Loads and saves, within a transaction of somebody else."""

    def __init__(self, evidence: EvidenceService) -> None:
        self._evidence = evidence

    def load(self, session: Session, run: Run, keys: Sequence[str], *, change: bool = True) -> dict[str, TrackDoc]:
        """Documents of the tracks that exist; engine tracks that nobody touched get a fresh one.

        Args:
            session: of the transaction.
            run: the run.
            keys: of the tracks that are asked for.
            change: they are going to be saved, so nobody else may until the transaction ends.
        """
        query = _documents(run.id).where(TrackDocument.key.in_(keys))
        rows = session.scalars(query.with_for_update() if change else query).all()
        if change:
            session.info["documents"] = rows  # kept alive, so that save finds them without asking again
        found = {row.key: self.closed(run, doc_of(row)) for row in rows}
        missing = [key for key in keys if key not in found and key.startswith("m")]
        spans = self._evidence.all_spans(run.id) if len(missing) > _FEW else None
        for key in missing:
            fresh = self.fresh(run, key, spans)
            if fresh is not None:
                found[key] = fresh
        return found

    def touched(self, session: Session, run: Run) -> dict[str, TrackDoc]:
        """The documents of all tracks that people have said something of."""
        return {row.key: self.closed(run, doc_of(row)) for row in session.scalars(_documents(run.id))}

    def closed(self, run: Run, doc: TrackDoc) -> TrackDoc:
        """The document with its open pieces ended where their tracks ended, once the run is complete."""
        if run.state != "complete" or all(piece.last < OPEN_END for piece in doc.segments):
            return doc
        pieces = []
        for piece in doc.segments:
            span = self._evidence.span(run.id, piece.track) if piece.last >= OPEN_END else (piece.first, piece.last)
            if span is not None and piece.first <= span[1]:
                pieces.append(piece.model_copy(update={"last": span[1]}))
        return doc.model_copy(update={"segments": tuple(pieces)})

    def fresh(self, run: Run, key: str, spans: Mapping[int, tuple[int, int]] | None = None) -> TrackDoc | None:
        """The untouched document of an engine track; while the run goes on, its end is open. None: there is none.

        Args:
            run: the run.
            key: of the track.
            spans: first and last frame of all engine tracks, where they are known already.
        """
        if not key.startswith("m"):
            return None
        track = int(key[1:])
        span = self._evidence.span(run.id, track) if spans is None else spans.get(track)
        if span is None:
            return None
        return engine_doc(track, span[0], span[1] if run.state == "complete" else OPEN_END)

    @staticmethod
    def save(
        session: Session, run_id: str, before: Mapping[str, TrackDoc | None], after: Mapping[str, TrackDoc]
    ) -> dict[str, TrackDoc]:
        """Store documents with their next revision.

        Args:
            session: of the transaction.
            run_id: the run.
            before: what was there, by key; None: nothing.
            after: what is there from now on, by key.

        Returns:
            ``after`` as it was stored.
        """
        saved = {}
        rows = _stored(session, run_id, list(after)) if len(after) > _FEW else None
        for key, doc in after.items():
            old = before.get(key)
            row = session.get(TrackDocument, (run_id, key)) if rows is None else rows.get(key)
            revision = max(0 if old is None else old.revision, 0 if row is None else row.revision) + 1
            saved[key] = doc.model_copy(update={"revision": revision})
            if row is None:
                row = TrackDocument(run_id=run_id, key=key)
                session.add(row)
            row.revision, row.document = revision, saved[key].model_dump(mode="json")
        return saved


def _stored(session: Session, run_id: str, keys: Sequence[str]) -> dict[str, TrackDocument]:
    """The rows of many documents, in few queries."""
    found = {}
    for start in range(0, len(keys), _AT_ONCE):
        query = _documents(run_id).where(TrackDocument.key.in_(keys[start : start + _AT_ONCE]))
        found.update({row.key: row for row in session.scalars(query)})
    return found


def _documents(run_id: str) -> Select[TrackDocument]:
    return select(TrackDocument).where(TrackDocument.run_id == run_id)
