"""From evidence to the columns of a recording, for one range of frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np

from tsr_engine.errors import UsageError
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.recording.classes import RecordedClasses
from tsr_engine.recording.content import BoxRows, Frames, Lines, Moments, Series

__all__ = ["LEADING", "box_layers", "events", "frames_of", "track_lines"]

LEADING = 5
"""Most classes whose votes are drawn."""

Row = tuple[Any, ...]


def frames_of(reader: EvidenceReader, first: int | None, stop: int | None, called: str = "the run") -> Frames:
    """The frames ``first <= k < stop`` of a run; unset: from its first, to its last.

    Args:
        reader: of the run.
        first: first frame.
        stop: frame after the last.
        called: what a refusal calls the run.

    Raises:
        UsageError: the run has not stored all of them.
    """
    low, high = reader.first_frame, reader.last_frame
    who = f"{called[:1].upper()}{called[1:]}"
    if low is None or high is None:
        raise UsageError(f"{who} has stored no frame yet. Wait for the run, or choose another one.")
    start, end = low if first is None else first, high + 1 if stop is None else stop
    if not low <= start < end <= high + 1:
        raise UsageError(
            f"{who} has stored the frames {low} to {high}, so a range is within {low}:{high + 1} and not "
            f"empty. Got {start}:{end}."
        )
    rows = reader.query(
        "SELECT frame, seconds, pts, width, height FROM frames WHERE frame >= ? AND frame < ? ORDER BY frame",
        (start, end),
    )
    return Frames(
        ordinal=np.array([row[0] for row in rows], np.int64),
        seconds=np.array([row[1] for row in rows], np.float64),
        pts=np.array([-1 if row[2] is None else row[2] for row in rows], np.int64),
        width=int(rows[0][3]),
        height=int(rows[0][4]),
    )


def box_layers(reader: EvidenceReader, frames: Frames, classes: RecordedClasses) -> Iterator[tuple[str, BoxRows]]:
    """Name and boxes of every layer that the engine made; each is read when it is asked for."""
    span = (frames.first, frames.first + len(frames))
    found = reader.query(
        "SELECT frame, x1, y1, x2, y2, raw_score, prior, score FROM detections WHERE frame >= ? AND frame < ? "
        "ORDER BY frame, row",
        span,
    )
    yield "detections_raw", _rows(found, [_figure(row[5]) for row in found])
    yield "detections", _rows(found, [f"{_figure(row[7])} (prior {_figure(row[6])})" for row in found])

    found = reader.query(
        "SELECT p.frame, p.x1, p.y1, p.x2, p.y2, p.track_id, g.l_positive, g.confident, p.covariance "
        "FROM predictions p LEFT JOIN gates g ON g.frame = p.frame AND g.track_id = p.track_id "
        "JOIN track_frames t ON t.frame = p.frame AND t.track_id = p.track_id "
        "WHERE p.frame >= ? AND p.frame < ? AND t.state <> 'dead' ORDER BY p.frame, p.track_id",
        span,
    )
    yield "predictions", _rows(found, [f"#{row[5]} {_verdict(row[6], row[7])}".rstrip() for row in found])
    yield "innovation", _rows([(row[0], *_one_sigma(row)) for row in found], [f"#{row[5]} 1 sigma" for row in found])

    found = reader.query(
        "SELECT r.frame, r.search_x1, r.search_y1, r.search_x2, r.search_y2, r.x1, r.y1, r.x2, r.y2, r.runner_up_x1, "
        "r.runner_up_y1, r.runner_up_x2, r.runner_up_y2, r.track_id, r.decision, r.probability, "
        "r.runner_up_decision, r.windows "
        "FROM relocalisations r JOIN track_frames t ON t.frame = r.frame AND t.track_id = r.track_id "
        "WHERE r.frame >= ? AND r.frame < ? AND t.state <> 'dead' ORDER BY r.frame, r.track_id",
        span,
    )
    yield "search", _rows(found, [f"#{row[13]} {row[17]} windows" for row in found])
    texts = [f"#{row[13]} {_figure(row[14])} (P {_figure(row[15])})" for row in found]
    yield "relocalisations", _rows([(row[0], *row[5:9]) for row in found], texts)
    texts = [f"#{row[13]} {_figure(row[16])}" for row in found]
    yield "runner_up", _rows([(row[0], *row[9:13]) for row in found], texts)

    found = reader.query(
        "SELECT t.frame, t.x1, t.y1, t.x2, t.y2, t.track_id, t.state, t.source, r.class_id, r.share "
        "FROM track_frames t LEFT JOIN recognitions r ON r.frame = t.frame AND r.track_id = t.track_id "
        "WHERE t.frame >= ? AND t.frame < ? AND t.state <> 'dead' ORDER BY t.frame, t.row",
        span,
    )
    results = _rows(found, [_result(row, classes) for row in found])
    seen = np.array([-1 if row[8] is None else row[8] for row in found], np.int64)
    yield "results", replace(results, class_id=seen)


def events(reader: EvidenceReader, frames: Frames) -> Moments:
    """What happened in the frames, in order."""
    rows = reader.query(
        "SELECT frame, kind, track_id, text FROM events WHERE frame >= ? AND frame < ? ORDER BY frame, row",
        (frames.first, frames.first + len(frames)),
    )
    return Moments(
        np.array([row[0] for row in rows], np.int64),
        tuple(row[1] for row in rows),
        tuple(f"#{row[2]}: {row[3]}" for row in rows),
    )


_LINES = """
SELECT t.track_id, t.frame, t.source, t.score, d.raw_score, d.prior, g.l_positive, g.symmetry, g.symmetry_magnitude,
       g.hash_distance, g.position_distance, s.decision, s.probability, r.scale, r.weight, r.votes
FROM track_frames t
JOIN tracks k ON k.track_id = t.track_id AND k.confirmed_frame IS NOT NULL
LEFT JOIN detections d ON d.frame = t.frame AND d.row = t.detection
LEFT JOIN gates g ON g.frame = t.frame AND g.track_id = t.track_id
LEFT JOIN relocalisations s ON s.frame = t.frame AND s.track_id = t.track_id
LEFT JOIN recognitions r ON r.frame = t.frame AND r.track_id = t.track_id
WHERE t.frame >= ? AND t.frame < ? AND t.state <> 'dead' ORDER BY t.track_id, t.frame
"""
_VALUES = {
    "gate/l_positive": 6,
    "gate/symmetry": 7,
    "gate/symmetry_magnitude": 8,
    "gate/hash_distance": 9,
    "gate/position_distance": 10,
    "svm/decision": 11,
    "svm/probability": 12,
    "fusion/scale": 13,
    "fusion/weight": 14,
}
_SCORES = ("with prior", "raw", "prior")


def track_lines(reader: EvidenceReader, frames: Frames, classes: RecordedClasses) -> Iterator[Lines]:
    """Values over time of every track that was ever confirmed and lives in the frames."""
    span = (frames.first, frames.first + len(frames))
    labels = dict(reader.query("SELECT track_id, class_id FROM tracks"))
    for track_id, group in groupby(reader.query(_LINES, span), key=lambda row: row[0]):
        rows = list(group)
        at = np.array([row[1] for row in rows], np.int64)
        values = {name: _one(at, [row[place] for row in rows], name) for name, place in _VALUES.items()}
        judged = values["gate/l_positive"]
        positive = judged.values[:, 0] > 0
        logs = np.log10(judged.values[positive])
        values["gate/log10_l_positive"] = Series(judged.at[positive], logs, ("log10 L",))
        values["score"] = Series(at, np.array([row[3:6] for row in rows], np.float64), _SCORES)
        values["votes"] = _votes(at, [row[15] for row in rows], classes)
        states = _states(at, [row[2] for row in rows], span[1])
        label = labels.get(track_id)
        kept = {name: series for name, series in values.items() if len(series.at)}
        yield Lines(track_id, -1 if label is None else label, kept, states)


def _votes(at: Any, blobs: list[bytes | None], classes: RecordedClasses) -> Series:
    """Share of each leading class in all votes so far."""
    have = [i for i, blob in enumerate(blobs) if blob is not None]
    if not have:
        return Series(at[:0], np.zeros((0, 0)), ())
    votes = np.stack([np.frombuffer(blobs[i] or b"", "<f8") for i in have])
    share = votes / np.maximum(votes.sum(axis=1, keepdims=True), 1e-300)
    leading = [c for c in np.argsort(-share.max(axis=0), kind="stable")[:LEADING].tolist() if share[:, c].max() > 0]
    return Series(at[have], share[:, leading], tuple(classes.title(c) for c in leading))


def _states(at: Any, sources: list[str], stop: int) -> tuple[Any, tuple[str, ...]]:
    """Where the source of a track's result changes; a gap, and its end within the range, are a state of their own."""
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


def _one(at: Any, values: list[float | None], name: str) -> Series:
    """One value over time, where it is known."""
    column = np.array(values, dtype=np.float64)
    keep = np.isfinite(column)
    return Series(at[keep], column[keep, None], (name.rpartition("/")[2].replace("_", " "),))


def _rows(rows: list[Row], labels: list[str]) -> BoxRows:
    """Rows that begin with frame and four edges, without a class."""
    table = np.array([row[:5] for row in rows], dtype=np.float64).reshape(-1, 5)
    ids = np.full(len(rows), -1)
    return BoxRows(table[:, 0].astype(np.int64), table[:, 1:].copy(), ids, tuple(labels))


def _one_sigma(row: Row) -> tuple[float, float, float, float]:
    """The box that the centre lies in with one standard deviation of the innovation to each side."""
    x1, y1, x2, y2 = (np.nan if value is None else value for value in row[1:5])
    spread = np.frombuffer(row[8], "<f8").reshape(4, 4).diagonal()[:2]
    sx, sy = np.sqrt(np.maximum(spread, 0.0)).tolist()
    cx, cy = (x1 + x2) / 2, (y1 + y2) / 2
    return cx - sx, cy - sy, cx + sx, cy + sy


def _result(row: Row, classes: RecordedClasses) -> str:
    share = "" if row[9] is None else f" {row[9]:.0%}"
    state = "" if row[6] == "confirmed" else f" {row[6]}"
    return f"#{row[5]} {classes.short(row[8])}{share}{state} {row[7]}"


def _verdict(l_positive: float | None, confident: int | None) -> str:
    if confident is None:
        return ""
    return f"L {_figure(l_positive)} {'confident' if confident else 'rejected'}"


def _figure(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
