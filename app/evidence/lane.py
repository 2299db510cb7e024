"""One track frame by frame, for the timeline and the inspector."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from app.body_model import Model
from app.evidence.overlays import MAX_NUMBER, Box, box_of, json_number
from app.evidence.run_columns import symmetry_floor_of, tau_of
from tsr_engine.evidence.columns import BOX, Columns, read_columns
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.labels.classes import RunClasses
from tsr_engine.records import FloatArray

MAX_CLASSES = 6
"""Maximum number of classes whose votes are reported."""


class TrackEvent(Model):
    """One event, as a sentence."""

    frame: int
    kind: str
    text: str


class TrackLane(Model):
    """One track frame by frame, one column per property. Null: the step did not take place."""

    id: int
    frame: list[int]
    source: list[int]
    box: list[Box]
    score: list[float | None]
    raw_score: list[float | None]
    prior: list[float | None]
    l_positive: list[float | None]
    symmetry: list[float | None]
    """1 / max(symmetry_magnitude, symmetry_floor)."""
    symmetry_magnitude: list[float | None]
    hash_distance: list[float | None]
    position_distance: list[float | None]
    confident: list[bool | None]
    decision: list[float | None]
    """SVM."""
    probability: list[float | None]
    scale: list[float | None]
    """S_t, px."""
    weight: list[float | None]
    """W_t."""
    classes: list[int]
    """Labels with the most votes, the winner first; -1: the video's set lacks the engine's class."""
    words: list[str | None]
    """The engine's name of each of them that the set lacks."""
    votes: list[list[float] | None]
    """Fused share of each of `classes`, 0..1."""
    probabilities: list[list[float] | None]
    """P(c | x_t) of each of `classes`."""
    top: list[int | None]
    """Label from each frame's crop alone, as in ``classes``."""
    top_word: list[str | None]
    """The engine's name of it, if the set lacks it."""
    top_probability: list[float | None]
    learned: list[int]
    """Samples learned."""
    unlearned: list[int]
    events: list[TrackEvent]
    tau: float
    symmetry_floor: float
    """The run's parameter: smaller values of symmetry_magnitude count as this in `symmetry`."""


_FIGURES = (
    "score", "detections.raw_score", "detections.prior", "gates.symmetry", "gates.symmetry_magnitude",
    "gates.hash_distance", "gates.position_distance", "relocalisations.decision", "relocalisations.probability",
    "recognitions.scale",
)  # fmt: skip
"""Columns that are shown unchanged under their names."""


def track_lane(reader: EvidenceReader, track_id: int, classes: RunClasses) -> TrackLane | None:
    """Read the lane of one track, confirmed or not; None: the run has no such track.

    Args:
        reader: evidence of the run.
        track_id: the track.
        classes: maps the run's class numbers to labels; classes with one label are combined.
    """
    rows = read_columns(
        reader, "track_frames", "frame", "source", *BOX, *_FIGURES, "gates.l_positive", "gates.confident",
        "recognitions.weight", "recognitions.votes", "recognitions.probabilities",
        tracks=(track_id, track_id), alive=True,
    )  # fmt: skip
    if not len(rows):
        return None
    votes, probabilities = rows.vectors("recognitions.votes"), rows.vectors("recognitions.probabilities")
    groups = _leading_groups(votes, classes)
    frames = rows.ints("frame").tolist()
    judged = rows.has_value("gates.confident").tolist()
    learned, unlearned = _sample_counts(reader, track_id, frames)
    top = [None if p is None else int(np.argmax(p)) for p in probabilities]
    return TrackLane(
        id=track_id,
        frame=frames,
        source=rows.sources().tolist(),
        box=[box_of(edges) for edges in rows.boxes().tolist()],
        **{name.rpartition(".")[2]: _figures(rows, name) for name in _FIGURES},
        # A candidate that could not be judged has no finite value, and NULL would mean that there is no verdict.
        l_positive=[
            json_number(value, MAX_NUMBER) if known else None
            for value, known in zip(rows.floats("gates.l_positive").tolist(), judged, strict=True)
        ],
        confident=[value > 0 if value >= 0 else None for value in rows.ints("gates.confident").tolist()],
        weight=[float(f"{v:.6g}") if v == v else None for v in rows.floats("recognitions.weight").tolist()],
        classes=[classes.to_label(group[0]) for group in groups],
        words=[_unmapped_name(group[0], classes) for group in groups],
        votes=[None if v is None else _group_sums(v / max(float(v.sum()), 1e-300), groups) for v in votes],
        probabilities=[None if p is None else _group_sums(p, groups) for p in probabilities],
        top=[None if number is None else classes.to_label(number) for number in top],
        top_word=[None if number is None else _unmapped_name(number, classes) for number in top],
        top_probability=[None if p is None else round(float(p[np.argmax(p)]), 4) for p in probabilities],
        learned=learned,
        unlearned=unlearned,
        events=_events(reader, track_id),
        tau=tau_of(reader),
        symmetry_floor=symmetry_floor_of(reader),
    )


def _leading_groups(votes: Sequence[FloatArray | None], classes: RunClasses) -> list[list[int]]:
    """The classes with the most final votes, the winner first; classes with one label form a group."""
    final = next((v for v in reversed(votes) if v is not None), None)
    if final is None:
        return []
    groups: dict[int, list[int]] = {}
    for class_number in np.argsort(-final, kind="stable").tolist():
        label = classes.to_label(class_number)
        groups.setdefault(-2 - class_number if label < 0 else label, []).append(class_number)
    shares = {label: float(final[group].sum()) for label, group in groups.items()}
    order = sorted(groups, key=lambda label: -shares[label])[:MAX_CLASSES]
    return [groups[label] for label in order if shares[label] > 0]


def _unmapped_name(class_number: int, classes: RunClasses) -> str | None:
    return classes.name(class_number) if classes.is_unmapped(class_number) else None


def _group_sums(values: FloatArray, groups: list[list[int]]) -> list[float]:
    return [round(float(values[group].sum()), 4) for group in groups]


def _figures(rows: Columns, name: str) -> list[float | None]:
    return [json_number(value) if value == value else None for value in rows.floats(name).tolist()]


def _events(reader: EvidenceReader, track_id: int) -> list[TrackEvent]:
    rows = read_columns(reader, "events", "frame", "kind", "text", tracks=(track_id, track_id))
    found = zip(rows.ints("frame").tolist(), rows.texts("kind"), rows.texts("text"), strict=True)
    return [TrackEvent(frame=frame, kind=kind, text=text) for frame, kind, text in found]


def _sample_counts(reader: EvidenceReader, track_id: int, frames: list[int]) -> tuple[list[int], list[int]]:
    """Number of samples learned and unlearned in each of the frames."""
    span, track = (frames[0], frames[-1] + 1), (track_id, track_id)
    rows = read_columns(reader, "samples", "frame", "transform", frames=span, tracks=track)
    learned, unlearned = Counter[int](), Counter[int]()
    for frame, transform in zip(rows.ints("frame").tolist(), rows.texts("transform"), strict=True):
        (learned if transform == "learned" else unlearned)[frame] += 1
    return [learned[k] for k in frames], [unlearned[k] for k in frames]
