"""The confirmed tracks of a run, one column per property."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.body_model import Model
from app.evidence.clearest_frame import VIEWS, clearest_frames
from app.evidence.run_columns import FloatColumn, IntColumn, measures_windows, tau_of
from app.evidence.uncertainty import Disagreement, UncertaintyInput, uncertainties
from tsr_engine.evidence.columns import Columns, read_columns, read_end_boxes, read_runners_up
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.labels.classes import RunClasses
from tsr_engine.track_table import SOURCES


class TrackColumns(Model):
    """The confirmed tracks of a run: one column per property, one entry per track."""

    id: list[int]
    first: list[int]
    last: list[int]
    frames: list[int]
    detected: list[int]
    """Number of frames with a detection."""
    clearest: list[int]
    """Frame in which the sign is seen best: the largest sharp view that is not cut off by the picture."""
    first_box: list[tuple[float, float, float, float] | None]
    """Box in the first frame, px; a large one means that the sign was visible before."""
    last_box: list[tuple[float, float, float, float] | None]
    """Box in the last frame, px."""
    class_id: list[int | None]
    """Label of the video's set; None: not classified; -1: the set lacks the engine's class."""
    word: list[str | None]
    """The engine's name of it, if the set lacks it."""
    share: list[float | None]
    """Share of the fused class in all votes."""
    runner_up: list[int | None]
    runner_up_word: list[str | None]
    runner_up_share: list[float | None]
    score: list[float]
    """Best final score."""
    side: list[float]
    """Longest side, px."""
    rejected: list[int]
    """Number of frames with a rejected prediction."""
    relocalised: list[int]
    uncertainty: list[float | None]
    """Probability that a person changes the track; None: unknown, because the run was imported."""
    doubt: list[float | None]  # former name
    """The same under its former name."""
    rank: list[float]
    """Sort key of the queue: the uncertainty, with people's corrections at the time of the request."""
    reasons: list[list[str]]
    """Reasons for the uncertainty, as sentences."""
    tau: float
    complete: bool
    """False while the run goes on."""


@dataclass(frozen=True, slots=True)
class TrackProperties:
    """Columns from the evidence alone, one entry per confirmed track, by id."""

    id: IntColumn
    first: IntColumn
    last: IntColumn
    frames: IntColumn
    detected: IntColumn
    clearest: IntColumn
    first_box: FloatColumn
    last_box: FloatColumn
    score: FloatColumn
    side: FloatColumn
    class_id: IntColumn
    share: FloatColumn
    runner_up: IntColumn
    runner_up_share: FloatColumn
    rejected: IntColumn
    relocalised: IntColumn
    judged: IntColumn
    tau: float
    windows: bool
    by_engine: bool


def no_tracks(tau: float) -> TrackColumns:
    """The columns of a run without results."""
    empty: dict[str, list[object]] = {name: [] for name in TrackColumns.model_fields if name not in ("tau", "complete")}
    return TrackColumns.model_validate({**empty, "tau": tau, "complete": False})


_SUMMARY = (
    "track_id", "first_frame", "last_frame", "frames", "detected_frames", "best_score", "largest_side", "class_id",
    "share",
)  # fmt: skip


def read_track_properties(reader: EvidenceReader) -> TrackProperties:
    """Read the columns with one scan of ``gates`` and of ``track_frames``, and one row of votes per track."""
    rows = read_columns(reader, "tracks", *_SUMMARY, confirmed=True)
    ids, first, last = rows.ints("track_id"), rows.ints("first_frame"), rows.ints("last_frame")
    shown = read_columns(reader, "track_frames", *VIEWS, alive=True, confirmed=True, order="any")
    judged, rejected = _gates(reader, ids, last)
    runner_up, runner_up_share = read_runners_up(reader)
    return TrackProperties(
        id=ids,
        first=first,
        last=last,
        frames=rows.ints("frames"),
        detected=rows.ints("detected_frames"),
        clearest=clearest_frames(shown, ids, first),
        first_box=read_end_boxes(reader, "first_frame"),
        last_box=read_end_boxes(reader, "last_frame"),
        score=rows.floats("best_score"),
        side=rows.floats("largest_side"),
        class_id=rows.ints("class_id"),
        share=rows.floats("share"),
        runner_up=runner_up,
        runner_up_share=runner_up_share,
        rejected=rejected,
        relocalised=_relocalised(shown, ids),
        judged=judged,
        tau=tau_of(reader),
        windows=measures_windows(reader),
        by_engine="imported" not in reader.header.frame_table,
    )


@dataclass(frozen=True, slots=True)
class ClassNames:
    """Displayed names of each track's label and of its runner-up."""

    own: list[str | None]
    """None: not classified."""
    runner_up: list[str | None]
    unmapped: list[str | None]
    """The engine's name, if the set has no such label."""
    runner_up_unmapped: list[str | None]


def label_tracks(properties: TrackProperties, classes: RunClasses) -> tuple[TrackProperties, ClassNames]:
    """Replace the run's class numbers by labels of a set, and collect their names.

    If the runner-up is another class with the same label, its votes count for the label.

    Args:
        properties: from the evidence.
        classes: maps the run's class numbers to labels.
    """
    labels, runner_up_labels = classes.to_labels(properties.class_id), classes.to_labels(properties.runner_up)
    is_same_label = (labels >= 0) & (labels == runner_up_labels)
    numbers = properties.class_id.tolist()
    runner_up_numbers = np.where(is_same_label, -1, properties.runner_up).tolist()
    names = ClassNames(
        own=[None if n < 0 else classes.shown(n) for n in numbers],
        runner_up=[None if n < 0 else classes.shown(n) for n in runner_up_numbers],
        unmapped=[classes.name(n) if classes.is_unmapped(n) else None for n in numbers],
        runner_up_unmapped=[classes.name(n) if classes.is_unmapped(n) else None for n in runner_up_numbers],
    )
    labelled = replace(
        properties,
        class_id=labels,
        share=np.where(is_same_label, properties.share + properties.runner_up_share, properties.share),
        runner_up=np.where(is_same_label, -1, runner_up_labels),
        runner_up_share=np.where(is_same_label, np.nan, properties.runner_up_share),
    )
    return labelled, names


def track_columns(
    properties: TrackProperties,
    names: ClassNames,
    disagreement: Disagreement | None,
    overruled: NDArray[np.bool_],
    complete: bool,
) -> TrackColumns:
    """Build the page's columns: the properties, with uncertainty.

    Args:
        properties: properties of the run's tracks, labelled.
        names: names of their labels.
        disagreement: differences of another run.
        overruled: tracks to which a person gives another label. They rank first, but the page computes their
            uncertainty and reasons, because it knows newer corrections.
        complete: whether the run is complete.
    """
    result = uncertainties(
        UncertaintyInput(
            frames=properties.frames,
            detected=properties.detected,
            name=names.own,
            share=properties.share,
            runner_up=names.runner_up,
            runner_up_share=properties.runner_up_share,
            rejected=properties.rejected,
            judged=properties.judged,
            windows=properties.windows,
            by_engine=properties.by_engine,
        ),
        disagreement,
    )
    return TrackColumns(
        **{name: getattr(properties, name).tolist() for name in _PLAIN},
        first_box=_edges(properties.first_box),
        last_box=_edges(properties.last_box),
        class_id=[None if word is None else c for c, word in zip(properties.class_id.tolist(), names.own, strict=True)],
        word=names.unmapped,
        share=_optional(properties.share),
        runner_up=[
            None if w is None else c for c, w in zip(properties.runner_up.tolist(), names.runner_up, strict=True)
        ],
        runner_up_word=names.runner_up_unmapped,
        runner_up_share=_optional(properties.runner_up_share),
        score=np.round(np.nan_to_num(properties.score, neginf=0.0), 3).tolist(),
        side=np.round(np.nan_to_num(properties.side), 1).tolist(),
        uncertainty=_optional(result.uncertainty),
        doubt=_optional(result.uncertainty),  # former name
        rank=np.where(overruled, 1.0, result.rank).tolist(),
        reasons=result.reasons,
        tau=properties.tau,
        complete=complete,
    )


_PLAIN = ("id", "first", "last", "frames", "detected", "clearest", "rejected", "relocalised")
"""Properties that are columns as they are."""


def _edges(boxes: FloatColumn) -> list[tuple[float, float, float, float] | None]:
    rows = np.round(boxes, 1).tolist()
    return [(x1, y1, x2, y2) if x1 == x1 else None for x1, y1, x2, y2 in rows]


def _optional(values: FloatColumn) -> list[float | None]:
    return [None if v != v else v for v in np.round(values, 4).tolist()]


def _gates(reader: EvidenceReader, ids: IntColumn, last: IntColumn) -> tuple[IntColumn, IntColumn]:
    """Verdicts of each track on the lanes, all and rejecting ones; without that of the frame after its last one."""
    rows = read_columns(reader, "gates", "track_id", "frame", "confident", confirmed=True, order="any")
    index = np.searchsorted(ids, rows.ints("track_id"))
    alive = rows.ints("frame") <= last[index]
    rejected = alive & (rows.ints("confident") == 0)
    return np.bincount(index[alive], minlength=len(ids)), np.bincount(index[rejected], minlength=len(ids))


def _relocalised(rows: Columns, ids: IntColumn) -> IntColumn:
    """Number of relocalised frames."""
    relocalised = rows.sources() == SOURCES.index("relocalised")
    return np.bincount(np.searchsorted(ids, rows.ints("track_id")[relocalised]), minlength=len(ids))
