"""Worse detections, tau by the paper's procedure, and the report on Fig. 11."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.corruptions.detections import MEAN_MISSED_RUN, Degradation, bisect_increasing, degrade
from benchmarks.experiment import Skip
from benchmarks.experiments import poor_detections
from benchmarks.experiments.gate import TAU
from benchmarks.experiments.poor_detections import KF, NO_RESCORING, merged, paper_tau, verdict
from benchmarks.videos.approaches import Approaches
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedFrame, DetectedVideo
from benchmarks.videos.tracked_clips import PAPER_KF
from tests import toy_pipeline
from tsr_engine.evaluation.tracking import VideoReport
from tsr_engine.records import Detections
from tsr_engine.track_table import TrackTable

FRAMES = 1500


def _seen() -> DetectedVideo:
    one = np.ones(2)
    boxes = np.array([[100.0, 80, 140, 100], [300, 80, 320, 120]])
    frames = tuple(DetectedFrame(k, k / 25, Detections(boxes, one, one, one), (0.0, 0.0)) for k in range(FRAMES))
    truth = TrackTable(np.array([0]), np.array([1]), boxes[:1], np.array([0]))
    return DetectedVideo(AnnotatedVideo("toy", "", Path("toy.mp4"), truth), 640, 360, 1 / 25, frames)


def test_misses_come_in_runs_of_the_wanted_length_and_number() -> None:
    frames = degrade(_seen(), Degradation(missed=0.4), 3).frames
    gone = np.array([not len(frame.detections) for frame in frames])
    assert abs(gone.mean() - 0.4) < 0.06
    runs = np.count_nonzero(gone[1:] & ~gone[:-1]) + gone[0]
    assert abs(gone.sum() / runs - MEAN_MISSED_RUN) < 0.9
    kept = next(frame for frame in frames if len(frame.detections))
    np.testing.assert_array_equal(kept.detections.boxes, _seen().frames[0].detections.boxes)


def test_edge_noise_scales_with_side_and_level() -> None:
    seen = _seen()
    at = seen.frames[0].detections.boxes

    def off(jitter: float) -> np.ndarray:
        frames = degrade(seen, Degradation(jitter=jitter), 0).frames
        return np.array([frame.detections.boxes - at for frame in frames])

    small = off(0.1)
    sides = np.array([[40, 20, 40, 20], [20, 40, 20, 40]])
    np.testing.assert_allclose(small.std(axis=0) / sides, 0.1, atol=0.01)
    np.testing.assert_allclose(off(0.2), 2 * small, atol=1e-9)
    assert not off(0.0).any()


def test_the_least_value_that_reaches_a_figure_is_found() -> None:
    assert bisect_increasing(0.25, lambda value: value**2, 1.0, 12) == pytest.approx(0.5, abs=1e-3)
    assert bisect_increasing(2.0, lambda value: value**2, 1.0) == 1.0


def test_tau_is_chosen_only_with_enough_signs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = toy_pipeline.write_drive(tmp_path / "drive.mp4", 24)
    rows = [(k, box) for k in range(24) if (box := toy_pipeline.sign_box(k)) is not None]
    truth = TrackTable(
        np.array([k for k, _ in rows]), np.ones(len(rows), np.int64), np.array([box for _, box in rows]),
        np.zeros(len(rows), np.int64),
    )  # fmt: skip
    clips = Approaches(1, {"toy": (drive, truth)}, {"toy": "steady"}, frozenset(), {})
    with pytest.raises(Skip, match="tau is chosen on 100"):
        paper_tau(clips, 0)
    monkeypatch.setattr(poor_detections, "SIGNS", 2)
    tau, collected = paper_tau(clips, 0)
    assert TAU[0] <= tau <= TAU[-1]
    assert 0.5 <= collected <= 1.0


def _report(errors: list[float], followed: list[float]) -> VideoReport:
    return VideoReport("v", 9, (), tuple((e, "detected") for e in errors), tuple(followed), 1, (), 0)


def test_draws_of_one_video_count_as_one() -> None:
    reports = [_report([0.1], [0.5]), _report([0.3], []), _report([], [0.9]), _report([0.2], [0.8])]
    assert [[e for e, _ in r.errors] for r in merged(reports, 2)] == [[0.1, 0.3], [0.2]]
    assert [[e for e, _ in r.errors] for r in merged(reports, 2, followed=True)] == [[0.5], [0.9, 0.8]]


def test_the_claim_holds_only_where_an_interval_says_so() -> None:
    def change(low: float, high: float) -> dict[str, Any]:
        return {"change": {"change": (low + high) / 2, "low": low, "high": high}}

    rows = {
        PAPER_KF: {}, "paper, tau 15": change(0.01, 0.02), "paper, tau 80": change(-0.02, -0.01),
        KF: {}, NO_RESCORING: change(-0.01, 0.01), "default": change(-0.02, -0.01),
    }  # fmt: skip
    said = verdict({"kinds": {"boxes off": {"rows": rows}}})
    assert "holds with the paper's numbers on *boxes off* (paper, tau 80) and with `default`" in said
    assert "alone nowhere." in said
    assert "larger with the online detector: *boxes off* (paper, tau 15)." in said
    assert f"contains 0: *boxes off* ({NO_RESCORING})." in said
