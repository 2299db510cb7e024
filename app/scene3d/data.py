"""The data of the scenes, read once from a run's evidence."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.evidence.run_columns import FloatColumn, IntColumn
from app.evidence.service import EvidenceService
from tsr_engine.evidence.columns import BOX, frame_size, read_columns, sample_detections
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.model import Label, LabelSet

SIGN_SIZES = {"circle": 0.60, "triangle": 0.90, "inverted triangle": 0.90, "octagon": 0.90, "diamond": 0.60}
"""Width of a sign by shape, m: size 2 of the German catalogue (VzKat), usual at 50 to 100 km/h."""
UNKNOWN_SIZE = 0.60
FLAGGED_UNCERTAINTY = 0.25
MAX_FLAGGED = 40
MAX_DETECTIONS = 20_000


@dataclass(frozen=True, slots=True)
class Sign:
    """The sign of a track.

    Attributes:
        name: displayed name.
        size: usual width of the sign, m.
        pictogram: see ``Label.pictogram``; empty: there is none.
    """

    name: str
    size: float = UNKNOWN_SIZE
    pictogram: str = ""


@dataclass(frozen=True, slots=True)
class Scene3dData:
    """The confirmed tracks of a run; rows are sorted by track, then frame.

    Attributes:
        run_id: the run.
        video_id: its video.
        width: width of the picture, px.
        height: height of the picture, px.
        frames: shape (k,), ordinals of the stored frames.
        times: shape (k,), their presentation times, s.
        ids: shape (t,), numbers of the tracks.
        class_id: shape (t,), keys of ``signs``; -1: not classified.
        flagged: shape (t,), whether to check the track: the most uncertain ones, and those marked as needing work.
        frame: shape (n,).
        track: shape (n,), index into ``ids``.
        boxes: shape (n, 4), px.
        source: shape (n,), 0 detected, 1 predicted, 2 relocalised.
        verdict: shape (n,), 0 not judged, 1 confident, 2 rejected.
        signs: the video's labels by id; higher keys are the engine's classes that the set lacks.
    """

    run_id: str
    video_id: str
    width: int
    height: int
    frames: IntColumn
    times: FloatColumn
    ids: IntColumn
    class_id: IntColumn
    flagged: NDArray[np.bool_]
    frame: IntColumn
    track: IntColumn
    boxes: FloatColumn
    source: IntColumn
    verdict: IntColumn
    signs: Mapping[int, Sign]

    def sign(self, track: int) -> Sign | None:
        """The sign of a track by its index; None: not classified."""
        return self.signs.get(int(self.class_id[track]))

    @property
    def sign_names(self) -> dict[int, str]:
        """Names of all signs."""
        return {label: sign.name for label, sign in self.signs.items()}

    @property
    def interval(self) -> float:
        """Median duration of a frame, s."""
        return float(np.median(np.diff(self.times))) if len(self.times) > 1 else 0.04

    def seconds(self, frame: IntColumn | int) -> FloatColumn:
        """Presentation times of frames; those of frames that are not stored are interpolated."""
        if not len(self.frames):
            return np.asarray(np.asarray(frame, np.float64) * self.interval)
        return np.asarray(np.interp(frame, self.frames, self.times))

    def position(self, key: str | None) -> int | None:
        """Index of the track with a key such as ``m7``; None: it is no track of the engine."""
        if key is None or not key.startswith("m") or not key[1:].isdecimal():
            return None
        found = np.flatnonzero(self.ids == int(key[1:]))
        return int(found[0]) if len(found) else None

    def key(self, track: int) -> str:
        """Key of the track at an index."""
        return f"m{self.ids[track]}"

    def name(self, track: int) -> str:
        """Displayed name of the track at an index."""
        return f"#{self.ids[track]}"


@dataclass(frozen=True, slots=True)
class DetectionPoints:
    """Detections of a run; if there are very many, an evenly spread part of them.

    Attributes:
        centres: shape (n, 2), normalised (x, y) in [0, 1].
        prior: shape (n,), the prior's value that the detector used there.
        tracked: shape (n,), whether the detection belongs to a confirmed track.
        total: number before thinning.
    """

    centres: FloatColumn
    prior: FloatColumn
    tracked: NDArray[np.bool_]
    total: int


def load_scene3d(evidence: EvidenceService, run_id: str, needs_work: frozenset[int] = frozenset()) -> Scene3dData:
    """Read the data of a run; ``needs_work``: tracks that a person marked as needing work.

    Raises:
        NotFound: no such run.
        Conflict: it has no results yet.
    """
    run = evidence.stored_run(run_id)
    reported = json.loads(evidence.tracks(run_id))
    ids = np.array(reported["id"], np.int64)
    classes, signs = _signs(reported, run.classes.labels)
    rank = np.array(reported["rank"], np.float64)
    with evidence.reading(run) as reader:
        width, height = frame_size(reader) or (1280, 720)
        table = read_columns(reader, "frames", "frame", "seconds")
        names = ("frame", "track_id", *BOX, "source", "gates.confident")
        rows = read_columns(reader, "track_frames", *names, alive=True, order="track")
    order = np.argsort(ids)
    track, boxes, confident = rows.ints("track_id"), rows.boxes(), rows.ints("gates.confident")
    index = np.searchsorted(ids[order], track) if len(ids) else np.zeros(len(track), np.int64)
    is_known = (index < len(ids)) & np.isfinite(boxes).all(axis=1)
    if len(ids):
        is_known &= ids[order][np.minimum(index, len(ids) - 1)] == track
    return Scene3dData(
        run_id=run_id,
        video_id=run.video_id,
        width=width,
        height=height,
        frames=table.ints("frame"),
        times=_times(table.floats("seconds"), table.floats("frame")),
        ids=ids,
        class_id=classes,
        flagged=_flagged(ids, rank, needs_work),
        frame=rows.ints("frame")[is_known],
        track=(order[index[is_known]] if len(ids) else index[is_known]).astype(np.int64),
        boxes=boxes[is_known],
        source=rows.sources()[is_known],
        verdict=np.where(confident < 0, 0, np.where(confident > 0, 1, 2))[is_known],
        signs=signs,
    )


def _signs(reported: JsonObject, labels: LabelSet) -> tuple[IntColumn, dict[int, Sign]]:
    """Key of each track's sign, shape (t,), and the signs by key."""
    signs = {label.id: Sign(label.name, _size(label), label.pictogram) for label in labels}
    unmapped: dict[str, int] = {}
    found = []
    for label, word in zip(reported["class_id"], reported["word"], strict=True):
        if word is not None:
            label = unmapped.setdefault(word, labels.next_id + len(unmapped))
            signs[label] = Sign(word)
        found.append(-1 if label is None else label)
    return np.array(found, np.int64), signs


def _size(label: Label) -> float:
    """Real width of a sign, m: the label's own, or else the usual one of its shape."""
    return SIGN_SIZES.get(label.shape, UNKNOWN_SIZE) if label.size_mm is None else label.size_mm / 1000


def load_detections(reader: EvidenceReader, width: int, height: int, confirmed: IntColumn) -> DetectionPoints:
    """Read the detections of a run; at most ``MAX_DETECTIONS``, evenly spread."""
    rows, total = sample_detections(reader, MAX_DETECTIONS)
    centres = np.stack([rows.floats("x"), rows.floats("y")], axis=1)
    is_finite = np.isfinite(centres).all(axis=1)
    centres = np.clip(centres[is_finite] / np.array([width, height]), 0.0, 1.0)
    tracked = np.isin(rows.ints("track_id")[is_finite], confirmed)
    return DetectionPoints(centres, np.nan_to_num(rows.floats("prior")[is_finite]), tracked, total)


def _flagged(ids: IntColumn, uncertainty: FloatColumn, needs_work: frozenset[int]) -> NDArray[np.bool_]:
    flagged = np.zeros(len(ids), np.bool_)
    worst = np.argsort(-uncertainty, kind="stable")[:MAX_FLAGGED]
    flagged[worst[uncertainty[worst] >= FLAGGED_UNCERTAINTY]] = True
    return flagged | np.isin(ids, list(needs_work))


def _times(seconds: FloatColumn, frames: FloatColumn) -> FloatColumn:
    """Times without gaps: missing ones assume 25 frames per second."""
    return np.where(np.isfinite(seconds), seconds, frames / 25.0)
