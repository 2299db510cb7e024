"""Videos reduced to some of their frames, and the report on them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.experiment import Result
from benchmarks.experiments import frame_rates
from benchmarks.tuning import confirmation
from benchmarks.videos.engine_tracker import filter_alone
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedFrame, DetectedVideo, every_nth_frame_of
from tsr_engine.evaluation.tracking import evaluate_video, summarise
from tsr_engine.params import Params
from tsr_engine.records import Detections
from tsr_engine.track_table import TrackTable

FRAMES = 30


def _box(frame: int) -> np.ndarray:
    """A sign that looms, to the upper right of the focus of expansion."""
    side = 20.0 / (1.0 - 0.02 * frame)
    x, y = 320 + 3 * side, 180 - 2 * side
    return np.array([x, y, x + side, y + side])


def _seen() -> DetectedVideo:
    one = np.ones(1)
    frames = tuple(
        DetectedFrame(k, k / 30, Detections(_box(k)[None], 2 * one, one, 2 * one), (0.0, 0.25)) for k in range(FRAMES)
    )
    boxes = np.array([_box(k) for k in range(FRAMES)])
    n = FRAMES
    truth = TrackTable(np.arange(n), np.ones(n, int), boxes, np.zeros(n, int))
    return DetectedVideo(AnnotatedVideo("toy", "held out", Path("toy.mp4"), truth), 640, 360, 1 / 30, frames)


@pytest.mark.parametrize("step", [1, 3, 4])
def test_a_reduced_video_is_complete(step: int) -> None:
    seen, left = _seen(), every_nth_frame_of(_seen(), step)
    kept = range(0, FRAMES, step)
    assert [f.ordinal for f in left.frames] == list(range(len(kept)))
    assert [f.seconds for f in left.frames] == [seen.frames[k].seconds for k in kept]
    assert left.interval == pytest.approx(step / 30)
    assert [f.shift[1] for f in left.frames] == [0.25, *[0.25 * step] * (len(kept) - 1)]
    assert left.video.truth.frame.tolist() == list(range(len(kept)))
    assert np.array_equal(left.video.truth.boxes, seen.video.truth.boxes[::step])
    assert left.video.name == seen.video.name


@pytest.mark.parametrize("step", [1, 2, 4])
def test_the_filter_alone_follows_at_any_rate(step: int) -> None:
    left = every_nth_frame_of(_seen(), step)
    rows = filter_alone(left, Params.preset("default"))
    found = summarise([evaluate_video("toy", left.video.truth, rows, len(left.frames))])
    assert (found.coverage, found.ids_per_sign, found.false_tracks) == (1.0, 1.0, 0)
    assert found.mean_error is not None
    assert found.mean_error < 0.01


def test_a_sign_that_was_never_confirmed_has_no_rows() -> None:
    seen = _seen()
    once = Detections(_box(0)[None], np.array([2.0]), np.ones(1), np.array([2.0]))
    frames = (DetectedFrame(0, 0.0, once, (0, 0)), DetectedFrame(1, 1 / 30, Detections.empty(), (0, 0)))
    for left, tracked in ((frames, False), (seen.frames, True)):
        assert (len(filter_alone(DetectedVideo(seen.video, 640, 360, 1 / 30, left), Params()).frame) > 0) is tracked


def test_confirmation_is_chosen_per_rate_without_judged_scenes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, scenes in (("tuned", ("0", "1")), ("judged", ("1",))):
        clips = [{"clip": f"{scene}_turn", "stress": "turn", "image": f"{scene}.jpg"} for scene in scenes]
        for clip in clips:
            (tmp_path / name / clip["clip"]).mkdir(parents=True)
            (tmp_path / name / clip["clip"] / "gt.txt").write_text("1,1,10,10,20,20,1,3,1.0\n")
        (tmp_path / name / "clips.json").write_text(json.dumps({"seed": 9, "clips": clips}))
    looked: list[str] = []

    def look(videos: list[AnnotatedVideo], scratch: Path) -> list[DetectedVideo]:
        looked.extend(video.name for video in videos)
        return [replace(_seen(), video=replace(_seen().video, group=video.group)) for video in videos]

    monkeypatch.setattr(confirmation, "detect_videos", look)
    monkeypatch.setattr(confirmation, "read_clips", lambda folder: {})
    call = ["--clips", str(tmp_path), "--looming", str(tmp_path / "tuned"), "--judged", str(tmp_path / "judged")]
    assert confirmation.main([*call, "--setting", "strict:confirm_score=3,sure_score=4"]) == 0
    assert looked == ["0_turn"]
    reported = [line for line in capsys.readouterr().out.splitlines() if "approaches" in line]
    assert [line.split("approaches")[0].strip() for line in reported[::2]] == list(frame_rates.HEADINGS.values())
    for shipped, strict in zip(reported[::2], reported[1::2], strict=True):
        assert "default  1/1 signs, 0 false, coverage 1.0000, 1.000 ids" in shipped
        assert "strict   0/1 signs, 0 false, coverage 0.0000, 0.000 ids" in strict
    assert confirmation.main([*call, "--setting", "x:no_such=1"]) == 1
    assert "There is no parameter 'no_such'" in capsys.readouterr().err


def test_lower_figures_than_ours_are_named() -> None:
    def found(error: float | None) -> dict[str, Any]:
        return {"mean_error": error, "coverage": 0.5, "ids_per_sign": 1.0, "false_tracks": 0}

    steps = {
        "1": {"default": found(0.2), "values chosen at the full rate alone": found(0.1), "SORT": found(0.3)},
        "2": {"default": found(0.2), "values chosen at the full rate alone": found(0.4), "SORT": found(0.3)},
    }
    about = {"processor": "x", "cores": 1, "load": 0, "commit": "c", "python": "3", "packages": {}}
    reported = frame_rates.EXPERIMENT.report(
        Result(
            "frame_rates", data="", figures={"groups": {"held out": steps}, "missing": {}}, settings={}, machine=about
        )
    )
    both = "0.2000 (50.0 % covered) against 0.1000 (50.0 % covered)"
    assert f"- held out, every frame: {both} of values chosen at the full rate alone" in reported
    assert reported.count("\n- ") == 1
    assert "| held out | every frame | every 2nd |" in reported
    assert "| SORT | 0.3000, 50.0 %, 1.00 | 0.3000, 50.0 %, 1.00 |" in reported
