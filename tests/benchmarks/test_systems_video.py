"""Detections over a video against ground truth, and the report on who is ahead."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.cache import Cache
from benchmarks.experiment import Data, Result, Skip, machine
from benchmarks.experiments import detection, detection_video, systems
from benchmarks.systems.curves import RATES, columns_behind, curve_figures
from benchmarks.systems.detection_records import frame_from_record, frame_to_record
from benchmarks.systems.video_detections import (
    FrameGroundTruth,
    frame_ground_truths,
    track_with_filter,
    without_ignored,
)
from benchmarks.videos.stored_detections import DetectedFrame
from tests.benchmarks.drawn_scenes import drawn_scenes
from tsr_engine.evaluation.detection import score_detections
from tsr_engine.params import Params
from tsr_engine.records import Detections, Picture
from tsr_engine.track_table import TrackTable

SIGN = np.array([100.0, 100, 130, 130])


def _seen(ordinal: int, *rows: tuple[np.ndarray, float]) -> DetectedFrame:
    boxes = np.array([box for box, _ in rows], float).reshape(-1, 4)
    scores = np.array([score for _, score in rows], float)
    found = Detections(boxes, scores, np.full(len(rows), 0.5), scores)
    return DetectedFrame(ordinal, ordinal / 25, found, (0.01, 0.01))


def test_ignored_boxes_excuse_detections_but_keep_signs() -> None:
    truth = FrameGroundTruth(SIGN[None], np.array([[90.0, 90, 140, 140], [300, 300, 340, 340]]))
    boxes = np.array([SIGN, [310, 310, 330, 330], [400, 100, 430, 130]])
    kept, scores, signs = without_ignored(boxes, np.array([3.0, 2.0, 1.0]), truth)
    np.testing.assert_array_equal(kept, boxes[[0, 2]])  # the one inside an ignored box is gone
    np.testing.assert_array_equal(scores, [3.0, 1.0])
    assert len(signs) == 1


def test_narrow_signs_are_ignored() -> None:
    rows = np.array([[0.0, 0, 15, 15], [50, 50, 70, 70]])
    truth = TrackTable(np.array([4, 4]), np.array([1, 2]), rows, np.zeros(2, int))
    here, none = frame_ground_truths(truth, [4, 5], 16.0)
    np.testing.assert_array_equal(here.boxes, rows[1:])
    np.testing.assert_array_equal(here.ignored, rows[:1])
    assert len(none.boxes) == len(none.ignored) == 0


def test_a_track_counts_from_its_first_frame_and_through_gaps() -> None:
    frames = [_seen(k, (SIGN + k, 2.0)) if k != 5 else _seen(k) for k in range(10)]
    frames[2] = _seen(2, (SIGN + 2, 2.0), (np.array([400.0, 200, 430, 230]), 1.0))  # seen once: no track
    rows = track_with_filter(frames, (640, 480), Params().tracking)
    assert [len(row.boxes) for row in rows] == [1] * 10
    assert [bool(row.known[0]) for row in rows] == [False] + [True] * 9  # two sure detections confirm
    assert abs(rows[5].boxes[0] - (SIGN + 5)).max() < 4
    assert rows[5].scores[0] < rows[4].scores[0]


def test_no_frames_give_no_rows() -> None:
    assert track_with_filter([], (640, 480), Params().tracking) == []


def test_an_empty_curve_can_be_reported() -> None:
    empty = curve_figures(score_detections([(np.zeros((0, 4)), np.zeros(0), SIGN[None])]))
    assert empty["ap"] == 0
    assert empty["recall"] == []


def test_a_reduced_curve_keeps_every_find() -> None:
    signs = np.array([[40.0 * k, 0, 40.0 * k + 20, 20] for k in range(5)])
    false = np.array([[0.0, 500.0, 20.0, 520.0]])
    boxes = np.concatenate([signs[:2], false, signs[2:4], np.repeat(false, 5000, axis=0), signs[4:]])
    reported = curve_figures(score_detections([(boxes, np.linspace(9, 1, len(boxes)), signs)]))
    assert len(reported["recall"]) < 20
    drawn = list(zip(reported["recall"], reported["precision"], strict=True))
    assert (0.4, 1.0) in drawn  # before the first false one
    assert (0.8, 0.8) in drawn  # before the crowd
    assert drawn[-1] == (1.0, pytest.approx(5 / 5006, abs=1e-5))


def _curve(ap: float, recall: float, ms: float) -> dict[str, object]:
    at = dict.fromkeys(RATES, recall)
    return {"ap": ap, "recall_at": at, "recall": [0.0, recall], "precision": [1.0, 0.5], "ms": ms}


def test_who_is_ahead_is_named() -> None:
    columns = {"AP": (lambda row: row["ap"], 1), "time": (lambda row: row.get("ms"), -1)}
    curves = {"a": _curve(0.9, 0.9, 50), "b": _curve(0.8, 0.9, 20), "c": {"ap": 0.95}}
    assert columns_behind(curves, ("a",), columns) == ["AP: behind c", "time: behind b"]
    assert columns_behind(curves, ("a", "b", "c"), columns) == []


def test_the_report_names_where_a_peer_is_better(tmp_path: Path) -> None:
    ours = {name: _curve(0.9, 0.8, 50) for name in detection.OURS}
    for other, expected in (
        (_curve(0.8, 0.7, 90), "In no column of this table."),
        (_curve(0.8, 0.7, 40), "time a picture: behind HOG cascade."),
        (_curve(0.95, 0.7, 90), "AP: behind HOG cascade."),
    ):
        result = Result("detection", figures={"curves": ours | {"HOG cascade": other}, "missing": ""})
        assert expected in detection.EXPERIMENT.report(result)
    detection.EXPERIMENT.plot(result, tmp_path / "curves.svg")  # type: ignore[misc]
    assert (tmp_path / "curves.svg").read_text().count("<path") > 3


def test_untrained_systems_are_reported() -> None:
    ours = {name: _curve(0.9, 0.8, 50) for name in detection.OURS}
    text = detection.EXPERIMENT.report(Result("detection", figures={"curves": ours, "missing": "no crops."}))
    assert "The other systems are not here: no crops." in text
    assert "Where ours loses" not in text


def test_an_exceeded_budget_is_reported() -> None:
    record = {"scenes": 1, "signs": 2, "crops": 3, "positives": 4, "negatives": 5, "title": "slow one", "name": "s"}
    for seconds, expected in ((60, "and was met"), (6000, "which slow one overran")):
        figures = {"budget_minutes": 15, "systems": [record | {"cpu_seconds": seconds}]}
        assert expected in systems.EXPERIMENT.report(Result("systems", figures=figures, machine=machine()))


def test_cached_frames_are_exact() -> None:
    for seen in (_seen(3, (SIGN / 7, 2.0 / 3), (SIGN, 0.1)), _seen(4)):
        again = frame_from_record(json.loads(json.dumps(frame_to_record(seen))))
        for name in ("ordinal", "seconds", "shift"):
            assert getattr(again, name) == getattr(seen, name)
        np.testing.assert_array_equal(again.detections.boxes, seen.detections.boxes)
        np.testing.assert_array_equal(again.detections.scores, seen.detections.scores)


class _CountingDetector:
    """A detector of one sign that counts pictures."""

    name = "counting"

    def __init__(self, stop_at: int = 99) -> None:
        self.pictures, self.stop_at = 0, stop_at

    def detect(self, picture: Picture) -> Detections:
        self.pictures += 1
        if self.pictures > self.stop_at:
            raise KeyboardInterrupt
        return _seen(0, (SIGN, float(picture.mean()))).detections


def test_finished_scenes_are_not_searched_again(tmp_path: Path) -> None:
    scenes = drawn_scenes(tmp_path, 3)
    kept = Cache(tmp_path / "kept")
    stopped = {"a": _CountingDetector(), "b": _CountingDetector(stop_at=2)}  # b is stopped in the second scene
    with pytest.raises(KeyboardInterrupt):
        detection.detect_alternating(stopped, scenes, kept, ["models"])
    goes_on = {"a": _CountingDetector(), "b": _CountingDetector()}
    found, ms = detection.detect_alternating(goes_on, scenes, kept, ["models"])
    assert goes_on["a"].pictures == 3  # two scenes, and the first once more as warm-up
    whole, _ = detection.detect_alternating(
        {"a": _CountingDetector(), "b": _CountingDetector()}, scenes, Cache(None), ["models"]
    )
    assert set(ms) == {"a", "b"}
    for one, other in zip(found["b"], whole["b"], strict=True):
        for mine, theirs in zip(one, other, strict=True):
            np.testing.assert_array_equal(mine, theirs)
    others = {"a": _CountingDetector(), "b": _CountingDetector()}
    detection.detect_alternating(others, scenes, kept, ["other models"])
    assert others["a"].pictures == 4


def test_a_clip_is_processed_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    video = tmp_path / "clip.mp4"
    video.write_bytes(b"a clip")
    watched: list[Path] = []

    def watch(path: Path, _: object) -> dict[str, object]:
        watched.append(path)
        frames = [frame_to_record(_seen(k, (SIGN, 1.0))) for k in range(3)]
        return {"seen": {"ACF": frames, "ACF and prior": frames}, "times": [0.1, 0.2, 0.3], "size": [640, 480]}

    monkeypatch.setattr(detection_video, "detect_with_and_without_prior", watch)
    monkeypatch.setattr(detection_video, "load_components", lambda _: SimpleNamespace(models={"detector": "a digest"}))
    truth = TrackTable.empty()
    for _ in range(2):
        times: list[float] = []
        clip = detection_video.detected_clip(video, truth, times, Cache(tmp_path / "kept"))
        assert times == [0.1, 0.2, 0.3]
        assert [seen.ordinal for seen in clip.seen["ACF and prior"]] == [0, 1, 2]
    assert watched == [video]


def test_without_data_all_three_skip(tmp_path: Path) -> None:
    nowhere = Data(None, None, None, None, tmp_path)
    for experiment in (systems.EXPERIMENT, detection.EXPERIMENT, detection_video.EXPERIMENT):
        with pytest.raises(Skip, match="was not given"):
            experiment.run(nowhere)
