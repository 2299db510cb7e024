"""Finds tracks for which another run or a person gives another class."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.errors import Conflict, NotFound
from app.evidence.tracks import TrackProperties
from app.evidence.uncertainty import Disagreement
from app.storage.database import Database
from app.storage.lookup import newest_edit
from app.storage.models import Run, TrackDocument
from app.storage.servers import is_local
from tsr_engine.errors import EvidenceError
from tsr_engine.evaluation.matching import box_pairs
from tsr_engine.labels.model import LabelSet
from tsr_engine.track_table import TrackTable

MIN_IOU = 0.3
"""Minimum IoU of two boxes in one frame that show the same sign."""
MISSING_WEIGHT = 0.5
"""Weight of a track that the other run does not have."""


class DisagreementFinder:
    """Finds what other runs and people say about a run's tracks.

    Args:
        database: holds runs and edits.
        boxes: returns the boxes of a run's confirmed tracks.
    """

    def __init__(self, database: Database, boxes: Callable[[str], TrackTable]) -> None:
        self._database = database
        self._boxes = boxes
        self._lock = threading.Lock()
        self._cache: OrderedDict[tuple[str, str, str, int], Disagreement] = OrderedDict()

    def version(self, run_id: str, video_id: str) -> tuple[str, str]:
        """A version that changes when another run is complete or a person edits this one."""
        with self._database.read() as session:
            other = other_run(session, run_id, video_id)
            seq = newest_edit(session, run_id)
        return ("" if other is None else other.id), str(seq)

    def forget(self, run_id: str) -> None:
        """Drop the data of a run."""
        with self._lock:
            for key in [key for key in self._cache if run_id in key]:
                del self._cache[key]

    def disagreement(
        self, run_id: str, video_id: str, properties: TrackProperties, labels: LabelSet
    ) -> Disagreement | None:
        """Compare with the newest other run of the video; None: there is none, or it cannot be read.

        Raises:
            Busy, StorageError: its evidence cannot be fetched from the shared files now.
        """
        with self._database.read() as session:
            other = other_run(session, run_id, video_id)
        return None if other is None else self._compare_with(run_id, other, properties, labels)

    def overruled(self, run_id: str, properties: TrackProperties, labels: LabelSet) -> NDArray[np.bool_]:
        """Undecided tracks to which people give another label than the engine, shape (n,)."""
        with self._database.read() as session:
            documents = session.execute(
                select(TrackDocument.key, TrackDocument.document).where(TrackDocument.run_id == run_id)
            ).all()
        return overruled({row.key: row.document for row in documents}, properties, labels)

    def _compare_with(
        self, run_id: str, other: Run, properties: TrackProperties, labels: LabelSet
    ) -> Disagreement | None:
        state = run_id, other.id, labels.key, labels.version
        with self._lock:
            cached = self._cache.get(state)
        if cached is not None:
            return cached
        try:
            # The other run's evidence may be damaged or missing; its page reports that.
            other_boxes = self._boxes(other.id)
        except (Conflict, EvidenceError, NotFound):
            return None
        stop = 2**62 if other.stop is None else other.stop
        name = other.name or "Another run"
        disagreement = compare_with_run(self._boxes(run_id), other_boxes, properties, name, (other.first, stop), labels)
        with self._lock:
            self._cache[state] = disagreement
            while len(self._cache) > 8:
                self._cache.popitem(last=False)
        return disagreement


def compare_with_run(
    boxes: TrackTable,
    other_boxes: TrackTable,
    properties: TrackProperties,
    name: str,
    span: tuple[int, int],
    labels: LabelSet,
) -> Disagreement:
    """Find tracks that another run labels differently, or does not have.

    Args:
        boxes: boxes of this run.
        other_boxes: boxes of the other run.
        properties: this run's tracks, in the order of ``boxes.names``.
        name: name of the other run, for the sentence.
        span: frame range of the other run, the last excluded; tracks beyond it are not judged.
        labels: label set of the video; all three have labels of it.
    """
    n = len(properties.id)
    names = {label.id: label.name for label in labels}
    weight, sentence = np.zeros(n), [""] * n
    pairs = box_pairs(boxes, other_boxes, MIN_IOU)
    width = max(len(other_boxes.names), 1)
    together, frames = np.unique(boxes.track[pairs.a] * width + other_boxes.track[pairs.b], return_counts=True)
    partner = np.full(n, -1)
    for code in together[np.argsort(frames, kind="stable")].tolist():
        partner[code // width] = code % width
    label_of_track = dict(zip(other_boxes.track.tolist(), other_boxes.class_id.tolist(), strict=True))
    for i in range(n):
        if partner[i] < 0:
            if properties.first[i] >= span[0] and properties.last[i] < span[1]:
                weight[i], sentence[i] = MISSING_WEIGHT, f"{name} has no such track."
            continue
        label = label_of_track[int(partner[i])]
        if label != properties.class_id[i] and label >= 0:
            weight[i] = 1.0
            sentence[i] = f"{name} labels it '{names[label]}'."
    return Disagreement(weight, sentence)


def overruled(
    documents: Mapping[str, Mapping[str, object]], properties: TrackProperties, labels: LabelSet
) -> NDArray[np.bool_]:
    """Find undecided tracks to which a person has given another label than the engine, or none.

    The twin of ``overruled`` in static/js/model/track_entries.js.

    Args:
        documents: by key.
        properties: the run's tracks, labelled.
        labels: label set of the video.

    Returns:
        Shape (n,).
    """
    found = np.zeros(len(properties.id), dtype=np.bool_)
    merged = labels.merged_ids()
    index_of = {f"m{track}": i for i, track in enumerate(properties.id.tolist())}
    for key, document in documents.items():
        i, label = index_of.get(key), document.get("class_id")
        if i is not None and document.get("review") not in ("accepted", "rejected"):
            another = isinstance(label, int) and merged.get(label, label) != properties.class_id[i]
            found[i] = document.get("not_a_sign", False) or another
    return found


def other_run(session: Session, run_id: str, video_id: str) -> Run | None:
    """Find the newest other complete run of the video; what-ifs do not count."""
    query = (
        select(Run)
        .where(Run.video_id == video_id, Run.id != run_id, Run.state == "complete", Run.kind != "whatif")
        .where(is_local(session, Run.place))
        .order_by(Run.order.desc(), Run.id)
        .limit(1)
    )
    return session.scalars(query).first()
