"""Compares two sides of one video."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from app.body_model import Model
from app.compare.annotation import corrected_boxes
from app.compare.figures import FIRST_UNKNOWN_LABEL, Confusion, Figure, confusion, figures
from app.edits.log_store import documents_of
from app.edits.track_name import track_name
from app.errors import Conflict, Invalid
from app.evidence.service import EvidenceService
from app.ground_truths.service import GroundTruthService
from app.labels.store import labels_of_video
from app.storage.database import Database
from app.storage.models import Run, Video
from tsr_engine.evaluation.matching import match
from tsr_engine.labels.classes import resolved_labels
from tsr_engine.labels.model import LabelSet
from tsr_engine.track_table import TrackTable

MATCH_IOU = 0.5
"""Minimum IoU of a match."""
_NO_LIMIT = 2**62


class SideView(Model):
    """One side, for the heading."""

    name: str
    kind: str
    tracks: int
    boxes: int
    names: dict[str, str]
    """Names of tracks that people have made, by key; the engine's are named by their number."""
    edited: bool
    """Whether the side is a run without its corrections, although people have corrected it."""


class Comparison(Model):
    """The figures of a candidate against a reference, over the frames that both have."""

    video_id: str
    width: int
    """Size of the video's picture, px."""
    height: int
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
    boxes: TrackTable
    first: int
    last: int
    names: dict[str, str] = field(default_factory=dict)
    edited: bool = False


class CompareService:
    """Loads two sides and compares them."""

    def __init__(self, database: Database, evidence: EvidenceService, ground_truths: GroundTruthService) -> None:
        self._database = database
        self._evidence = evidence
        self._ground_truths = ground_truths

    def compare(self, reference: str, candidate: str) -> Comparison:
        """Measure ``candidate`` against ``reference``, each of them ``run:ID``, ``annotation:RUN`` or ``truth:ID``.

        Raises:
            NotFound: one of them does not exist.
            Invalid: a name has another form, the videos differ, or the sides have no frame in common.
            Conflict: a run has no results yet.
        """
        words: dict[str, int] = {}
        reference_side = self._side(reference, "reference", words)
        candidate_side = self._side(candidate, "candidate", words)
        if reference_side.video_id != candidate_side.video_id:
            raise Invalid("The two sides belong to different videos. Choose two of the same video.", field="candidate")
        first, last = max(reference_side.first, candidate_side.first), min(reference_side.last, candidate_side.last)
        if first > last:
            raise Invalid(
                f"{reference_side.name} and {candidate_side.name} have no frame in common. Choose two that overlap.",
                field="candidate",
            )
        width, height = self._picture(reference_side.video_id)
        # only the engine's boxes may extend past the edge of the picture
        reference_boxes, candidate_boxes = (
            side.boxes.within(first, last + 1).inside(width, height) for side in (reference_side, candidate_side)
        )
        found = match(reference_boxes, candidate_boxes, MATCH_IOU)
        if last == _NO_LIMIT:
            last = min(last, max([first, *reference_boxes.frame[-1:].tolist(), *candidate_boxes.frame[-1:].tolist()]))
        return Comparison(
            video_id=reference_side.video_id,
            width=width,
            height=height,
            reference=reference,
            candidate=candidate,
            sides={
                "reference": _view(reference_side, reference_boxes),
                "candidate": _view(candidate_side, candidate_boxes),
            },
            first=first,
            last=last,
            figures=figures(reference_boxes, candidate_boxes, found),
            confusion=confusion(
                reference_boxes, candidate_boxes, found, {number: word for word, number in words.items()}
            ),
        )

    def _picture(self, video_id: str) -> tuple[int, int]:
        """Width and height of a video's picture, px; known for any video with a run or a ground truth."""
        with self._database.read() as session:
            video = session.get_one(Video, video_id)
            assert video.width is not None
            assert video.height is not None
            return video.width, video.height

    def _side(self, name: str, field: str, words: dict[str, int]) -> Side:
        """Load one side with labels of the video's set; ``words`` numbers the words of models that the set lacks."""
        kind, _, identity = name.partition(":")
        if kind == "truth":
            video_id, title, table = self._ground_truths.boxes(identity)
            with self._database.read() as session:
                labels = labels_of_video(session, video_id)
            return Side(kind, video_id, title, resolved(table, labels), 0, _NO_LIMIT)
        if kind not in ("run", "annotation"):
            raise Invalid(f"Name a run:ID, an annotation:RUN or a truth:ID. Got {name[:60]!r}.", field=field)
        run = self._evidence.stored_run(identity)
        with self._database.read() as session:
            title = session.get_one(Run, run.id).name
            documents = documents_of(session, run.id)
        span = self._evidence.stored_frames(run.id)
        if span is None:
            raise Conflict(f"{title} has no results yet. Wait for its first frames.", code="no_evidence")
        table = self._evidence.boxes(run.id, lambda word: words.setdefault(word, FIRST_UNKNOWN_LABEL - len(words)))
        if kind == "run":
            return Side(kind, run.video_id, title, table, *span, edited=bool(documents))
        names = {key: track_name(key, doc) for key, doc in documents.items() if key.startswith("h")}
        corrected = resolved(corrected_boxes(table, documents, span[1] + 1), run.classes.labels)
        return Side(kind, run.video_id, f"{title}, corrected", corrected, *span, names)


def resolved(table: TrackTable, labels: LabelSet) -> TrackTable:
    """Replace merged labels by the labels that they were merged into."""
    return replace(table, class_id=resolved_labels(table.class_id, labels))


def _view(side: Side, boxes: TrackTable) -> SideView:
    tracks = len(set(boxes.track.tolist()))
    return SideView.from_row(side, tracks=tracks, boxes=len(boxes))
