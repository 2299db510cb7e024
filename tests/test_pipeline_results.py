"""Result rows during a run, against the store's rows of the same frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tsr_engine.evidence import EvidenceReader, EvidenceWriter, RunHeader, VideoIdentity
from tsr_engine.pipeline.results import ResultStream
from tsr_engine.records import Detections, FrameEvidence, Recognition, Source, TrackFrame, TrackState


def recognition(class_id: int, share: float = 0.6) -> Recognition:
    votes = np.zeros(43)
    votes[class_id] = 1.0
    return Recognition(np.full(43, 1 / 43, np.float32), 30.0, 0.5, votes, class_id, share, (class_id + 1) % 43)


def track(
    track_id: int,
    state: TrackState = "confirmed",
    source: Source = "detected",
    class_id: int | None = 1,
    x: float = 10.0,
) -> TrackFrame:
    return TrackFrame(
        track_id=track_id,
        state=state,
        source=source,
        box=np.array([x, 20.123456, x + 30.5, 50.0]),
        score=1.23456789,
        prediction=None,
        detection=None,
        gate=None,
        relocalisation=None,
        samples=(),
        recognition=None if class_id is None or state == "dead" else recognition(class_id),
    )


def frame(ordinal: int, *tracks: TrackFrame) -> FrameEvidence:
    return FrameEvidence(ordinal, ordinal / 25, 640, 480, Detections.empty(), (0.0, 0.0), tracks, (), (), {})


DRIVE = [
    frame(0, track(1, "tentative", class_id=3)),
    frame(1, track(1, "tentative", class_id=3), track(2, "tentative")),
    frame(2, track(1, class_id=4), track(2, "dead")),
    frame(3, track(1, source="predicted", class_id=7, x=11.0), track(3, class_id=None)),
    frame(4, track(1, "dead"), track(3, source="relocalised", class_id=None)),
    frame(5),
    frame(6, track(4, "tentative")),
    frame(7, track(4, class_id=9)),
]


def run(frames: list[FrameEvidence]) -> tuple[list[tuple[int, int, int]], ResultStream]:
    stream = ResultStream()
    rows = [row for item in frames for row in stream.add(item)]
    rows += list(stream.finish())
    return [(row.frame, row.track_id, row.class_id) for row in rows], stream


def test_rows_have_the_final_class_and_confirmed_tracks_only() -> None:
    rows, _ = run(DRIVE)
    assert rows == [(0, 1, 7), (1, 1, 7), (2, 1, 7), (3, 1, 7), (3, 3, -1), (4, 3, -1), (6, 4, 9), (7, 4, 9)]


def test_rows_equal_those_of_the_store(tmp_path: Path) -> None:
    header = RunHeader(VideoIdentity("a.mp4", "0" * 64, 1), {}, {})
    with EvidenceWriter.create(tmp_path / "run", header) as writer:
        for item in DRIVE:
            writer.append(item)
    stream = ResultStream()
    rows = [row for item in DRIVE for row in stream.add(item)] + list(stream.finish())
    with EvidenceReader(tmp_path / "run") as reader:
        assert list(reader.result_rows()) == rows


def test_a_row_is_released_as_soon_as_the_tracks_of_its_frame_have_ended() -> None:
    stream = ResultStream()
    assert [row.frame for item in DRIVE[:4] for row in stream.add(item)] == []
    assert [row.frame for row in stream.add(DRIVE[4])] == [0, 1, 2]
    assert [row.frame for row in stream.add(DRIVE[5])] == [3, 3, 4]


def test_memory_does_not_grow_with_the_number_of_tracks() -> None:
    stream = ResultStream()
    for k in range(3000):
        for _ in stream.add(frame(k, track(k // 3 + 1, "dead" if k % 3 == 2 else "tentative"))):
            pytest.fail("nothing was confirmed")
    assert len(stream._waiting) + len(stream._live) + len(stream._ended) < 10
    assert stream.tracks == []


def test_tracks_are_summarised() -> None:
    _, stream = run(DRIVE)
    assert [(t.track_id, t.first_frame, t.last_frame) for t in stream.tracks] == [(1, 0, 3), (3, 3, 4), (4, 6, 7)]
    first = stream.tracks[0]
    assert dict(first.frames) == {"detected": 3, "predicted": 1}
    assert first.largest_side == pytest.approx(30.5)
