"""What the layers of the picture show, frame by frame."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from app.evidence.tables import SOURCE_SQL
from app.shapes import Model
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.labels.classes import RunClasses

__all__ = ["MOST_FRAMES", "Box", "Overlay", "overlays"]

MOST_FRAMES = 256
"""Frames a request."""
LARGEST = 1e9
"""Stands for a value that is not finite: JSON has none."""

Box = tuple[float, float, float, float]


class OverlayDetection(Model):
    """One offline detection."""

    box: Box
    raw: float
    prior: float
    score: float
    track: int | None


class OverlayPrediction(Model):
    """Where the motion model expected the sign, and how surely."""

    box: Box
    sigma: tuple[float, float, float, float]


class OverlayGate(Model):
    """The verdict on that prediction."""

    l_positive: float
    confident: bool


class OverlayRelocalisation(Model):
    """What the online detector found instead."""

    search: Box
    box: Box
    decision: float
    probability: float
    runner_up: Box
    runner_up_decision: float


class OverlayTrack(Model):
    """One track in one frame."""

    id: int
    state: Literal["tentative", "confirmed"]
    source: Literal[0, 1, 2]
    box: Box
    class_id: int | None
    """Label of the video's set; None: never read; -1: the set lacks what the engine calls it."""
    word: str | None
    """What the engine calls it, where the set lacks that."""
    share: float | None
    prediction: OverlayPrediction | None
    gate: OverlayGate | None
    relocalisation: OverlayRelocalisation | None


class Overlay(Model):
    """See ``Overlay`` in static/js/types.js."""

    frame: int
    detections: list[OverlayDetection]
    tracks: list[OverlayTrack]


_TRACKS = f"""
SELECT t.frame, t.track_id, t.state, {SOURCE_SQL}, t.x1, t.y1, t.x2, t.y2, r.class_id, r.share,
       p.x1, p.y1, p.x2, p.y2, p.covariance, g.l_positive, g.confident,
       s.search_x1, s.search_y1, s.search_x2, s.search_y2, s.x1, s.y1, s.x2, s.y2, s.decision, s.probability,
       s.runner_up_x1, s.runner_up_y1, s.runner_up_x2, s.runner_up_y2, s.runner_up_decision, t.detection
FROM track_frames t
LEFT JOIN recognitions r ON r.frame = t.frame AND r.track_id = t.track_id
LEFT JOIN predictions p ON p.frame = t.frame AND p.track_id = t.track_id
LEFT JOIN gates g ON g.frame = t.frame AND g.track_id = t.track_id
LEFT JOIN relocalisations s ON s.frame = t.frame AND s.track_id = t.track_id
WHERE t.frame BETWEEN ? AND ? AND t.state <> 'dead' ORDER BY t.frame, t.row
"""  # noqa: S608


def overlays(reader: EvidenceReader, first: int, last: int, classes: RunClasses) -> list[Overlay]:
    """Overlays of ``first <= frame <= last``, one for each frame that the run has.

    Args:
        reader: of the run.
        first: first frame.
        last: last frame.
        classes: what the run's class numbers mean.
    """
    frames = [row[0] for row in reader.query("SELECT frame FROM frames WHERE frame BETWEEN ? AND ?", (first, last))]
    tracks: dict[int, list[OverlayTrack]] = {k: [] for k in frames}
    owners: dict[tuple[int, int], int] = {}
    for row in reader.query(_TRACKS, (first, last)):
        if row[0] in tracks:
            tracks[row[0]].append(_track(row, classes))
            if row[32] is not None:
                owners[row[0], row[32]] = row[1]
    detections: dict[int, list[OverlayDetection]] = {k: [] for k in frames}
    sql = (
        "SELECT frame, row, x1, y1, x2, y2, raw_score, prior, score FROM detections "
        "WHERE frame BETWEEN ? AND ? ORDER BY frame, row"
    )
    for k, row_number, *values in reader.query(sql, (first, last)):
        if k in detections:
            detections[k].append(
                OverlayDetection(
                    box=box_of(values[:4]),
                    raw=number(values[4]),
                    prior=number(values[5]),
                    score=number(values[6]),
                    track=owners.get((k, row_number)),
                )
            )
    return [Overlay(frame=k, detections=detections[k], tracks=tracks[k]) for k in frames]


def _track(row: tuple[Any, ...], classes: RunClasses) -> OverlayTrack:
    prediction = gate = found = None
    if row[14] is not None:
        spread = np.sqrt(np.maximum(np.frombuffer(row[14], "<f8").reshape(4, 4).diagonal(), 0.0))
        a, b, c, d = (number(round(float(v), 2)) if math.isfinite(v) else LARGEST for v in spread)
        prediction = OverlayPrediction(box=box_of(row[10:14]), sigma=(a, b, c, d))
    if row[16] is not None:
        gate = OverlayGate(l_positive=number(row[15], LARGEST), confident=bool(row[16]))
    if row[25] is not None:
        found = OverlayRelocalisation(
            search=box_of(row[17:21]),
            box=box_of(row[21:25]),
            decision=number(row[25]),
            probability=number(row[26]),
            runner_up=box_of(row[27:31]),
            runner_up_decision=number(row[31]),
        )
    return OverlayTrack(
        id=row[1],
        state="confirmed" if row[2] == "confirmed" else "tentative",
        source=row[3],
        box=box_of(row[4:8]),
        class_id=None if row[8] is None else classes.to_label(row[8]),
        word=classes.name(row[8]) if row[8] is not None and classes.is_unmapped(row[8]) else None,
        share=None if row[9] is None else number(row[9]),
        prediction=prediction,
        gate=gate,
        relocalisation=found,
    )


def number(value: float | None, instead: float = 0.0) -> float:
    """A value that JSON can hold, rounded to 4 decimals."""
    if value is None:
        return instead
    return round(value, 4) if math.isfinite(value) else math.copysign(LARGEST, value) if value == value else instead


def box_of(values: Any) -> Box:
    """Four edges, rounded to 2 decimals."""
    x1, y1, x2, y2 = (round(number(v), 2) for v in values)
    return x1, y1, x2, y2
