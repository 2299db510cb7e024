"""Algorithm 3 step by step: the core with a confident and with a rejected prediction."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.scripted_pipeline import (
    HEIGHT,
    NONE,
    PICTURE,
    WIDTH,
    ScriptedClassifier,
    ScriptedGate,
    ScriptedPipeline,
    detection,
    plain_gate,
)
from tsr_engine.evidence import FramePixels
from tsr_engine.pipeline import FrameInput, Models, TrackingCore
from tsr_engine.records import Detections, FloatArray, Sample

__all__ = ["plain_gate"]


def test_first_frame_of_a_track() -> None:
    pipeline = ScriptedPipeline()
    core = TrackingCore(
        pipeline.core.params, Models(ScriptedClassifier(), pipeline.models.make_online), WIDTH, HEIGHT, interval=0.04
    )
    frame = core.step(FrameInput(7, 0.28, detection(80.0), (1.0, 0.0), FramePixels(PICTURE)))
    (track,) = frame.tracks
    assert (track.track_id, track.source, track.detection, track.prediction, track.gate) == (
        1,
        "detected",
        0,
        None,
        None,
    )
    assert track.samples == (Sample("learned", 1, "result", 7),)
    assert track.recognition is not None
    assert track.recognition.class_id == 5
    assert [event.kind for event in frame.events] == ["born", "confirmed"]
    assert frame.shift == (1.0, 0.0)


def test_confident_with_detection_learns_a_positive_and_updates_the_filter() -> None:
    pipeline = ScriptedPipeline()
    (track,) = pipeline.step(detection(82.0)).tracks
    assert pipeline.learner.calls == [("learn", 1, 5)]
    assert track.source == "detected"
    assert track.relocalisation is None
    assert track.prediction is not None
    assert track.prediction.box[0] < track.box[0] < 82.0


def test_confident_without_detection_is_the_prediction() -> None:
    pipeline = ScriptedPipeline()
    (track,) = pipeline.step(NONE).tracks
    assert pipeline.learner.calls == []
    assert track.source == "predicted"
    assert track.prediction is not None
    assert np.array_equal(track.box, track.prediction.box)
    assert track.gate is not None
    assert track.gate.confident


def test_predictions_without_detection_are_learned_on_demand() -> None:
    pipeline = ScriptedPipeline(learn_undetected=True)
    pipeline.step(NONE)
    assert pipeline.learner.calls == [("learn", 1, 5)]


def test_rejected_without_detection_learns_a_negative_and_relocalises() -> None:
    pipeline = ScriptedPipeline(position_unit="px", tau=15.0)
    ScriptedGate.confident = False
    frame = pipeline.step(NONE)
    (track,) = frame.tracks
    assert pipeline.learner.calls == [("learn", -1, 5), ("relocalise",)]
    assert track.source == "relocalised"
    assert track.relocalisation is not None
    assert np.array_equal(track.box, track.relocalisation.box)
    assert track.samples == (Sample("learned", -1, "prediction", 5),)
    (event,) = [event for event in frame.events if event.kind == "relocalised"]
    assert event.text == "Prediction of track 1 rejected, L = 99.0 > 15, symmetry 0.20 is low; relocalised 6 px left."
    before = track.box
    ScriptedGate.confident = True
    (after,) = pipeline.step(NONE).tracks
    assert after.prediction is not None
    assert after.prediction.box[0] < 79.0, "the window is the filter's measurement as well"
    assert before[0] == pytest.approx(74.0, abs=2.0)


def test_rejected_with_detection_follows_the_parameter() -> None:
    ScriptedGate.confident = True
    paper = ScriptedPipeline(rejected_measurement="relocalised")
    default = ScriptedPipeline(rejected_measurement="detection")
    ScriptedGate.confident = False
    (by_window,) = paper.step(detection(82.0)).tracks
    assert by_window.source == "relocalised"
    assert by_window.detection == 0
    frame = default.step(detection(82.0))
    (by_detection,) = frame.tracks
    assert by_detection.source == "detected"
    assert by_detection.relocalisation is None
    assert ("relocalise",) not in default.learner.calls
    assert ("learn", -1, 5) in default.learner.calls
    assert [event.kind for event in frame.events] == ["rejected"]


def test_an_improbable_window_does_not_replace_the_prediction() -> None:
    pipeline = ScriptedPipeline(relocalise_probability=0.7)
    pipeline.learner.probability = 0.6
    ScriptedGate.confident = False
    frame = pipeline.step(NONE)
    (track,) = frame.tracks
    assert track.source == "predicted"
    assert track.relocalisation is not None
    assert any("no window around it looks like the sign" in event.text for event in frame.events)


def test_only_a_confident_relocalisation_keeps_a_track_alive() -> None:
    def frames_until_death(probability: float) -> int:
        ScriptedGate.confident = True
        pipeline = ScriptedPipeline(max_coast=3, sure_probability=0.5, max_undetected=12)
        pipeline.learner.probability = probability
        ScriptedGate.confident = False
        count = 0
        while pipeline.step(NONE).tracks[-1].state != "dead" and count < 30:
            count += 1
        return count

    assert frames_until_death(0.2) <= 4
    assert frames_until_death(0.8) > 6


def test_kalman_filter_alone() -> None:
    pipeline = ScriptedPipeline(use_online=False)
    ScriptedGate.confident = False
    (track,) = pipeline.step(detection(82.0)).tracks
    assert pipeline.learner.calls == []
    assert track.source == "detected"
    assert track.samples == ()
    assert track.gate is not None, "the factors stay on record"
    assert not track.gate.confident
    (track,) = pipeline.step(NONE).tracks
    assert track.source == "predicted"


def test_the_frame_of_death_keeps_its_factors() -> None:
    pipeline = ScriptedPipeline(max_coast=0)
    frame = pipeline.step(NONE)
    (track,) = frame.tracks
    assert track.state == "dead"
    assert track.gate is not None
    assert track.recognition is None
    assert [event.kind for event in frame.events][-1] == "died"
    assert pipeline.step(NONE).tracks == ()


def test_votes_add_up_and_a_change_of_class_is_an_event() -> None:
    pipeline = ScriptedPipeline(fusion_mode="equal")
    ScriptedClassifier.class_id = 9
    changed = []
    for _ in range(8):
        frame = pipeline.step(detection(80.0))
        changed += [event for event in frame.events if event.kind == "relabelled"]
    (event,) = changed
    assert "no overtaking" in event.text
    recognition = frame.tracks[0].recognition
    assert recognition is not None
    assert recognition.votes.sum() == pytest.approx(13.0, abs=1e-5)
    assert recognition.class_id == 9


@pytest.mark.parametrize(
    "box", [[-40.0, -40.0, 3.0, 3.0], [0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 200.0, 160.0], [195.0, 150.0, 240.0, 200.0]]
)
def test_unusual_boxes_do_not_fail(box: list[float]) -> None:
    pipeline = ScriptedPipeline()
    one = np.array([5.0])
    odd = Detections(np.array([box]), one, np.array([0.5]), one)
    for _ in range(4):
        frame = pipeline.step(odd)
    assert all(np.isfinite(track.box).all() for track in frame.tracks)


def test_time_counts_in_nominal_intervals(monkeypatch: pytest.MonkeyPatch) -> None:
    steps: list[float] = []
    pipeline = ScriptedPipeline()
    tracker = pipeline.core._tracker
    predict: Callable[..., object] = tracker.predict
    monkeypatch.setattr(tracker, "predict", lambda dt, shift: steps.append(dt) or predict(dt, shift))
    for seconds in (0.20, 0.28, 0.28):
        pipeline.k += 1
        pipeline.core.step(FrameInput(pipeline.k, seconds, NONE, (0.0, 0.0), FramePixels(PICTURE)))
    assert steps == [pytest.approx(1.0), pytest.approx(2.0), pytest.approx(1e-3)]


def test_two_cores_share_no_state() -> None:
    a, b = ScriptedPipeline(), ScriptedPipeline()
    a.step(detection(80.0))
    frame = b.step(detection(80.0))
    assert [track.track_id for track in frame.tracks] == [1]


def test_expected_signs_are_searched_again() -> None:
    pipeline = ScriptedPipeline()
    requests: list[FloatArray] = []

    def revisit(expected: FloatArray) -> Detections:
        requests.append(expected)
        return detection(80.0)

    frame = pipeline.core.step(FrameInput(5, 0.2, NONE, (0.0, 0.0), FramePixels(PICTURE), revisit))
    (track,) = frame.tracks
    assert track.source == "detected"
    assert track.prediction is not None
    assert np.array_equal(requests, [track.prediction.box[None]])
    assert len(frame.detections) == 1, "evidence holds what a replay needs"


def test_nothing_is_searched_again_without_expected_signs() -> None:
    pipeline = ScriptedPipeline()
    core = TrackingCore(pipeline.core.params, pipeline.models, WIDTH, HEIGHT, interval=0.04)

    def revisit(expected: FloatArray) -> Detections:
        raise AssertionError

    frame = core.step(FrameInput(0, 0.0, NONE, (0.0, 0.0), FramePixels(PICTURE), revisit))
    assert not frame.tracks
