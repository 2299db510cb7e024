"""Reads the columns of a recording from evidence for one range of frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from tsr_engine.errors import UsageError
from tsr_engine.evidence.columns import BOX, Columns, read_columns
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.recording.classes import RecordedClasses
from tsr_engine.recording.content import BoxRows, EventLog, Frames, Series, TrackSeries
from tsr_engine.records import FloatArray
from tsr_engine.track_table import IntArray, TrackTable

MAX_VOTE_CLASSES = 5
"""Largest number of classes whose votes are drawn."""


def read_frames(reader: EvidenceReader, first: int | None, stop: int | None, run_name: str = "the run") -> Frames:
    """The frames ``first <= k < stop`` of a run, which messages call ``run_name``; unset: from its first, to its last.

    Raises:
        UsageError: the run has not stored all of them.
    """
    low, high = reader.first_frame, reader.last_frame
    subject = f"{run_name[:1].upper()}{run_name[1:]}"
    if low is None or high is None:
        raise UsageError(f"{subject} has stored no frame yet. Wait for the run, or choose another one.")
    start, end = low if first is None else first, high + 1 if stop is None else stop
    if not low <= start < end <= high + 1:
        raise UsageError(
            f"{subject} has stored the frames {low} to {high}, so a range is within {low}:{high + 1} and not "
            f"empty. Got {start}:{end}."
        )
    rows = read_columns(reader, "frames", "frame", "seconds", "pts", "width", "height", frames=(start, end))
    return Frames(
        ordinal=rows.ints("frame"),
        seconds=rows.floats("seconds"),
        pts=rows.ints("pts"),
        width=int(rows.ints("width")[0]),
        height=int(rows.ints("height")[0]),
    )


def read_box_layers(reader: EvidenceReader, frames: Frames, classes: RecordedClasses) -> Iterator[tuple[str, BoxRows]]:
    """Yield name and boxes of every layer of the engine; each is read on request."""
    span = (frames.first, frames.first + len(frames))
    found = read_columns(reader, "detections", "frame", *BOX, "raw_score", "prior", "score", frames=span)
    raw, prior, score = (_number_texts(found, name) for name in ("raw_score", "prior", "score"))
    yield "detections_raw", _boxes(found, raw)
    yield "detections", _boxes(found, [f"{s} (prior {p})" for s, p in zip(score, prior, strict=True)])

    gate = ("gates.l_positive", "gates.confident")
    found = read_columns(reader, "predictions", "frame", "track_id", *BOX, "covariance", *gate, frames=span, alive=True)
    ids = _track_names(found)
    verdicts = map(_gate_text, _number_texts(found, "gates.l_positive"), found.values("gates.confident"))
    predictions = _boxes(found, [f"{of} {verdict}".rstrip() for of, verdict in zip(ids, verdicts, strict=True)])
    yield "predictions", predictions
    yield (
        "innovation",
        BoxRows(replace(predictions.table, boxes=_one_sigma_boxes(found)), tuple(f"{of} 1 sigma" for of in ids)),
    )

    figures = ("decision", "probability", "runner_up_decision", "windows")
    edges = [f"{of}{edge}" for of in ("search_", "", "runner_up_") for edge in BOX]
    found = read_columns(reader, "relocalisations", "frame", "track_id", *figures, *edges, frames=span, alive=True)
    ids = _track_names(found)
    decision, probability = (_number_texts(found, name) for name in ("decision", "probability"))
    windows = [f"{of} {n} windows" for of, n in zip(ids, found.ints("windows").tolist(), strict=True)]
    yield "search", _boxes(found, windows, "search_")
    texts = [f"{of} {value} (P {p})" for of, value, p in zip(ids, decision, probability, strict=True)]
    yield "relocalisations", _boxes(found, texts)
    texts = [f"{of} {value}" for of, value in zip(ids, _number_texts(found, "runner_up_decision"), strict=True)]
    yield "runner_up", _boxes(found, texts, "runner_up_")

    names = [*BOX, "frame", "track_id", "state", "source", "recognitions.class_id", "recognitions.share"]
    found = read_columns(reader, "track_frames", *names, frames=span, alive=True)
    seen = found.ints("recognitions.class_id")
    yield "results", _boxes(found, _result_texts(found, seen, classes)).with_classes(seen)


def read_events(reader: EvidenceReader, frames: Frames) -> EventLog:
    """The events in the frames, in order."""
    span = (frames.first, frames.first + len(frames))
    rows = read_columns(reader, "events", "frame", "kind", "track_id", "text", frames=span)
    texts = zip(_track_names(rows), rows.texts("text"), strict=True)
    return EventLog(rows.ints("frame"), tuple(rows.texts("kind")), tuple(f"{of}: {text}" for of, text in texts))


_VALUE_COLUMNS = {
    "gate/l_positive": "gates.l_positive",
    "gate/symmetry": "gates.symmetry",
    "gate/symmetry_magnitude": "gates.symmetry_magnitude",
    "gate/hash_distance": "gates.hash_distance",
    "gate/position_distance": "gates.position_distance",
    "svm/decision": "relocalisations.decision",
    "svm/probability": "relocalisations.probability",
    "fusion/scale": "recognitions.scale",
    "fusion/weight": "recognitions.weight",
}
"""Name in the recording -> column."""
_SCORE_NAMES = ("with prior", "raw", "prior")


def read_track_series(reader: EvidenceReader, frames: Frames, classes: RecordedClasses) -> Iterator[TrackSeries]:
    """Yield values over time of every track that was ever confirmed and lives in the frames."""
    span = (frames.first, frames.first + len(frames))
    scores = ("score", "detections.raw_score", "detections.prior")
    names = ("track_id", "frame", "source", *scores, *_VALUE_COLUMNS.values(), "recognitions.votes", "tracks.class_id")
    rows = read_columns(reader, "track_frames", *names, frames=span, alive=True, confirmed=True, order="track")
    ids, frame, sources, labels = rows.ints("track_id"), rows.ints("frame"), rows.texts("source"), rows.ints(names[-1])
    columns = {name: rows.floats(column) for name, column in _VALUE_COLUMNS.items()}
    score = np.stack([rows.floats(name) for name in scores], axis=1)
    votes = rows.vectors("recognitions.votes")
    starts = np.flatnonzero(np.diff(ids, prepend=-1)).tolist()
    for start, end in pairwise([*starts, len(ids)]):
        rows_of_track = slice(start, end)
        at = frame[rows_of_track]
        values = {name: _known_values(at, column[rows_of_track], name) for name, column in columns.items()}
        gate = values["gate/l_positive"]
        positive = gate.values[:, 0] > 0
        logs = np.log10(gate.values[positive])
        values["gate/log10_l_positive"] = Series(gate.at[positive], logs, ("log10 L",))
        values["score"] = Series(at, score[rows_of_track], _SCORE_NAMES)
        values["votes"] = _votes(at, votes[rows_of_track], classes)
        known_series = {name: series for name, series in values.items() if len(series.at)}
        yield TrackSeries(
            int(ids[start]), int(labels[start]), known_series, _states(at, sources[rows_of_track], span[1])
        )


def _votes(at: IntArray, found: list[FloatArray | None], classes: RecordedClasses) -> Series:
    """Share of each leading class in all votes so far."""
    known = [i for i, votes in enumerate(found) if votes is not None]
    if not known:
        return Series(at[:0], np.zeros((0, 0)), ())
    votes = np.stack([votes for votes in found if votes is not None])
    share = votes / np.maximum(votes.sum(axis=1, keepdims=True), 1e-300)
    leading = [
        c for c in np.argsort(-share.max(axis=0), kind="stable")[:MAX_VOTE_CLASSES].tolist() if share[:, c].max() > 0
    ]
    return Series(at[known], share[:, leading], tuple(classes.title(c) for c in leading))


def _states(at: IntArray, sources: list[str], stop: int) -> tuple[IntArray, tuple[str, ...]]:
    """Where the source of a track's result changes; a gap, and the track's end within the range, are states too."""
    frames: list[int] = []
    states: list[str] = []
    previous, last = "", -1
    for frame, source in zip(at.tolist(), sources, strict=True):
        if frames and frame != last + 1:
            frames.append(last + 1)
            states.append("")
            previous = ""
        if source != previous:
            frames.append(frame)
            states.append(source)
        previous, last = source, frame
    if last + 1 < stop:
        frames.append(last + 1)
        states.append("")
    return np.array(frames, np.int64), tuple(states)


def _known_values(at: IntArray, column: FloatArray, name: str) -> Series:
    """One value over time, where it is known."""
    keep = np.isfinite(column)
    return Series(at[keep], column[keep, None], (name.rpartition("/")[2].replace("_", " "),))


def _boxes(rows: Columns, labels: list[str], prefix: str = "") -> BoxRows:
    """Boxes without a class."""
    no_track = np.full(len(rows), -1)  # the texts contain the track numbers
    return BoxRows(TrackTable(rows.ints("frame"), no_track, rows.boxes(prefix)), tuple(labels))


def _track_names(rows: Columns) -> list[str]:
    return [f"#{track}" for track in rows.ints("track_id").tolist()]


def _one_sigma_boxes(rows: Columns) -> FloatArray:
    """Boxes of the centre's position within one standard deviation of the innovation, shape (n, 4), px."""
    boxes = rows.boxes()
    covariances = [np.full(16, np.nan) if one is None else one for one in rows.vectors("covariance")]
    spread = np.sqrt(np.maximum(np.reshape(covariances, (-1, 4, 4))[:, [0, 1], [0, 1]], 0.0))
    centres = (boxes[:, :2] + boxes[:, 2:]) / 2
    return np.hstack([centres - spread, centres + spread])


def _result_texts(rows: Columns, seen: IntArray, classes: RecordedClasses) -> list[str]:
    shares = ["" if share != share else f" {100 * share:.0f} %" for share in rows.floats("recognitions.share").tolist()]
    states = ["" if state == "confirmed" else f" {state}" for state in rows.texts("state")]
    names = [classes.short_name(None if number < 0 else number) for number in seen.tolist()]
    found = zip(_track_names(rows), names, shares, states, rows.texts("source"), strict=True)
    return [f"{of} {name}{share}{state} {source}" for of, name, share, state, source in found]


def _gate_text(l_positive: str, confident: object) -> str:
    return "" if confident is None else f"L {l_positive} {'confident' if confident else 'rejected'}"


def _number_texts(rows: Columns, name: str) -> list[str]:
    return ["-" if value != value else f"{value:.3g}" for value in rows.floats(name).tolist()]
