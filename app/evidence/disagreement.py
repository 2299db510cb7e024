"""Finds tracks for which another run or a person gives another class."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.evidence.tracks import TrackFacts
from app.evidence.uncertainty import Disagreement
from app.storage.database import Database
from app.storage.models import Run, TrackDocument
from app.storage.of_run import newest_edit
from app.storage.places import is_here
from tsr_engine.errors import EvidenceError
from tsr_engine.evaluation.matching import box_pairs
from tsr_engine.labels.model import LabelSet
from tsr_engine.track_table import TrackTable

__all__ = ["MATCH_IOU", "Others", "against_run", "other_run", "overruled"]

MATCH_IOU = 0.3
"""Minimum IoU of two boxes in one frame that show the same sign."""
MISSED = 0.5
"""Weight of a track that the other run does not have."""


class Others:
    """Finds what other runs and people say about a run's tracks.

    Args:
        database: holds runs and edits.
        boxes: returns the boxes of a run's confirmed tracks.
    """

    def __init__(self, database: Database, boxes: Callable[[str], TrackTable]) -> None:
        self._database = database
        self._boxes = boxes
        self._lock = threading.Lock()
        self._known: OrderedDict[tuple[str, str, str, int], Disagreement] = OrderedDict()

    def version(self, run_id: str, video_id: str) -> tuple[str, str]:
        """A version that changes when another run is complete or a person edits this one."""
        with self._database.read() as session:
            other = other_run(session, run_id, video_id)
            seq = newest_edit(session, run_id)
        return ("" if other is None else other.id), str(seq)

    def forget(self, run_id: str) -> None:
        """Drop the data of a run."""
        with self._lock:
            for key in [key for key in self._known if run_id in key]:
                del self._known[key]

    def disagreement(self, run_id: str, video_id: str, facts: TrackFacts, labels: LabelSet) -> Disagreement | None:
        """Compare with the newest other run of the video; None: there is none, or it cannot be read.

        Args:
            run_id: the run.
            video_id: its video.
            facts: its tracks, labelled.
            labels: label set of the video.
        """
        with self._database.read() as session:
            other = other_run(session, run_id, video_id)
        return None if other is None else self._against(run_id, other, facts, labels)

    def overruled(self, run_id: str, facts: TrackFacts, labels: LabelSet) -> NDArray[np.bool_]:
        """Undecided tracks to which people give another label than the engine, shape (n,)."""
        with self._database.read() as session:
            documents = session.execute(
                select(TrackDocument.key, TrackDocument.document).where(TrackDocument.run_id == run_id)
            ).all()
        return overruled({row.key: row.document for row in documents}, facts, labels)

    def _against(self, run_id: str, other: Run, facts: TrackFacts, labels: LabelSet) -> Disagreement | None:
        state = run_id, other.id, labels.key, labels.version
        with self._lock:
            known = self._known.get(state)
        if known is not None:
            return known
        try:
            # The other run's evidence may be damaged or missing; its page reports that.
            theirs = self._boxes(other.id)
        except EvidenceError:
            return None
        stop = 2**62 if other.stop is None else other.stop
        name = other.name or "Another run"
        answer = against_run(self._boxes(run_id), theirs, facts, name, (other.first, stop), labels)
        with self._lock:
            self._known[state] = answer
            while len(self._known) > 8:
                self._known.popitem(last=False)
        return answer


def against_run(
    mine: TrackTable, theirs: TrackTable, facts: TrackFacts, name: str, span: tuple[int, int], labels: LabelSet
) -> Disagreement:
    """Find tracks that another run labels differently, or does not have.

    Args:
        mine: boxes of this run.
        theirs: boxes of the other run.
        facts: this run's tracks, in the order of ``mine.names``.
        name: name of the other run, for the sentence.
        span: frame range of the other run, the last excluded; tracks beyond it are not judged.
        labels: label set of the video; all three have labels of it.
    """
    n = len(facts.id)
    names = {label.id: label.name for label in labels}
    weight, sentence = np.zeros(n), [""] * n
    pairs = box_pairs(mine, theirs, MATCH_IOU)
    width = max(len(theirs.names), 1)
    together, frames = np.unique(mine.track[pairs.a] * width + theirs.track[pairs.b], return_counts=True)
    partner = np.full(n, -1)
    for code in together[np.argsort(frames, kind="stable")].tolist():
        partner[code // width] = code % width
    of_theirs = dict(zip(theirs.track.tolist(), theirs.class_id.tolist(), strict=True))
    for i in range(n):
        if partner[i] < 0:
            if facts.first[i] >= span[0] and facts.last[i] < span[1]:
                weight[i], sentence[i] = MISSED, f"{name} has no such track."
            continue
        label = of_theirs[int(partner[i])]
        if label != facts.class_id[i] and label >= 0:
            weight[i] = 1.0
            sentence[i] = f"{name} labels it '{names[label]}'."
    return Disagreement(weight, sentence)


def overruled(documents: Mapping[str, Mapping[str, object]], facts: TrackFacts, labels: LabelSet) -> NDArray[np.bool_]:
    """Find undecided tracks to which a person has given another label than the engine, or none.

    The twin of ``overruled`` in static/js/model/track_entries.js.

    Args:
        documents: by key.
        facts: the run's tracks, labelled.
        labels: label set of the video.

    Returns:
        Shape (n,).
    """
    found = np.zeros(len(facts.id), dtype=np.bool_)
    merged = labels.merged_ids()
    place = {f"m{track}": i for i, track in enumerate(facts.id.tolist())}
    for key, document in documents.items():
        i, label = place.get(key), document.get("class_id")
        if i is not None and document.get("review") not in ("accepted", "rejected"):
            another = isinstance(label, int) and merged.get(label, label) != facts.class_id[i]
            found[i] = document.get("not_a_sign", False) or another
    return found


def other_run(session: Session, run_id: str, video_id: str) -> Run | None:
    """Find the newest other complete run of the video; what-ifs do not count."""
    query = (
        select(Run)
        .where(Run.video_id == video_id, Run.id != run_id, Run.state == "complete", Run.kind != "whatif")
        .where(is_here(session, Run.place))
        .order_by(Run.order.desc(), Run.id)
        .limit(1)
    )
    return session.scalars(query).first()
