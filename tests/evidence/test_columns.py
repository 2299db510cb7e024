"""Columns by name have the values of the records, and no names outside the schema."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.evidence.synthetic_evidence import make_frame
from tsr_engine.evidence.columns import (
    BOX,
    count,
    frame_size,
    read_columns,
    read_end_boxes,
    read_runners_up,
    sample_detections,
)
from tsr_engine.evidence.header import RunHeader
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.evidence.writer import EvidenceWriter
from tsr_engine.records import FrameEvidence
from tsr_engine.track_table import SOURCES

FRAMES = 12


@pytest.fixture
def frames() -> list[FrameEvidence]:
    """Track 1 is confirmed; track 2 is never confirmed and has no detection. Both are dead in the last frame."""
    made = [make_frame(k) for k in range(FRAMES)]

    def state(track_id: int, k: int) -> str:
        return "dead" if k == FRAMES - 1 else "confirmed" if track_id == 1 and k > 2 else "tentative"

    return [
        replace(
            frame,
            tracks=tuple(
                replace(t, state=state(t.track_id, k), detection=t.detection if t.track_id == 1 else None)  # type: ignore[arg-type]
                for t in frame.tracks
            ),
        )
        for k, frame in enumerate(made)
    ]


@pytest.fixture
def reader(folder: Path, header: RunHeader, frames: list[FrameEvidence]) -> Any:
    with EvidenceWriter.create(folder, header) as writer:
        for frame in frames:
            writer.append(frame)
    with EvidenceReader(folder) as reader:
        yield reader


def test_columns_are_those_of_the_records(reader: EvidenceReader, frames: list[FrameEvidence]) -> None:
    names = ("frame", "track_id", "source", *BOX, "score", "gates.l_positive", "gates.confident", "recognitions.votes")
    rows = read_columns(reader, "track_frames", *names, "frames.width", frames=(2, 7))
    tracks = [(frame.ordinal, track) for frame in frames[2:7] for track in frame.tracks]
    assert len(rows) == len(tracks) > 5
    assert rows.ints("frame").tolist() == [k for k, _ in tracks]
    assert rows.ints("track_id").tolist() == [t.track_id for _, t in tracks]
    assert [SOURCES[code] for code in rows.sources()] == rows.texts("source") == [t.source for _, t in tracks]
    np.testing.assert_array_equal(rows.boxes(), [t.box for _, t in tracks])
    assert set(rows.ints("frames.width").tolist()) == {frames[0].width}
    np.testing.assert_array_equal(rows.floats("score"), [t.score for _, t in tracks])
    np.testing.assert_array_equal(
        rows.floats("gates.l_positive"), [np.nan if t.gate is None else t.gate.l_positive for _, t in tracks]
    )
    assert rows.has_value("gates.confident").tolist() == [t.gate is not None for _, t in tracks]
    assert rows.ints("gates.confident", missing=7).tolist() == [
        7 if t.gate is None else t.gate.confident for _, t in tracks
    ]
    for votes, (_, track) in zip(rows.vectors("recognitions.votes"), tracks, strict=True):
        assert (votes is None) == (track.recognition is None)
        if votes is not None and track.recognition is not None:
            np.testing.assert_array_equal(votes, track.recognition.votes)


def test_filters_and_orders(reader: EvidenceReader) -> None:
    every = read_columns(reader, "track_frames", "frame", "track_id", "state")
    alive = read_columns(reader, "track_frames", "frame", "track_id", alive=True)
    assert len(every) - len(alive) == every.texts("state").count("dead") == 2
    confirmed = read_columns(reader, "track_frames", "track_id", confirmed=True)
    assert set(confirmed.ints("track_id").tolist()) == {1}
    assert read_columns(reader, "tracks", "track_id", confirmed=True).ints("track_id").tolist() == [1]
    assert read_columns(reader, "tracks", "track_id", order="track").ints("track_id").tolist() == [1, 2]
    by_track = read_columns(reader, "track_frames", "frame", "track_id", order="track")
    pairs = list(zip(by_track.ints("track_id").tolist(), by_track.ints("frame").tolist(), strict=True))
    assert pairs == sorted(pairs)
    assert set(read_columns(reader, "gates", "track_id", tracks=(2, 2)).ints("track_id").tolist()) <= {2}
    nothing = read_columns(reader, "track_frames", "frame", *BOX, frames=(500, 600))
    assert (len(nothing), nothing.boxes().shape, nothing.ints("frame").shape) == (0, (0, 4), (0,))
    # the prediction in the frame of a track's death is not shown
    predicted = read_columns(reader, "predictions", "frame", alive=True)
    assert FRAMES - 1 not in predicted.ints("frame")


def test_unknown_columns_are_refused(reader: EvidenceReader) -> None:
    for table, name in (
        ("track_frames", "colour"),
        ("nothing", "frame"),
        ("nothing", "frames.width"),
        ("track_frames", "gates.x1; DROP"),
    ):
        with pytest.raises(ValueError, match="docs/evidence.md"):
            read_columns(reader, table, name)
    with pytest.raises(ValueError, match="no key in common"):
        read_columns(reader, "events", "frame", "gates.confident")
    options: tuple[dict[str, Any], ...] = ({"tracks": (1, 1)}, {"confirmed": True}, {"order": "track"})
    for table, wrong in (*(("detections", option) for option in options), ("tracks", {"frames": (0, 5)})):
        with pytest.raises(ValueError, match=f"{table} of evidence has no column"):
            read_columns(reader, table, f"{table}.{'score' if table == 'detections' else 'share'}", **wrong)
    with pytest.raises(ValueError, match="no table"):
        count(reader, "sqlite_master")
    with pytest.raises(KeyError):
        read_columns(reader, "frames", "frame").ints("width")


def test_summaries_of_confirmed_tracks(reader: EvidenceReader, frames: list[FrameEvidence]) -> None:
    track_frames = [(f.ordinal, t) for f in frames for t in f.tracks if t.track_id == 1 and t.state != "dead"]
    np.testing.assert_array_equal(read_end_boxes(reader, "first_frame"), [track_frames[0][1].box])
    np.testing.assert_array_equal(read_end_boxes(reader, "last_frame"), [track_frames[-1][1].box])
    (second,), (share,) = read_runners_up(reader)
    known = [t.recognition for _, t in track_frames if t.recognition is not None]
    assert second == known[-1].runner_up
    assert share == pytest.approx(known[-1].votes[second] / known[-1].votes.sum())
    assert frame_size(reader) == frame_size(reader, 3) == (frames[0].width, frames[0].height)
    assert frame_size(reader, 999) is None


def test_detections_are_spread_over_the_run(reader: EvidenceReader, frames: list[FrameEvidence]) -> None:
    total = sum(len(frame.detections.boxes) for frame in frames)
    rows, said = sample_detections(reader, 10**6)
    assert (len(rows), said, count(reader, "detections")) == (total, total, total)
    boxes = np.concatenate([frame.detections.boxes for frame in frames])
    np.testing.assert_allclose(rows.floats("x"), (boxes[:, 0] + boxes[:, 2]) / 2)
    few, said = sample_detections(reader, total // 2)
    assert said == total
    assert 0 < len(few) <= total // 2
