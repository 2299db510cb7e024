"""Decodes rows of the tables to records: the inverse of ``encode``."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tsr_engine.errors import EvidenceError
from tsr_engine.evidence.encode import Row
from tsr_engine.evidence.pixels import decode_pixels
from tsr_engine.records import (
    Detections,
    Event,
    EventKind,
    FloatArray,
    FrameEvidence,
    GateVerdict,
    Prediction,
    Recognition,
    Region,
    Relocalisation,
    Sample,
    TrackFrame,
)


@dataclass(frozen=True, slots=True)
class StoredFrame:
    """All rows of one frame: its row of ``frames``, and the other rows by table."""

    head: Row
    tables: dict[str, list[Row]]


class EventRow(NamedTuple):
    """A row of ``events``."""

    frame: int
    row: int
    track_id: int
    kind: EventKind
    text: str
    facts: str


def frame_of(rows: StoredFrame) -> FrameEvidence:
    """Decode one frame's evidence.

    Raises:
        EvidenceError: rows contradict each other or hold damaged values.
    """
    ordinal, seconds, width, height, shift_x, shift_y = rows.head[:6]
    try:
        by_track: dict[int, dict[str, list[Row]]] = {}
        for name in ("predictions", "gates", "relocalisations", "samples", "recognitions"):
            for row in rows.tables[name]:
                by_track.setdefault(row[1], {}).setdefault(name, []).append(row)
        return FrameEvidence(
            ordinal=ordinal,
            seconds=_float(seconds),
            width=width,
            height=height,
            detections=_detections(rows.tables["detections"]),
            shift=(_float(shift_x), _float(shift_y)),
            tracks=tuple(track_of(row, by_track.get(row[1], {})) for row in rows.tables["track_frames"]),
            events=tuple(event_of(EventRow(*row)) for row in rows.tables["events"]),
            regions=tuple(region_of(r) for r in rows.tables["regions"]),
            timings={row[2]: _float(row[3]) for row in rows.tables["timings"]},
        )
    except (ValueError, TypeError, IndexError, RecursionError) as error:
        raise EvidenceError(f"The evidence of frame {ordinal} is damaged: {error}.") from None


def track_of(row: Row, tables: dict[str, list[Row]]) -> TrackFrame:
    """Decode one track in one frame from its row of ``track_frames`` and its rows of other tables."""
    return TrackFrame(
        track_id=row[1],
        state=row[3],
        source=row[4],
        box=_array(row[5:9]),
        score=_float(row[9]),
        prediction=next((_prediction(r) for r in tables.get("predictions", ())), None),
        detection=row[10],
        gate=next((_verdict(r) for r in tables.get("gates", ())), None),
        relocalisation=next((_relocalisation(r) for r in tables.get("relocalisations", ())), None),
        samples=tuple(Sample(r[3], r[4], r[5], r[6]) for r in tables.get("samples", ())),
        recognition=next((_recognition(r) for r in tables.get("recognitions", ())), None),
    )


def region_of(row: Row) -> Region:
    """Decode one rectangle of pixels.

    Raises:
        EvidenceError: the bytes are damaged.
    """
    return Region(row[2], row[3], decode_pixels(row[6], row[4], row[5]))


def event_of(row: EventRow) -> Event:
    """Decode one event."""
    return Event(row.kind, row.track_id, row.text, json.loads(row.facts))


def _detections(rows: list[Row]) -> Detections:
    table = np.array([row[2:] for row in rows], dtype=np.float64).reshape(-1, 7)
    return Detections(np.ascontiguousarray(table[:, :4]), table[:, 4].copy(), table[:, 5].copy(), table[:, 6].copy())


def _prediction(row: Row) -> Prediction:
    return Prediction(_array(row[2:6]), np.frombuffer(row[6], "<f8").astype(np.float64).reshape(4, 4))


def _verdict(row: Row) -> GateVerdict:
    magnitude, symmetry, appearance, distance, product = map(_float, row[2:7])
    return GateVerdict(magnitude, symmetry, appearance, distance, product, bool(row[7]))


def _relocalisation(row: Row) -> Relocalisation:
    return Relocalisation(
        search_box=_array(row[2:6]),
        box=_array(row[6:10]),
        decision=_float(row[10]),
        probability=_float(row[11]),
        runner_up_box=_array(row[12:16]),
        runner_up_decision=_float(row[16]),
        windows=row[17],
    )


def _recognition(row: Row) -> Recognition:
    return Recognition(
        probabilities=np.frombuffer(row[2], "<f4").astype(np.float32),
        scale=_float(row[3]),
        weight=_float(row[4]),
        votes=np.frombuffer(row[5], "<f8").astype(np.float64),
        class_id=row[6],
        share=_float(row[7]),
        runner_up=row[8],
    )


def _array(values: Row) -> FloatArray:
    # SQLite stores NaN as NULL, which becomes NaN again.
    return np.array(values, dtype=np.float64)


def _float(value: float | None) -> float:
    return math.nan if value is None else value
