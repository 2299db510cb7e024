"""Comparing two views of one video."""

from __future__ import annotations

from dataclasses import dataclass

from app.compare.annotation import corrected_boxes
from app.compare.figures import Confusion, Figure, confusion, figures
from app.compare.matching import match
from app.edits.service import EditService
from app.errors import Conflict, Invalid
from app.evidence.service import EvidenceService
from app.evidence.tables import BoxTable
from app.shapes import Model
from app.storage.database import Database
from app.storage.models import Run
from app.truths.service import TruthService

__all__ = ["CompareService", "Comparison", "Side"]

MATCH_IOU = 0.5
"""Least IoU of a match."""
_FAR = 2**62


class SideView(Model):
    """One side, for the heading."""

    name: str
    kind: str
    tracks: int
    boxes: int


class Comparison(Model):
    """The figures of a candidate against a reference, over the frames that both have."""

    video_id: str
    reference: str
    candidate: str
    sides: dict[str, SideView]
    """``reference`` and ``candidate``."""
    first: int
    last: int
    figures: dict[str, Figure]
    confusion: Confusion


@dataclass(frozen=True, slots=True)
class Side:
    """One view of a video."""

    kind: str
    video_id: str
    name: str
    boxes: BoxTable
    first: int
    last: int


class CompareService:
    """Loads two sides and measures one against the other."""

    def __init__(self, database: Database, evidence: EvidenceService, edits: EditService, truths: TruthService) -> None:
        self._database = database
        self._evidence = evidence
        self._edits = edits
        self._truths = truths

    def compare(self, reference: str, candidate: str) -> Comparison:
        """Measure ``candidate`` against ``reference``.

        Args:
            reference: ``run:ID``, ``annotation:RUN`` or ``truth:ID``.
            candidate: the same.

        Raises:
            NotFound: one of them is not there.
            Invalid: not such a name, two videos, or no frame in common.
            Conflict: a run has stored nothing yet.
        """
        ours, theirs = self._side(reference, "reference"), self._side(candidate, "candidate")
        if ours.video_id != theirs.video_id:
            raise Invalid("The two are of different videos. Choose two of the same one.", field="candidate")
        first, last = max(ours.first, theirs.first), min(ours.last, theirs.last)
        if first > last:
            raise Invalid(
                f"{ours.name} and {theirs.name} have no frame in common. Choose two that overlap.", field="candidate"
            )
        a, b = ours.boxes.within(first, last), theirs.boxes.within(first, last)
        found = match(a, b, MATCH_IOU)
        return Comparison(
            video_id=ours.video_id,
            reference=reference,
            candidate=candidate,
            sides={"reference": _view(ours, a), "candidate": _view(theirs, b)},
            first=first,
            last=min(last, max([first, *a.frame[-1:].tolist(), *b.frame[-1:].tolist()])) if last == _FAR else last,
            figures=figures(a, b, found),
            confusion=confusion(a, b, found),
        )

    def _side(self, name: str, field: str) -> Side:
        kind, _, identity = name.partition(":")
        if kind == "truth":
            video_id, title, table = self._truths.boxes(identity)
            return Side(kind, video_id, title, table, 0, _FAR)
        if kind not in ("run", "annotation"):
            raise Invalid(f"Name a run:ID, an annotation:RUN or a truth:ID. Got {name[:60]!r}.", field=field)
        place = self._evidence.place(identity)
        with self._database.read() as session:
            title = session.get_one(Run, place.id).name
        span = self._evidence.stored_frames(place.id)
        if span is None:
            raise Conflict(f"{title} has stored nothing yet. Wait for its first frames.", code="no_evidence")
        table = self._evidence.boxes(place.id)
        if kind == "annotation":
            table = corrected_boxes(table, self._edits.documents(place.id))
            title = f"{title}, corrected"
        return Side(kind, place.video_id, title, table, *span)


def _view(side: Side, boxes: BoxTable) -> SideView:
    tracks = len(set(boxes.track.tolist()))
    return SideView(name=side.name, kind=side.kind, tracks=tracks, boxes=len(boxes))
