"""A sign that the detector has lost: the online detector's search, and the weight of its window."""

from __future__ import annotations

import numpy as np
import pytest

from tests.scripted_pipeline import NONE, ScriptedPipeline, detection, plain_gate
from tsr_engine.geometry.boxes import to_cxcywh
from tsr_engine.protocols import PixelSource, ScoredBox
from tsr_engine.records import FloatArray

__all__ = ["plain_gate"]


def test_a_sign_unseen_for_some_frames_is_searched_despite_the_gate() -> None:
    pipeline = ScriptedPipeline(relocalise_after=3)
    sources, events = [], []
    for given in (NONE, NONE, NONE, detection(82.0), NONE, NONE, NONE):
        frame = pipeline.step(given)
        sources.append(frame.tracks[0].source)
        events.append([event.text for event in frame.events if event.kind in ("relocalised", "rejected")])
    assert sources == [*["predicted"] * 2, "relocalised", "detected", *["predicted"] * 2, "relocalised"]
    sentence = "Track 1 has had no detection for 3 frames; a window like it is 6 px left."
    assert events == [[], [], [sentence], [], [], [], [sentence]]
    assert [name for name, *_ in pipeline.learner.calls] == ["relocalise", "learn", "relocalise"]


def test_a_found_window_is_a_measurement() -> None:
    """The result lies between prediction and window; with less noise it is nearer to the window."""

    def left(noise: float) -> float:
        pipeline = ScriptedPipeline(relocalise_after=1, search_noise=noise)
        (track,) = pipeline.step(NONE).tracks
        assert track.prediction is not None
        return float(to_cxcywh(track.prediction.box)[0] - to_cxcywh(track.box)[0])

    exact, as_usual, vague = (left(noise) for noise in (0.01, 2.0, 50.0))
    assert 6.0 >= exact > as_usual > vague >= 0.0
    assert exact > 5.5
    assert vague < 0.5


def test_the_size_of_a_found_window_has_its_own_noise() -> None:
    """All windows have one size, which says nothing about the sign's."""

    def change(size_noise: float | None, moved: float, grown: float) -> FloatArray:
        pipeline = ScriptedPipeline(relocalise_after=1, search_noise=2.0, search_size_noise=size_noise)
        pipeline.learner.moved, pipeline.learner.grown = moved, grown
        (track,) = pipeline.step(NONE).tracks
        assert track.prediction is not None
        return np.abs(to_cxcywh(track.box) - to_cxcywh(track.prediction.box))

    for moved, grown in ((6.0, 0.0), (0.0, 4.0)):
        assert np.array_equal(change(None, moved, grown), change(2.0, moved, grown))
    assert change(None, 0.0, 4.0)[2] > 5 * change(16.0, 0.0, 4.0)[2] > 0
    assert change(16.0, 6.0, 0.0)[0] > 0.8 * change(None, 6.0, 0.0)[0]


def test_window_rescoring_measures_the_size_of_the_sign() -> None:
    """A higher score gives a more exact box; without a detection the window is used unchanged."""
    edges = np.array([70.0, 46, 108, 84])

    def box_of(seen: ScoredBox | None, **settings: object) -> tuple[FloatArray, str]:
        pipeline = ScriptedPipeline(relocalise_after=1, **({"rescore_noise": 0.01} | settings))
        requests = []

        def look(pixels: PixelSource, box: FloatArray) -> ScoredBox | None:
            requests.append(box)
            return seen

        pipeline.rescore_by(look)
        frame = pipeline.step(NONE)
        (track,) = frame.tracks
        assert track.source == "relocalised"
        assert track.relocalisation is not None
        assert len(requests) == (1 if pipeline.core.params.pipeline.rescore_windows else 0)
        assert all(np.array_equal(box, track.relocalisation.box) for box in requests)
        (event,) = [event for event in frame.events if event.kind == "relocalised"]
        values = [event.values.get(name) for name in ("score", "x1", "y1", "x2", "y2")]
        assert values == ([None] * 5 if seen is None or "finds a sign" not in event.text else [seen.score, *seen.box])
        return track.box, event.text

    found, text = box_of(ScoredBox(edges, 5.0))
    np.testing.assert_allclose(found, edges, atol=1.5)  # the filter is linearised at 30 px
    assert text.endswith("a window like it is 6 px left, where rescoring finds a sign with score 5.0.")
    as_it_is, text = box_of(None)
    assert to_cxcywh(as_it_is)[2] < 33
    assert text.endswith("a window like it is 6 px left.")
    refused, text = box_of(ScoredBox(edges, 1.9), inflate_rejected_noise=False)
    assert np.array_equal(as_it_is, refused), "too unlike a sign to be measured"
    assert text.endswith("a window like it is 6 px left.")
    assert np.array_equal(as_it_is, box_of(ScoredBox(edges, 5.0), rescore_windows=False)[0])
    sure, uncertain = (box_of(ScoredBox(edges, score), rescore_noise=1.0)[0] for score in (9.0, 3.0))
    assert to_cxcywh(sure)[2] > to_cxcywh(uncertain)[2] > to_cxcywh(as_it_is)[2]


def test_a_low_rescoring_score_reduces_the_weight_of_a_window() -> None:
    """An occluder scores low; without rescoring, or without a detection, the window has its full weight."""

    def left(seen: ScoredBox | None, **settings: object) -> tuple[float, str, object]:
        pipeline = ScriptedPipeline(relocalise_after=1, **settings)
        pipeline.rescore_by(lambda pixels, box: seen)
        frame = pipeline.step(NONE)
        (track,) = frame.tracks
        assert track.prediction is not None
        (event,) = [event for event in frame.events if event.kind == "relocalised"]
        moved = float(to_cxcywh(track.prediction.box)[0] - to_cxcywh(track.box)[0])
        return moved, event.text, event.values.get("score")

    edges = np.array([70.0, 46, 108, 84])
    whole, *_ = left(None)
    hardly, text, score = left(ScoredBox(edges, 1.0))
    not_at_all, *_ = left(ScoredBox(edges, -6.0))
    assert whole > hardly > not_at_all > 0.0
    assert text.endswith("6 px left, which counts little: rescoring rejects it (score 1.0).")
    assert score == 1.0
    for settings in ({"inflate_rejected_noise": False}, {"rescore_windows": False}, {"noise_score": 0.0}):
        assert left(ScoredBox(edges, -6.0), **settings)[0] == left(None, **settings)[0]
    # a detection with that score would lose as much weight as the window
    pipeline = ScriptedPipeline()
    noise_scale = pipeline.core.params.tracking.noise_scale(1.0)
    assert noise_scale > 2
    alike, *_ = left(None, search_noise=3.0 * noise_scale, search_size_noise=16.0 * noise_scale)
    assert hardly == pytest.approx(alike, rel=1e-9)


def test_a_window_far_from_the_prediction_is_not_used() -> None:
    """The filter's uncertainty defines how far is too far."""
    events = {}
    for sigmas in (None, 3.0):
        pipeline = ScriptedPipeline(relocalise_after=1, search_sigmas=sigmas)
        pipeline.learner.moved = 30.0
        frame = pipeline.step(NONE)
        (track,) = frame.tracks
        assert track.relocalisation is not None
        assert track.prediction is not None
        assert (track.source == "relocalised") == (sigmas is None)
        assert np.array_equal(track.box, track.prediction.box) == (sigmas is not None)
        events[sigmas] = [(event.kind, event.text) for event in frame.events if "window" in event.text]
    assert events[None] == [
        ("relocalised", "Track 1 has had no detection for 1 frame; a window like it is 30 px left.")
    ]
    ((kind, text),) = events[3.0]
    assert kind == "rejected"
    assert "30 px left, too far from where it is expected (" in text


def test_the_search_of_unseen_signs_can_be_disabled() -> None:
    pipeline = ScriptedPipeline(relocalise_after=None)
    assert [pipeline.step(NONE).tracks[0].source for _ in range(4)] == ["predicted"] * 4
    assert pipeline.learner.calls == []


def test_a_search_without_success_leaves_a_confident_prediction() -> None:
    pipeline = ScriptedPipeline(relocalise_after=1, search_probability=0.7)
    pipeline.learner.probability = 0.6
    frame = pipeline.step(NONE)
    assert frame.tracks[0].source == "predicted"
    assert frame.tracks[0].relocalisation is not None
    assert [event.kind for event in frame.events if event.kind == "rejected"] == []
