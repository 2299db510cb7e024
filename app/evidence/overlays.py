"""The layers of the picture, frame by frame."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Literal

import numpy as np

from app.body_model import Model
from tsr_engine.evidence.columns import BOX, Columns, read_columns
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.labels.classes import RunClasses
from tsr_engine.records import FloatArray

MAX_FRAMES = 256
"""Maximum number of frames in a request."""
MAX_NUMBER = 1e9
"""Replaces infinite values, which JSON does not have."""

Box = tuple[float, float, float, float]


class OverlayDetection(Model):
    """One offline detection."""

    box: Box
    raw: float
    prior: float
    score: float
    track: int | None


class OverlayPrediction(Model):
    """The box that the motion model expected, and its uncertainty."""

    box: Box
    sigma: tuple[float, float, float, float]


class OverlayGate(Model):
    """The gate's verdict on the prediction."""

    l_positive: float
    confident: bool


class OverlayRelocalisation(Model):
    """The online detector's result in place of a rejected prediction."""

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
    """Label of the video's set; None: not classified; -1: the set lacks the engine's class."""
    word: str | None
    """The engine's name of it, if the set lacks it."""
    share: float | None
    prediction: OverlayPrediction | None
    """Standard deviation of cx, cy, w, h, px."""
    gate: OverlayGate | None
    relocalisation: OverlayRelocalisation | None


class Overlay(Model):
    """Contents of the layers of one frame."""

    frame: int
    detections: list[OverlayDetection]
    tracks: list[OverlayTrack]


_TRACKS = (
    "frame", "track_id", "state", "source", *BOX, "detection", "recognitions.class_id", "recognitions.share",
    *(f"predictions.{edge}" for edge in BOX), "predictions.covariance", "gates.l_positive", "gates.confident",
    *(f"relocalisations.{prefix}{edge}" for prefix in ("search_", "", "runner_up_") for edge in BOX),
    "relocalisations.decision", "relocalisations.probability", "relocalisations.runner_up_decision",
)  # fmt: skip


def overlays(reader: EvidenceReader, first: int, last: int, classes: RunClasses) -> list[Overlay]:
    """Read the overlays of ``first <= frame <= last``, one per frame of the run."""
    span = (first, last + 1)
    frames = read_columns(reader, "frames", "frame", frames=span).ints("frame").tolist()
    tracks: dict[int, list[OverlayTrack]] = {k: [] for k in frames}
    owners: dict[tuple[int, int], int] = {}
    rows = read_columns(reader, "track_frames", *_TRACKS, frames=span, alive=True)
    track_rows = zip(rows.ints("frame").tolist(), rows.ints("detection").tolist(), _tracks(rows, classes), strict=True)
    for k, detection, track in track_rows:
        if k in tracks:
            tracks[k].append(track)
            if detection >= 0:
                owners[k, detection] = track.id
    detections: dict[int, list[OverlayDetection]] = {k: [] for k in frames}
    rows = read_columns(reader, "detections", "frame", "row", *BOX, "raw_score", "prior", "score", frames=span)
    for k, row, edges, raw, prior, score in zip(
        rows.ints("frame").tolist(),
        rows.ints("row").tolist(),
        rows.boxes().tolist(),
        rows.floats("raw_score").tolist(),
        rows.floats("prior").tolist(),
        rows.floats("score").tolist(),
        strict=True,
    ):
        if k in detections:
            detections[k].append(
                OverlayDetection(
                    box=box_of(edges),
                    raw=json_number(raw),
                    prior=json_number(prior),
                    score=json_number(score),
                    track=owners.get((k, row)),
                )
            )
    return [Overlay(frame=k, detections=detections[k], tracks=tracks[k]) for k in frames]


def _tracks(rows: Columns, classes: RunClasses) -> Iterator[OverlayTrack]:
    """The tracks of the rows, in their order."""
    labels = [None if label < 0 else label for label in rows.ints("recognitions.class_id").tolist()]
    shares = rows.floats("recognitions.share").tolist()
    states, sources, boxes = rows.texts("state"), rows.sources().tolist(), rows.boxes().tolist()
    predictions, gates, relocalisations = _predictions(rows), _gates(rows), _relocalisations(rows)
    for i, track_id in enumerate(rows.ints("track_id").tolist()):
        label = labels[i]
        yield OverlayTrack(
            id=track_id,
            state="confirmed" if states[i] == "confirmed" else "tentative",
            source=sources[i],
            box=box_of(boxes[i]),
            class_id=None if label is None else classes.to_label(label),
            word=classes.name(label) if label is not None and classes.is_unmapped(label) else None,
            share=json_number(shares[i]) if shares[i] == shares[i] else None,
            prediction=predictions[i],
            gate=gates[i],
            relocalisation=relocalisations[i],
        )


def _predictions(rows: Columns) -> list[OverlayPrediction | None]:
    covariances, boxes = rows.vectors("predictions.covariance"), rows.boxes("predictions.").tolist()
    return [
        None if covariance is None else OverlayPrediction(box=box_of(box), sigma=_standard_deviations(covariance))
        for covariance, box in zip(covariances, boxes, strict=True)
    ]


def _standard_deviations(covariance: FloatArray) -> tuple[float, float, float, float]:
    """Standard deviations of the four values, px."""
    deviations = np.sqrt(np.maximum(covariance.reshape(4, 4).diagonal(), 0.0)).tolist()
    a, b, c, d = (json_number(round(v, 2)) if math.isfinite(v) else MAX_NUMBER for v in deviations)
    return a, b, c, d


def _gates(rows: Columns) -> list[OverlayGate | None]:
    values, verdicts = rows.floats("gates.l_positive").tolist(), rows.ints("gates.confident").tolist()
    return [
        None if verdict < 0 else OverlayGate(l_positive=json_number(value, MAX_NUMBER), confident=verdict > 0)
        for value, verdict in zip(values, verdicts, strict=True)
    ]


def _relocalisations(rows: Columns) -> list[OverlayRelocalisation | None]:
    prefix = "relocalisations."
    search, boxes, runner_up_boxes = (rows.boxes(f"{prefix}{part}").tolist() for part in ("search_", "", "runner_up_"))
    decisions, probabilities, runner_up_decisions = (
        rows.floats(f"{prefix}{name}").tolist() for name in ("decision", "probability", "runner_up_decision")
    )
    return [
        OverlayRelocalisation(
            search=box_of(search[i]),
            box=box_of(boxes[i]),
            decision=json_number(decision),
            probability=json_number(probabilities[i]),
            runner_up=box_of(runner_up_boxes[i]),
            runner_up_decision=json_number(runner_up_decisions[i]),
        )
        if known
        else None
        for i, (decision, known) in enumerate(zip(decisions, rows.has_value(f"{prefix}decision").tolist(), strict=True))
    ]


def json_number(value: float, default: float = 0.0) -> float:
    """Convert a value to one that JSON can hold, rounded to 4 decimals; NaN to the default."""
    return round(value, 4) if math.isfinite(value) else math.copysign(MAX_NUMBER, value) if value == value else default


def box_of(values: Iterable[float]) -> Box:
    """Convert four edges, rounded to 2 decimals."""
    x1, y1, x2, y2 = (round(json_number(v), 2) for v in values)
    return x1, y1, x2, y2
