"""Detection on several cores: the order, the number of frames in flight, failures, and equal runs."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from sample_videos import SHIPPED
from tests import pipeline_toys as toys
from tests.test_pipeline_run import assert_same_run
from tsr_engine.evidence import EvidenceReader
from tsr_engine.io.cores import usable_cores
from tsr_engine.params import Params
from tsr_engine.pipeline import detected_ahead, load_components
from tsr_engine.records import Detections
from tsr_engine.runs.live import RunRequest, track_video
from tsr_engine.runs.replay import ReplayReport, replay

FRAMES = 40


@dataclass(frozen=True)
class Numbered:
    """A frame that is nothing but its number."""

    ordinal: int


def numbered(count: int, taken: list[int]) -> Iterator[tuple[Numbered, float]]:
    for k in range(count):
        taken.append(k)
        yield Numbered(k), float(k)


def score_of(frame: Numbered) -> Detections:
    """Detections whose score is the frame's number; even frames take longer than odd ones."""
    time.sleep(0.01 if frame.ordinal % 2 == 0 else 0)
    score = np.array([float(frame.ordinal)])
    return Detections(np.array([[0.0, 0.0, 1.0, 1.0]]), score, score, score)


@pytest.mark.parametrize("cores", [1, 2, 5])
def test_frames_come_in_order_with_their_own_detections(cores: int) -> None:
    taken: list[int] = []
    most = 0
    for place, (frame, number, found) in enumerate(detected_ahead(numbered(FRAMES, taken), score_of, cores)):
        assert found is not None
        assert frame.ordinal == place == number == found[0].raw_scores[0]
        assert found[1] >= 0
        most = max(most, len(taken) - place)
    assert taken == list(range(FRAMES))
    assert most <= (1 if cores == 1 else cores + 2)


def test_several_are_detected_at_a_time() -> None:
    both = threading.Barrier(2, timeout=30)

    def detect(frame: Numbered) -> Detections:
        both.wait()
        return score_of(frame)

    assert len(list(detected_ahead(numbered(6, []), detect, 2))) == 6


def test_frames_that_nobody_wants_are_not_detected() -> None:
    seen: list[int] = []

    def detect(frame: Numbered) -> Detections:
        seen.append(frame.ordinal)
        return score_of(frame)

    rows = list(detected_ahead(numbered(8, []), detect, 2, lambda frame: frame.ordinal >= 5))
    assert [row[2] is None for row in rows] == [True] * 5 + [False] * 3
    assert sorted(seen) == [5, 6, 7]


@pytest.mark.parametrize("cores", [1, 3])
def test_a_failure_comes_after_the_frames_before_it(cores: int) -> None:
    def detect(frame: Numbered) -> Detections:
        if frame.ordinal == 7:
            raise ValueError("seven")
        return score_of(frame)

    done = []
    with pytest.raises(ValueError, match="seven"):
        done.extend(frame.ordinal for frame, _, _ in detected_ahead(numbered(FRAMES, []), detect, cores))
    before = threading.active_count()
    rows = detected_ahead(numbered(FRAMES, []), score_of, cores)
    next(rows)
    rows.close()  # type: ignore[attr-defined]
    assert threading.active_count() <= before


def test_the_number_of_cores_is_checked() -> None:
    assert usable_cores() >= 1
    with pytest.raises(ValueError, match="at least 1"):
        next(detected_ahead(numbered(1, []), score_of, 0))


def test_a_run_on_several_cores_stores_the_same(tmp_path: Path) -> None:
    drive = toys.write_drive(tmp_path / "drive.mp4", 60)
    one = RunRequest(drive, toys.PARAMS, tmp_path / "one", tmp_path / "one.csv")
    many = replace(one, evidence=tmp_path / "many", csv=tmp_path / "many.csv", cores=3)
    for request in (one, many):
        track_video(request, toys.components(toys.PARAMS))
    assert_same_run(tmp_path / "one", tmp_path / "many")
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "many.csv").read_bytes()


def test_a_run_on_several_cores_goes_on_after_a_stop(tmp_path: Path) -> None:
    drive = toys.write_drive(tmp_path / "drive.mp4", 60)
    whole = RunRequest(drive, toys.PARAMS, tmp_path / "whole")
    track_video(whole, toys.components(toys.PARAMS))
    asked = 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > 31

    parts = replace(whole, evidence=tmp_path / "parts", cores=2)
    assert track_video(parts, toys.components(toys.PARAMS), stop=stop).interrupted
    report = track_video(parts, toys.components(toys.PARAMS))
    assert report.resumed_at is not None
    assert report.computed < 60
    assert_same_run(tmp_path / "whole", tmp_path / "parts")


@pytest.mark.parametrize("preset", ["default", "realtime"])
def test_the_shipped_models_find_the_same_on_several_cores(preset: str, tmp_path: Path) -> None:
    params = Params.preset(preset).with_settings([("coast_foe_y", 0.5)])
    parts = load_components(params)
    for cores in (1, 3):
        request = RunRequest(SHIPPED[0].video, params, tmp_path / str(cores), stop=24, cores=cores)
        track_video(request, parts)
    assert_same_run(tmp_path / "1", tmp_path / "3")
    with EvidenceReader(tmp_path / "3") as reader:
        assert sum(len(frame.detections) for frame in reader.frames()) > 0


def test_a_scan_in_turn_goes_on_and_replays_as_it_was(tmp_path: Path) -> None:
    params = Params.preset("realtime").with_settings([("coast_foe_y", 0.5)])
    parts, asked = load_components(params), 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > 19

    whole = RunRequest(SHIPPED[0].video, params, tmp_path / "whole", start=1, stop=25)
    track_video(whole, parts)
    halved = replace(whole, evidence=tmp_path / "halved")
    assert track_video(halved, parts, stop=stop).interrupted
    track_video(halved, parts)
    assert_same_run(tmp_path / "whole", tmp_path / "halved")
    report = ReplayReport()
    frames = list(replay(tmp_path / "whole", params, parts, report=report))
    assert any(frame.tracks for frame in frames)
    assert report.identical == len(frames) == 24
