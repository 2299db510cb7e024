"""Gaps: where they start, that they have no detections, and the report on who keeps the sign."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from benchmarks.experiment import Result
from benchmarks.experiments import gaps
from benchmarks.peers import detection_gaps as gap_module
from benchmarks.peers.detection_gaps import (
    LEAD_IN,
    Gap,
    Outcome,
    StationaryBox,
    find_gaps,
    follow_gap,
    our_outcomes,
    summary,
)
from benchmarks.peers.multi_object_trackers import Missing
from benchmarks.peers.opencv_trackers import OpenCvTracker, maker
from benchmarks.tuning import gaps as gap_tuning
from benchmarks.tuning import online as online_tuning
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedFrame, DetectedVideo
from benchmarks.videos.tracked_clips import Tracked
from tsr_engine.evidence import ResultRow
from tsr_engine.params import Params
from tsr_engine.pipeline import FrameInput
from tsr_engine.records import Detections, FrameEvidence, TrackFrame
from tsr_engine.track_table import TrackTable

FRAMES = 40


def _box(k: int) -> Any:
    return np.array([100.0 + 2 * k, 50.0, 140.0 + 2 * k, 90.0])


def _seen(unseen: range = range(0), frames: int = FRAMES) -> DetectedVideo:
    made = []
    for k in range(frames):
        n = 0 if k in unseen else 1
        one = np.ones(n)
        made.append(DetectedFrame(k, k / 30, Detections(_box(k)[None][:n], one, one, one), (1.0, 0.0)))
    truth = TrackTable(
        np.arange(frames),
        np.full(frames, 4),
        np.array([_box(k) for k in range(frames)]),
        np.zeros(frames, int),
    )
    return DetectedVideo(AnnotatedVideo("toy", "held out", Path("toy.mp4"), truth), 640, 360, 1 / 30, tuple(made))


def test_gaps_start_on_detections_after_the_lead_in() -> None:
    found = find_gaps(_seen(range(LEAD_IN - 1, LEAD_IN + 1)), every=8)
    assert [g.first for g in found] == [13, 21, 29]
    assert [sorted(g.ends) for g in found] == [[5, 10, 20], [5, 10], [5, 10]]
    assert found[0].ends[20].tolist() == _box(33).tolist()
    assert found[0].box.tolist() == _box(13).tolist()
    assert find_gaps(_seen(range(FRAMES)), every=8) == []
    assert find_gaps(_seen(frames=LEAD_IN + 4), every=8) == []


def test_a_still_box_falls_behind() -> None:
    where = find_gaps(_seen(), every=100)[0]
    pictures = [np.zeros((360, 640, 3), np.uint8)] * FRAMES
    outcomes, seconds = follow_gap(StationaryBox, pictures, where, where.box)
    assert [o.length for o in outcomes] == [5, 10, 20]
    assert [o.error for o in outcomes] == pytest.approx([0.25, 0.5, 1.0])
    assert seconds >= 0
    means = summary([*outcomes, *outcomes], 10)
    assert means == {"gaps": 2, "error": 0.5, "iou": pytest.approx(1 / 3), "held": 0.0, "lost": 0}
    assert summary(outcomes, 7) == {"gaps": 0}


class _RecordingCore:
    """Takes down what it is given; its one track moves by the camera's shift."""

    given: list[FrameInput]

    def __init__(self, last: int) -> None:
        self.given, self.last = [], last

    def step(self, frame: FrameInput) -> FrameEvidence:
        self.given.append(frame)
        state = "confirmed" if frame.ordinal <= self.last else "dead"
        track = TrackFrame(
            track_id=3, state=state, source="predicted", box=_box(frame.ordinal) + 4.0, score=1.0, prediction=None,
            detection=None, gate=None, relocalisation=None, samples=(), recognition=None,
        )  # fmt: skip
        return FrameEvidence(
            ordinal=frame.ordinal, seconds=frame.seconds, width=640, height=360, detections=frame.detections,
            shift=frame.shift, tracks=(track,), events=(), regions=(), timings={},
        )  # fmt: skip


def test_our_tracker_gets_no_detection_in_a_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = _seen()
    where = find_gaps(seen, every=100)[0]
    core = _RecordingCore(last=where.first + 12)
    monkeypatch.setattr(gap_module, "start", lambda *_: core)
    pictures = [np.zeros((360, 640, 3), np.uint8)] * FRAMES
    params: Any = Params.preset("default")
    outcomes, _ = our_outcomes(seen, pictures, where, params, None)  # type: ignore[arg-type]
    numbers = [frame.ordinal for frame in core.given]
    assert numbers == list(range(where.first - LEAD_IN + 1, where.first + 21))
    assert all(len(f.detections) == (f.ordinal <= where.first) for f in core.given)
    assert {f.shift for f in core.given} == {(1.0, 0.0)}
    assert [o.lost for o in outcomes] == [False, False, True]  # it died after 12 frames
    assert outcomes[0].error == pytest.approx(1 - 36 * 36 / 1600)
    assert (outcomes[2].error, outcomes[2].iou) == (1.0, 0.0)


def test_a_track_elsewhere_does_not_count_for_the_sign(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = _seen()
    start = find_gaps(seen, every=100)[0]
    away = Gap(start.sign, start.first, start.box + 300.0, start.ends)
    monkeypatch.setattr(gap_module, "start", lambda *_: _RecordingCore(last=FRAMES))
    pictures = [np.zeros((360, 640, 3), np.uint8)] * FRAMES
    outcomes, _ = our_outcomes(seen, pictures, away, Params.preset("paper"), None)  # type: ignore[arg-type]
    assert all(o.lost for o in outcomes)


def test_opencv_follows_a_moving_square() -> None:
    if not hasattr(cv2, "TrackerMIL_create"):
        pytest.skip("the installed OpenCV has no TrackerMIL")
    rng = np.random.default_rng(0)
    pictures = []
    for k in range(4):
        picture = rng.integers(0, 40, (120, 200, 3)).astype(np.uint8)
        cv2.rectangle(picture, (60 + 2 * k, 40), (90 + 2 * k, 70), (0, 0, 255), -1)
        pictures.append(picture)
    cv2.setRNGSeed(1)
    tracker = maker("MIL")()
    tracker.start(pictures[0], np.array([60.0, 40.0, 91.0, 71.0]))
    box = [tracker.step(p) for p in pictures[1:]][-1]
    assert box is not None
    assert abs(box[:2] - [66, 40]).max() <= 6


def test_a_box_over_the_edge_is_started_inside() -> None:
    class Fake:
        def init(self, picture: Any, box: tuple[int, ...]) -> None:
            self.box = box

        def update(self, picture: Any) -> tuple[bool, tuple[int, ...]]:
            return False, (0, 0, 0, 0)

    fake = Fake()
    tracker = OpenCvTracker(fake)
    tracker.start(np.zeros((100, 100, 3), np.uint8), np.array([-5.0, 90.0, 20.0, 130.0]))
    assert fake.box == (0, 90, 20, 10)
    assert tracker.step(np.zeros((100, 100, 3), np.uint8)) is None


def test_trackers_missing_from_the_wheel_are_named() -> None:
    with pytest.raises(Missing, match="TrackerRequest"):
        maker("Request")
    if hasattr(cv2, "TrackerVit_create"):
        with pytest.raises(Missing, match="TrackerVit is a network"):
            maker("Vit")


def _row(error: float) -> dict[str, Any]:
    one = {"gaps": 2, "error": error, "iou": 1 - error, "held": 1.0, "lost": 0}
    return {"5": one, "10": one, "20": {"gaps": 0}, "ms": 3.0}


def test_the_report_says_who_ends_nearer(tmp_path: Path) -> None:
    rows = {"CSRT": _row(0.1), "KF alone": _row(0.15), "default": _row(0.2), "paper": _row(0.3)}
    missing = {"Vit": "TrackerVit is a network."}
    result = Result("gaps", "toys", {"groups": {"held out": rows}, "missing": missing})
    text = gaps.EXPERIMENT.report(result)
    assert "- held out, 5 frames: ours ends with 0.2000, CSRT with 0.1000, KF alone with 0.1500\n" in text
    assert text.index("| default |") < text.index("| CSRT |")
    assert "*Skipped:* Vit: TrackerVit is a network." in text
    assert "| - |" in text  # no gap of 20 frames
    del rows["CSRT"], rows["KF alone"]
    assert "`default` ends nearest" in gaps.EXPERIMENT.report(result)
    rows["default, camera unknown"] = _row(0.15)
    text = gaps.EXPERIMENT.report(result)
    better = "`default, camera unknown` ends nearer than `default` at: held out, 5 frames: 0.1500 against 0.2000; "
    assert better in text
    assert gaps.EXPERIMENT.plot is not None
    gaps.EXPERIMENT.plot(result, tmp_path / "gaps.svg")
    assert "<svg" in (tmp_path / "gaps.svg").read_text()


def test_the_report_names_stresses_where_the_filter_alone_is_nearer() -> None:
    def row(*errors: float) -> dict[str, Any]:
        return {str(n): {"gaps": 3, "error": e} for n, e in zip((5, 10), errors, strict=True)} | {"20": {"gaps": 0}}

    rows = {"default": _row(0.1), "paper": _row(0.3)}
    worse, better = row(0.07, 0.08), row(0.06, 0.05)
    stresses = {"turn": {"default": better, "KF alone": worse, gaps.PAPER_KF: row(0.3, 0.4)}}
    figures = {"groups": {"approaches": rows}, "missing": {}, "stresses": stresses}
    text = gaps.EXPERIMENT.report(Result("gaps", "toys", figures))
    assert "| turn (3, 3, 0) | 0.0600 | 0.0700 | 0.3000 | 0.0500 | 0.0800 | 0.4000 |" in text
    assert (
        "nearer with the online detector than with KF alone, under every stress after any number of frames.\n" in text
    )
    stresses["blur"] = {"default": row(0.07, 0.05), "KF alone": row(0.07, 0.08), gaps.PAPER_KF: worse}
    text = gaps.EXPERIMENT.report(Result("gaps", "toys", figures))
    assert (
        "nearer with the online detector than with KF alone, except for blur, 5 frames: 0.0700 against 0.0700.\n"
        in text
    )


def _approaches(folder: Path, *scenes: str) -> Path:
    """Clips without a sign, one per scene; each access is noted."""
    clips = [{"clip": f"{name}_turn", "stress": "turn", "image": f"{name}.jpg"} for name in scenes]
    for clip in clips:
        (folder / clip["clip"]).mkdir(parents=True)
        (folder / clip["clip"] / "gt.txt").write_text("1,1,10,10,20,20,1,3,1.0\n")
    (folder / "clips.json").write_text(json.dumps({"seed": 9, "clips": clips}))
    return folder


def test_tuning_uses_no_judged_scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    looked: list[str] = []

    def look(videos: list[AnnotatedVideo], scratch: Path) -> list[DetectedVideo]:
        looked.extend(video.name for video in videos)
        return [_seen()]

    def end(seen: DetectedVideo, shown: object, gap: Gap, params: Params, parts: object) -> tuple[list[Outcome], float]:
        error = params.pipeline.search_noise / 10 if params.online.use_online else 0.5
        return [Outcome(length, error, 1 - error, False) for length in sorted(gap.ends)], 0.0

    monkeypatch.setattr(gap_tuning, "detect_videos", look)
    monkeypatch.setattr(gap_tuning, "our_outcomes", end)
    monkeypatch.setattr(gap_tuning, "pictures", lambda seen: [(frame, None) for frame in seen.frames])
    tuned, judged = _approaches(tmp_path / "a", "0", "1", "2", "3"), _approaches(tmp_path / "b", "2")
    call = ["--looming", str(tuned), "--judged", str(judged), "--every", "2", "--setting", "n:search_noise=1,tau=9"]
    assert gap_tuning.main(call) == 0
    assert looked == ["0_turn", "3_turn"]
    reported = {line.split("  ")[0].strip(): line for line in capsys.readouterr().out.splitlines()}
    assert reported.keys() == {"default", "KF alone", "n"}
    assert "5 frames: 0.1000, 100.0% of 3" in reported["n"]
    assert "5 frames: 0.5000" in reported["KF alone"]


def test_wrong_options_of_tuning_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for call, sentence in (
        (["--looming", str(tmp_path)], "--looming needs --judged"),
        (["--clips", str(tmp_path), "--every", "0"], "--every must be 1 or more. Got 0 instead."),
    ):
        with pytest.raises(SystemExit):
            gap_tuning.main(call)
        assert sentence in capsys.readouterr().err
    assert gap_tuning.main(["--clips", str(tmp_path), "--setting", "x:no_such=1"]) == 1
    assert "There is no parameter 'no_such'" in capsys.readouterr().err


def test_tuning_of_the_online_detector_uses_no_judged_scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    looked: list[str] = []

    def look(videos: list[AnnotatedVideo], scratch: Path) -> list[DetectedVideo]:
        looked.extend(video.name for video in videos)
        return [replace(_seen(), video=replace(_seen().video, group=video.group)) for video in videos]

    def track(seen: DetectedVideo, chosen: Mapping[str, Params], parts: object) -> dict[str, Tracked]:
        """One track on the sign, with the error of the filter alone or of the setting."""
        runs = {}
        for name, params in chosen.items():
            off = 4.0 if not params.online.use_online else params.pipeline.search_noise
            boxes = [(frame.ordinal, _box(frame.ordinal) + off) for frame in seen.frames]
            rows = [ResultRow(k, 1, *box.tolist(), 0, 1.0, "detected") for k, box in boxes]
            runs[name] = Tracked(rows, {}, len(seen.frames))
        return runs

    monkeypatch.setattr(online_tuning, "detect_videos", look)
    monkeypatch.setattr(online_tuning, "track_together", track)
    monkeypatch.setattr(online_tuning, "load_components", lambda params: None)
    tuned = [_approaches(tmp_path / name, "0", scene) for name, scene in (("one", "1"), ("two", "2"))]
    judged = _approaches(tmp_path / "judged", "1")
    call = ["--looming", *map(str, tuned), "--judged", str(judged)]
    assert online_tuning.main([*call, "--setting", "near:search_noise=1", "--setting", "same:search_noise=4"]) == 0
    assert looked == ["one/0_turn", "two/0_turn", "two/2_turn"]
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:2] for line in lines[:4]] == [["turn", n] for n in ("default", "KF", "near", "same")]
    assert [line.split()[0] for line in lines[4:]] == ["all"] * 4
    frames = 3 * len(_seen().frames)
    error = [1 - (40 - off) ** 2 / 1600 for off in (3.0, 4.0, 1.0)]
    assert lines[0].endswith(f"Eq. 7 {error[0]:.4f}, {frames} boxes changed: {error[0]:.4f}, without {error[1]:.4f}")
    assert lines[1].endswith(f"KF alone  coverage 1.0000, Eq. 7 {error[1]:.4f}")
    assert f"near      coverage 1.0000, Eq. 7 {error[2]:.4f}, " in lines[2]
    assert lines[3].endswith(f"same      coverage 1.0000, Eq. 7 {error[1]:.4f}")
    assert online_tuning.main([*call, "--setting", "x:no_such=1"]) == 1
    assert "There is no parameter 'no_such'" in capsys.readouterr().err
    assert online_tuning.main(["--looming", str(judged), "--judged", str(judged)]) == 1
    assert "no clip of a scene that may be shown" in capsys.readouterr().err
