"""One track frame by frame, for the timeline and the inspector."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.evidence.overlays import LARGEST, Box, box_of, number
from app.evidence.tables import SOURCE_SQL, symmetry_floor_of, tau_of
from app.shapes import Model
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.labels.classes import RunClasses

__all__ = ["LEADING", "TrackEvent", "TrackLane", "track_lane"]

LEADING = 6
"""Most classes whose votes are reported."""


class TrackEvent(Model):
    """Something that happened, in a sentence."""

    frame: int
    kind: str
    text: str


class TrackLane(Model):
    """See ``TrackLane`` in static/js/types.js."""

    id: int
    frame: list[int]
    source: list[int]
    box: list[Box]
    score: list[float | None]
    raw_score: list[float | None]
    prior: list[float | None]
    l_positive: list[float | None]
    symmetry: list[float | None]
    symmetry_magnitude: list[float | None]
    hash_distance: list[float | None]
    position_distance: list[float | None]
    confident: list[bool | None]
    decision: list[float | None]
    probability: list[float | None]
    scale: list[float | None]
    weight: list[float | None]
    classes: list[int]
    """Labels with the most votes, the winner first; -1: the video's set lacks what the engine calls it."""
    words: list[str | None]
    """What the engine calls each of them, where the set lacks that."""
    votes: list[list[float] | None]
    probabilities: list[list[float] | None]
    top: list[int | None]
    """Label of each frame's crop alone, as in ``classes``."""
    top_word: list[str | None]
    top_probability: list[float | None]
    learned: list[int]
    unlearned: list[int]
    events: list[TrackEvent]
    tau: float
    symmetry_floor: float


_LANE = f"""
SELECT t.frame, {SOURCE_SQL}, t.x1, t.y1, t.x2, t.y2, t.score, d.raw_score, d.prior,
       g.l_positive, g.symmetry, g.symmetry_magnitude, g.hash_distance, g.position_distance, g.confident,
       s.decision, s.probability, r.scale, r.weight, r.votes, r.probabilities
FROM track_frames t
LEFT JOIN detections d ON d.frame = t.frame AND d.row = t.detection
LEFT JOIN gates g ON g.frame = t.frame AND g.track_id = t.track_id
LEFT JOIN relocalisations s ON s.frame = t.frame AND s.track_id = t.track_id
LEFT JOIN recognitions r ON r.frame = t.frame AND r.track_id = t.track_id
WHERE t.track_id = ? AND t.state <> 'dead' ORDER BY t.frame
"""  # noqa: S608


def track_lane(reader: EvidenceReader, track_id: int, classes: RunClasses) -> TrackLane | None:
    """The lane of one track, confirmed or not; None: the run has no such track.

    Args:
        reader: of the run.
        track_id: the track.
        classes: what the run's class numbers mean. Classes of one label count together.
    """
    rows = reader.query(_LANE, (track_id,))
    if not rows:
        return None
    votes = [None if row[19] is None else np.frombuffer(row[19], "<f8") for row in rows]
    seen = [None if row[20] is None else np.frombuffer(row[20], "<f4").astype(np.float64) for row in rows]
    leading = _leading(votes, classes)
    frames = [row[0] for row in rows]
    learned, unlearned = _samples(reader, track_id, frames)
    top = [None if p is None else int(np.argmax(p)) for p in seen]
    return TrackLane(
        id=track_id,
        frame=frames,
        source=[row[1] for row in rows],
        box=[box_of(row[2:6]) for row in rows],
        score=_column(rows, 6),
        raw_score=_column(rows, 7),
        prior=_column(rows, 8),
        # A candidate that could not be judged has no finite value; NULL there would read as "no verdict".
        l_positive=[None if row[14] is None else number(row[9], LARGEST) for row in rows],
        symmetry=_column(rows, 10),
        symmetry_magnitude=_column(rows, 11),
        hash_distance=_column(rows, 12),
        position_distance=_column(rows, 13),
        confident=[None if row[14] is None else bool(row[14]) for row in rows],
        decision=_column(rows, 15),
        probability=_column(rows, 16),
        scale=_column(rows, 17),
        weight=[None if row[18] is None else float(f"{row[18]:.6g}") for row in rows],
        classes=[classes.to_label(group[0]) for group in leading],
        words=[_word(group[0], classes) for group in leading],
        votes=[None if v is None else _of(v / max(float(v.sum()), 1e-300), leading) for v in votes],
        probabilities=[None if p is None else _of(p, leading) for p in seen],
        top=[None if seen is None else classes.to_label(seen) for seen in top],
        top_word=[None if seen is None else _word(seen, classes) for seen in top],
        top_probability=[None if p is None else round(float(p[np.argmax(p)]), 4) for p in seen],
        learned=learned,
        unlearned=unlearned,
        events=[
            TrackEvent(frame=row[0], kind=row[1], text=row[2])
            for row in reader.query(
                "SELECT frame, kind, text FROM events WHERE track_id = ? ORDER BY frame, row", (track_id,)
            )
        ],
        tau=tau_of(reader),
        symmetry_floor=symmetry_floor_of(reader),
    )


def _leading(votes: list[Any], classes: RunClasses) -> list[list[int]]:
    """The classes with the most final votes, the winner first; those of one label together."""
    final = next((v for v in reversed(votes) if v is not None), None)
    if final is None:
        return []
    groups: dict[int, list[int]] = {}
    for seen in np.argsort(-final, kind="stable").tolist():
        label = classes.to_label(seen)
        groups.setdefault(-2 - seen if label < 0 else label, []).append(seen)
    shares = {label: float(final[group].sum()) for label, group in groups.items()}
    order = sorted(groups, key=lambda label: -shares[label])[:LEADING]
    return [groups[label] for label in order if shares[label] > 0]


def _word(seen: int, classes: RunClasses) -> str | None:
    return classes.name(seen) if classes.is_unmapped(seen) else None


def _of(values: Any, groups: list[list[int]]) -> list[float]:
    return [round(float(values[group].sum()), 4) for group in groups]


def _column(rows: list[tuple[Any, ...]], place: int) -> list[float | None]:
    return [None if row[place] is None else number(row[place]) for row in rows]


def _samples(reader: EvidenceReader, track_id: int, frames: list[int]) -> tuple[list[int], list[int]]:
    """Samples learned and unlearned in each of the frames."""
    sql = (
        "SELECT frame, sum(transform = 'learned'), sum(transform = 'unlearned') FROM samples "
        "WHERE frame BETWEEN ? AND ? AND track_id = ? GROUP BY frame"
    )
    counts = {row[0]: row[1:] for row in reader.query(sql, (frames[0], frames[-1], track_id))}
    pairs = [counts.get(k, (0, 0)) for k in frames]
    return [p[0] for p in pairs], [p[1] for p in pairs]
