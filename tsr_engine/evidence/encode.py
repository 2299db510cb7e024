"""Encodes one frame's evidence as rows of the tables, and updates the summaries of its tracks."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from tsr_engine.evidence.pixels import encode_pixels
from tsr_engine.records import FloatArray, FrameEvidence, TrackFrame

Row = tuple[Any, ...]  # Any: each column has a type of its own
"""Values of a row in SQLite's types, in the order of the schema's columns."""
Rows = dict[str, list[Row]]


@dataclass(frozen=True, slots=True)
class TableEntry:
    """One row of the frame table: the frame's time and flags in its file."""

    pts: int | None = None
    """Presentation time in units of the stream's time base."""
    key: bool = False
    """Whether decoding can start here."""
    corrupt: bool = False
    """Whether the decoder flagged the picture as damaged."""


@dataclass(slots=True)
class StoredTrack:
    """Summary of a track over all its frames so far."""

    track_id: int
    first_frame: int
    last_frame: int
    frames: int = 0
    detected_frames: int = 0
    confirmed_frame: int | None = None
    best_score: float = -math.inf
    largest_side: float = 0.0
    class_id: int | None = None
    share: float | None = None

    @property
    def confirmed(self) -> bool:
        """Whether the track was ever confirmed."""
        return self.confirmed_frame is not None

    def extend(self, frame: int, track: TrackFrame) -> None:
        """Add a frame."""
        if track.state == "confirmed" and self.confirmed_frame is None:
            self.confirmed_frame = frame
        if track.recognition is not None:
            self.class_id, self.share = int(track.recognition.class_id), float(track.recognition.share)
        if track.state == "dead":
            return
        self.last_frame = frame
        self.frames += 1
        self.detected_frames += track.detection is not None
        x1, y1, x2, y2 = _floats(track.box)
        self.best_score = max(self.best_score, float(track.score))
        self.largest_side = max(self.largest_side, x2 - x1, y2 - y1)

    def row(self) -> Row:
        """The row of the table ``tracks``."""
        return (
            self.track_id,
            self.first_frame,
            self.last_frame,
            self.frames,
            self.detected_frames,
            self.confirmed_frame,
            self.best_score,
            self.largest_side,
            self.class_id,
            self.share,
        )


def add_rows(rows: Rows, evidence: FrameEvidence, entry: TableEntry, keep_pixels: bool) -> None:
    """Append one frame's rows to the rows of each table; values are in the order of the columns."""
    k = int(evidence.ordinal)
    alive = sum(track.state != "dead" for track in evidence.tracks)
    rows["frames"].append(
        (
            k,
            float(evidence.seconds),
            int(evidence.width),
            int(evidence.height),
            float(evidence.shift[0]),
            float(evidence.shift[1]),
            entry.pts if entry.pts is None else int(entry.pts),
            int(entry.key),
            int(entry.corrupt),
            alive,
        )
    )
    found = evidence.detections
    table = np.column_stack([found.boxes, found.raw_scores, found.prior, found.scores])
    rows["detections"] += [(k, i, *values) for i, values in enumerate(table.tolist())]
    for position, track in enumerate(evidence.tracks):
        _add_track(rows, k, position, track)
    for i, event in enumerate(evidence.events):
        facts = json.dumps(dict(event.values), default=_plain)
        rows["events"].append((k, i, int(event.track_id), event.kind, event.text, facts))
    if keep_pixels:
        for i, region in enumerate(evidence.regions):
            height, width = region.pixels.shape[:2]
            blob = encode_pixels(region.pixels)
            rows["regions"].append((k, i, int(region.x), int(region.y), width, height, blob))
    rows["timings"] += [(k, i, stage, float(s)) for i, (stage, s) in enumerate(evidence.timings.items())]


def _add_track(rows: Rows, k: int, position: int, track: TrackFrame) -> None:
    key = (k, int(track.track_id))
    detection = None if track.detection is None else int(track.detection)
    rows["track_frames"].append(
        (*key, position, track.state, track.source, *_floats(track.box), float(track.score), detection)
    )
    if (prediction := track.prediction) is not None:
        covariance = np.ascontiguousarray(prediction.covariance, dtype="<f8").tobytes()
        rows["predictions"].append((*key, *_floats(prediction.box), covariance))
    if (gate := track.gate) is not None:
        factors = (gate.symmetry_magnitude, gate.symmetry, gate.hash_distance, gate.position_distance, gate.l_positive)
        rows["gates"].append((*key, *map(float, factors), int(gate.confident)))
    if (found := track.relocalisation) is not None:
        rows["relocalisations"].append(
            (
                *key,
                *_floats(found.search_box),
                *_floats(found.box),
                float(found.decision),
                float(found.probability),
                *_floats(found.runner_up_box),
                float(found.runner_up_decision),
                int(found.windows),
            )
        )
    for i, sample in enumerate(track.samples):
        rows["samples"].append((*key, i, sample.transform, int(sample.label), sample.origin, int(sample.frame)))
    if (seen := track.recognition) is not None:
        rows["recognitions"].append(
            (
                *key,
                np.ascontiguousarray(seen.probabilities, dtype="<f4").tobytes(),
                float(seen.scale),
                float(seen.weight),
                np.ascontiguousarray(seen.votes, dtype="<f8").tobytes(),
                int(seen.class_id),
                float(seen.share),
                int(seen.runner_up),
            )
        )


def _floats(box: FloatArray) -> list[float]:
    values: list[float] = np.asarray(box, dtype=np.float64).tolist()
    return values


def _plain(value: object) -> object:
    """Convert NumPy scalars among an event's values for JSON."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"An event's values must be numbers or text. Got {type(value).__name__} instead.")
