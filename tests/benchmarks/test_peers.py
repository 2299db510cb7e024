"""Peers get our boxes, our rules judge their rows, and the report names what is not installed."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.cache import Cache
from benchmarks.experiment import Data, Result, Skip
from benchmarks.experiments import trackers
from benchmarks.peers import multi_object_trackers, tuning
from benchmarks.peers.figures import sequence, trackeval_figures
from benchmarks.peers.multi_object_trackers import MIN_SCORE_SETTING, PEERS, Missing, Peer, confidence, track_with_peer
from benchmarks.videos.engine_tracker import TrackingResult
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedFrame, DetectedVideo
from tsr_engine.evaluation.tracking import changed_errors, evaluate_video, shared_errors
from tsr_engine.records import Detections
from tsr_engine.track_table import TrackTable

FRAMES = 12


def _truth(boxes: list[tuple[int, int, tuple[float, ...], bool]]) -> TrackTable:
    n = len(boxes)
    return TrackTable(
        np.array([b[0] for b in boxes], int),
        np.array([b[1] for b in boxes], int),
        np.array([b[2] for b in boxes], float).reshape(-1, 4),
        np.zeros(n, int),
        ignore=np.array([b[3] for b in boxes], bool),
    )


def _box(frame: int, left: float = 100.0, side: float = 40.0) -> tuple[float, ...]:
    return (left + 2 * frame, 50.0, left + 2 * frame + side, 50.0 + side)


def _rows(*rows: tuple[int, int, tuple[float, ...]]) -> TrackTable:
    return TrackTable.of_rows((f, t, np.array(b), 0, 1.0, "detected") for f, t, b in rows)


def _seen(gap: range = range(0), score: float = 2.0) -> DetectedVideo:
    """One sign that moves to the right, detected in each frame outside the gap."""
    frames = []
    for k in range(FRAMES):
        n = 0 if k in gap else 1
        boxes, scores = np.array([_box(k)])[:n], np.full(n, score)
        frames.append(DetectedFrame(k, k / 30, Detections(boxes, scores, scores * 0, scores), (0.0, 0.0)))
    truth = _truth([(k, 1, _box(k), False) for k in range(FRAMES)])
    return DetectedVideo(AnnotatedVideo("toy", "held out", Path("toy.mp4"), truth), 640, 360, 1 / 30, tuple(frames))


class _ToyTracker:
    """A tracker that gives each box the same identity, or one of several."""

    def __init__(self, frame_rate: float, change: int = 100, track_activation_threshold: float = 0.0) -> None:
        self.frame, self.change, self.least = 0, change, track_activation_threshold

    def update(self, detections: Any) -> Any:
        detections.tracker_id = np.where(detections.confidence >= self.least, self.frame // self.change, -1)
        self.frame += 1
        return detections


class _Boxes:
    def __init__(self, xyxy: Any, confidence: Any, class_id: Any) -> None:
        self.xyxy, self.confidence, self.class_id, self.tracker_id = xyxy, confidence, class_id, None


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> Peer:
    class Package:
        Detections = _Boxes
        Toy = _ToyTracker

    monkeypatch.setattr(multi_object_trackers, "load", lambda name: Package)
    grid = {"change": (3, 100, 5), "activation_score": (0.0,), MIN_SCORE_SETTING: (-1.0,)}
    return Peer("toy", "Toy", grid, {"activation_score": "track_activation_threshold"})


def test_a_peer_gets_our_boxes_in_order_and_keeps_its_identities(toy: Peer) -> None:
    rows, seconds = track_with_peer(toy, _seen(range(4, 6)), {"change": 6, "activation_score": 0.0})
    assert rows.frame.tolist() == [0, 1, 2, 3, 6, 7, 8, 9, 10, 11]
    assert rows.track.tolist() == [0] * 4 + [1] * 6
    assert rows.boxes[0].tolist() == list(_box(0))
    assert seconds >= 0


def test_scores_and_thresholds_become_confidences(toy: Peer) -> None:
    assert confidence(0.0) == 0.5
    assert (np.diff(confidence(np.linspace(-3, 3, 7))) > 0).all()
    settings = {"change": 100, "activation_score": 1.0}
    assert len(track_with_peer(toy, _seen(score=0.9), settings)[0].frame) == 0  # activation is a score of 1
    assert len(track_with_peer(toy, _seen(score=1.1), settings)[0].frame) == FRAMES
    assert len(track_with_peer(toy, _seen(score=-1.5), {MIN_SCORE_SETTING: -1.0, "change": 100})[0].frame) == 0
    assert len(track_with_peer(toy, _seen(score=-1.5), {"change": 100})[0].frame) == FRAMES


def test_unknown_options_of_a_package_are_named(toy: Peer) -> None:
    with pytest.raises(Missing, match="other settings"):
        toy.make(30.0, {"request": 1.0})
    with pytest.raises(Missing, match="has no Other"):
        Peer("other", "Other", {}, {}).make(30.0, {})


def test_the_best_of_the_grid_is_chosen(toy: Peer, monkeypatch: pytest.MonkeyPatch) -> None:
    def whole(videos: list[dict[str, Any]], names: Any) -> dict[str, float]:
        return {"HOTA": 1.0 / sum(v["num_tracker_ids"] for v in videos), "MOTA": 0.5, "IDF1": 0.5}

    monkeypatch.setattr(tuning, "trackeval_figures", whole)
    monkeypatch.setattr(tuning, "load", lambda name: None)
    monkeypatch.setattr(AnnotatedVideo, "digests", lambda self: [self.name])
    best = tuning.tune(toy, [_seen(), _seen(range(3, 5))], Cache(None))
    assert best.settings["change"] == 100
    assert best.hota == 0.5
    assert (best.tried, best.equal) == (3, 1)
    with pytest.raises(ValueError, match="at least one clip"):
        tuning.tune(toy, [], Cache(None))


def test_cached_results_are_used_while_nothing_changed(tmp_path: Path) -> None:
    kept, calls = Cache(tmp_path / "kept"), []

    def make() -> dict[str, Any]:
        calls.append(1)
        return {"box": (1.25, 2.0), "n": len(calls)}

    first = kept.get(["a", {"x": 1}], make)
    assert first == {"box": [1.25, 2.0], "n": 1}
    assert kept.get(["a", {"x": 1}], make) == first
    assert kept.get(["a", {"x": 2}], make)["n"] == 2
    assert Cache(None).get(["a", {"x": 1}], make)["n"] == 3


def test_results_round_trip_exactly() -> None:
    rows = _rows((0, 7, (0.1, 1 / 3, 20.0, 30.0)), (2, 8, _box(2)))
    again = TrackingResult.of(json.loads(json.dumps(TrackingResult(rows, _rows(), 0.25).as_dict())))
    assert again.rows.boxes.tolist() == rows.boxes.tolist()
    assert (again.rows.track.tolist(), again.rows.source_words()) == ([7, 8], ["detected", "detected"])
    assert (len(again.live.frame), again.seconds) == (0, 0.25)


def test_every_grid_is_small_and_of_known_settings() -> None:
    for peer in PEERS:
        assert 2 <= len(list(peer.settings())) <= 150
        assert set(peer.scored) <= set(peer.grid)


def test_ignored_rows_are_removed_before_trackeval() -> None:
    truth = _truth(
        [
            (0, 1, _box(0), False),
            (0, 2, _box(0, left=300, side=15), False),  # narrower than 20 px
            (0, 3, _box(0, left=400, side=60), True),  # ignored
            (1, 1, _box(1), False),
        ]
    )
    rows = _rows(
        (0, 7, _box(0)),
        (0, 8, _box(0, left=300, side=15)),
        (0, 9, _box(0, left=410, side=20)),  # inside the ignored area
        (1, 7, _box(1)),
        (1, 5, _box(1, left=500)),  # false
    )
    made = sequence(truth, rows, 3)
    assert (made["num_gt_dets"], made["num_gt_ids"]) == (2, 1)
    assert (made["num_tracker_dets"], made["num_tracker_ids"]) == (3, 2)
    assert [len(ids) for ids in made["tracker_ids"]] == [1, 2, 0]
    assert made["similarity_scores"][0].tolist() == [[1.0]]
    assert made["similarity_scores"][2].shape == (0, 0)


def test_a_box_on_a_counted_sign_is_not_excused_by_an_ignored_one_over_it() -> None:
    truth = _truth([(0, 1, _box(0), False), (0, 2, _box(0, side=80), True)])
    made = sequence(truth, _rows((0, 7, _box(0))), 1)
    assert made["num_tracker_dets"] == 1


def test_the_bound_takes_each_detection_once() -> None:
    seen = _seen(range(2, 5))
    rows = trackers.perfect_identities(seen)
    assert rows.frame.tolist() == [0, 1, *range(5, FRAMES)]
    assert set(rows.track.tolist()) == {1}


@pytest.mark.skipif(importlib.util.find_spec("trackers") is not None, reason="the peers are installed here")
def test_peers_that_are_not_installed_are_skipped_by_name() -> None:
    rows: dict[str, Any] = {}
    chosen, missing = trackers.run_peers([_seen()], [_seen()], rows, Cache(None))
    assert (chosen, rows) == ({}, {})
    assert set(missing) == {"TrackEval", *(peer.name for peer in PEERS)}
    assert all("pip install" in why for why in missing.values())


def test_installed_peers_are_tuned_and_run(monkeypatch: pytest.MonkeyPatch) -> None:
    for package in ("trackeval", "trackers"):
        pytest.importorskip(package, reason="the peers are not installed")
    peer = Peer("SORT", "SORTTracker", {"minimum_consecutive_frames": (1, 8)}, {})
    monkeypatch.setattr(trackers, "PEERS", (peer,))
    monkeypatch.setattr(AnnotatedVideo, "digests", lambda self: [self.name])
    rows: dict[str, Any] = {}
    chosen, missing = trackers.run_peers([_seen()], [_seen(), _seen(range(3, 4))], rows, Cache(None))
    assert missing == {}
    assert chosen["SORT"]["settings"] == {"minimum_consecutive_frames": 1}
    assert [len(set(found.track.tolist())) for found, _ in rows["SORT"]] == [1, 1]


def _figures(coverage: float, error: float, **others: Any) -> dict[str, Any]:
    return {
        "HOTA": 0.5, "IDF1": 0.5, "MOTA": 0.5, "coverage": coverage, "ids_per_sign": 1.0, "signs": 4,
        "signs_detected": 3, "false_tracks": 0, "mean_error": error, "mean_error_overall": 1 - coverage * (1 - error),
        "mean_error_any_width": error, "switches": 0,
        "ms_a_frame": 1.0, "shared": {"n": 7, "ours": 0.1, "theirs": error},
    } | others  # fmt: skip


def _reported(**rows: dict[str, Any]) -> str:
    best = {"settings": {"activation_score": 0.0}, "hota": 0.6, "tried": 4, "equal": 2}
    chosen = {"SORT": best} if "SORT" in rows else {}
    missing = {"C-BIoU": "the package trackers cannot be imported."}
    figures = {"groups": {"held out": rows}, "chosen": chosen, "missing": missing}
    return trackers.EXPERIMENT.report(Result("trackers", "toys", figures))


def test_the_report_names_each_row_on_which_a_peer_is_better() -> None:
    text = _reported(default=_figures(0.7, 0.1), paper=_figures(0.6, 0.2), SORT=_figures(0.65, 0.09))
    assert "**`default` is beaten by a tuned peer**" in text
    assert "- held out, mean Eq. 7: 0.09 by SORT against our 0.1" in text
    assert "held out, coverage" not in text
    assert "`default` is never beaten by `paper`." in text
    assert "*Skipped:* C-BIoU: the package trackers cannot be imported." in text
    assert "| held out | **0.1000 / 0.0900 (7)** |" in text


def test_every_better_peer_is_named_also_for_results_while_driving() -> None:
    rows = {"default": _figures(0.9, 0.1), trackers.LIVE: _figures(0.6, 0.1), "paper": _figures(0.6, 0.2)}
    peers = {"SORT": _figures(0.7, 0.09), "OC-SORT": _figures(0.8, 0.08)}
    best = {"settings": {}, "hota": 0.6, "tried": 4, "equal": 2}
    figures = {"groups": {"blur": rows | peers}, "chosen": dict.fromkeys(peers, best), "missing": {}}
    text = trackers.EXPERIMENT.report(Result("trackers", "toys", figures))
    assert "- blur, mean Eq. 7: 0.08 by OC-SORT, 0.09 by SORT against our 0.1" in text
    assert "**`default, while driving` is beaten by a tuned peer** at:\n\n- blur, coverage: 0.8 by OC-SORT, 0.7" in text
    assert "| SORT | 4 | 0.600 | 2 |" in text


def test_of_equal_settings_the_next_figure_decides(toy: Peer, monkeypatch: pytest.MonkeyPatch) -> None:
    def figures(videos: list[dict[str, Any]], names: Any) -> dict[str, float]:
        return {"HOTA": 0.5, "MOTA": 1.0 / videos[0]["num_tracker_ids"], "IDF1": 0.5}

    monkeypatch.setattr(tuning, "trackeval_figures", figures)
    monkeypatch.setattr(tuning, "load", lambda name: None)
    monkeypatch.setattr(AnnotatedVideo, "digests", lambda self: [self.name])
    best = tuning.tune(toy, [_seen()], Cache(None))
    assert (best.settings["change"], best.equal) == (100, 3)


def test_missing_videos_to_judge_or_tune_are_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trackers, "annotated_videos", lambda data: ([], "nothing was given."))
    monkeypatch.setattr(trackers, "detect_videos", lambda videos, folder: iter(()))
    with pytest.raises(Skip, match="chosen on"):
        trackers.EXPERIMENT.run(Data(None, None, tmp_path, None, tmp_path))
    monkeypatch.setattr(trackers, "load", lambda name: None)
    chosen, missing = trackers.run_peers([], [_seen()], {}, Cache(None))
    assert chosen == {}
    assert all("choose its settings" in why for why in missing.values())


def test_errors_are_compared_where_both_have_a_box() -> None:
    seen = _seen()
    truth = seen.video.truth
    place = [int(i) for i in np.flatnonzero(~truth.ignore)]

    def rows(kept: list[int], wider: float) -> TrackTable:
        boxes = [truth.boxes[i] + [0.0, 0.0, wider * (truth.boxes[i][2] - truth.boxes[i][0]), 0.0] for i in kept]
        return TrackTable.of_rows(
            (int(truth.frame[i]), 1, b, 0, 1.0, "detected") for i, b in zip(kept, boxes, strict=True)
        )

    ours = evaluate_video("v", truth, rows(place, 0.1), FRAMES)
    theirs = evaluate_video("v", truth, rows(place[:3], 0.2), FRAMES)
    found = shared_errors([ours], [theirs])
    assert found["n"] == 3
    assert found["ours"] < found["theirs"]
    assert found["ours"] == pytest.approx(ours.errors[0][0])
    nothing = evaluate_video("v", truth, rows([], 0.0), FRAMES)
    assert shared_errors([ours], [nothing])["ours"] is None
    # They differ in all three common frames, and in frames of only one.
    changed = changed_errors([theirs], [ours])
    assert (changed["n"], changed["only_ours"], changed["only_theirs"]) == (3, 0, len(place) - 3)
    assert changed["ours"] == pytest.approx(found["theirs"])
    assert changed["theirs"] == pytest.approx(found["ours"])
    same = changed_errors([ours], [evaluate_video("v", truth, rows(place[:4], 0.1), FRAMES)])
    assert same == {"n": 0, "ours": None, "theirs": None, "only_ours": len(place) - 4, "only_theirs": 0}
    assert changed_errors([ours], [nothing])["only_ours"] == len(place)


def test_without_peers_the_report_makes_no_claim() -> None:
    text = _reported(default=_figures(0.7, 0.1), paper=_figures(0.6, 0.2))
    assert "No peer could be run" in text
    assert "never beaten" not in text


def test_a_missing_folder_of_approaches_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trackers, "read_clips", lambda folder: {"a": (Path("a.mp4"), _truth([]))})
    videos, without = trackers.annotated_videos(Data(None, None, tmp_path, None, tmp_path))
    assert [v.group for v in videos] == ["held out"]
    assert "`looming`" in without


def test_trackeval_agrees_on_toys() -> None:
    pytest.importorskip("trackeval", reason="TrackEval is not installed")
    seen = _seen()
    whole = _rows(*((k, 7, _box(k)) for k in range(FRAMES)))
    torn = _rows(*((k, k // 6, _box(k)) for k in range(FRAMES)))
    perfect = trackeval_figures([sequence(seen.video.truth, whole, FRAMES)])
    assert perfect == pytest.approx({"HOTA": 1.0, "IDF1": 1.0, "MOTA": 1.0})
    halves = trackeval_figures([sequence(seen.video.truth, torn, FRAMES)])
    assert halves["IDF1"] == pytest.approx(0.5)
    assert halves["MOTA"] == pytest.approx(11 / 12)
    assert halves["HOTA"] == pytest.approx(np.sqrt(0.5))


@pytest.mark.parametrize("peer", PEERS, ids=[peer.name for peer in PEERS])
def test_each_peer_follows_a_toy(peer: Peer) -> None:
    pytest.importorskip("trackers", reason="the peers are not installed")
    rows, _ = track_with_peer(peer, _seen(), next(peer.settings()))
    assert len(rows.frame) >= FRAMES - 2
    assert len(set(rows.track.tolist())) == 1
