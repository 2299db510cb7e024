"""Algorithm 3 step by step: what the core does with a confident and with a rejected prediction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

import tsr_engine.pipeline.core
from tsr_engine.evidence import FramePixels
from tsr_engine.gating.perceptual_hash import HashMemory
from tsr_engine.geometry.boxes import to_cxcywh
from tsr_engine.params import Params
from tsr_engine.params.gate import GateParams
from tsr_engine.pipeline import FrameInput, Parts, TrackingCore
from tsr_engine.protocols import PixelSource, Sighting
from tsr_engine.records import Detections, FloatArray, FrameEvidence, GateVerdict, Picture, Relocalisation, Sample

WIDTH, HEIGHT = 200, 160
NONE = Detections.empty()
PICTURE = np.random.default_rng(3).integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)


def detection(x: float, y: float = 50.0, side: float = 30.0, score: float = 3.0) -> Detections:
    one = np.array([score])
    return Detections(np.array([[x, y, x + side, y + side]]), one, np.array([0.5]), one)


class Gate:
    """A gate whose verdict the test sets."""

    margin = 0.1
    confident = True

    def __init__(self, params: GateParams) -> None:
        self.params = params

    def remember(self, memory: HashMemory, crop: Picture) -> HashMemory:
        return memory.add(crop)

    def judge(self, crop: Picture, memory: HashMemory, *args: object) -> GateVerdict:
        assert memory.count > 0
        value = 1.0 if Gate.confident else 99.0
        return GateVerdict(0.2, 5.0, 4.0, 2.0, value, value < self.params.tau)


class Classifier:
    margin = 0.1
    class_id = 5

    def probabilities(self, crops: list[Picture]) -> np.ndarray:
        rows = np.full((len(crops), 43), 0.2 / 42, np.float32)
        rows[:, Classifier.class_id] = 0.8
        return rows


@dataclass
class Learner:
    """An online detector that notes what it is told and answers with a window to the left."""

    calls: list[tuple[str, int, int]] = field(default_factory=list)
    probability: float = 0.9
    moved: float = 6.0
    grown: float = 0.0

    def learn(self, pixels: PixelSource, box: FloatArray, label: int, frame: int) -> tuple[Sample, ...]:
        self.calls.append(("learn", label, frame))
        return (Sample("learned", label, "prediction", frame),)

    def relocalise(self, pixels: PixelSource, box: FloatArray, frame: int) -> Relocalisation | None:
        self.calls.append(("relocalise", 0, frame))
        moved = box - self.moved * np.array([1.0, 0.0, 1.0, 0.0])
        moved += 0.5 * self.grown * np.array([-1.0, -1.0, 1.0, 1.0])
        return Relocalisation(box, moved, 2.0, self.probability, box, 0.0, 9)


@pytest.fixture(autouse=True)
def plain_gate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tsr_engine.pipeline.core, "Gate", Gate)
    Gate.confident = True
    Classifier.class_id = 5


class Bench:
    """A core with a confirmed track at frame 4, and the learner of that track."""

    def __init__(self, **settings: object) -> None:
        params = Params().with_settings([("confirm_hits", 1), ("confirm_window", 3), *settings.items()])
        self.learner = Learner()

        def make(pixels: PixelSource, box: FloatArray, frame: int) -> tuple[Learner, tuple[Sample, ...]]:
            return self.learner, (Sample("learned", 1, "result", frame),)

        self.core = TrackingCore(params, Parts(Classifier(), make), WIDTH, HEIGHT, interval=0.04)
        self.k = -1
        for _ in range(5):
            self.step(detection(80.0))
        self.learner.calls.clear()

    def step(self, found: Detections) -> FrameEvidence:
        self.k += 1
        return self.core.step(FrameInput(self.k, self.k * 0.04, found, (0.0, 0.0), FramePixels(PICTURE)))


def test_first_frame_of_a_track() -> None:
    bench = Bench()
    core = TrackingCore(
        bench.core.params, Parts(Classifier(), bench.core._parts.make_online), WIDTH, HEIGHT, interval=0.04
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
    bench = Bench()
    (track,) = bench.step(detection(82.0)).tracks
    assert bench.learner.calls == [("learn", 1, 5)]
    assert track.source == "detected"
    assert track.relocalisation is None
    assert track.prediction is not None
    assert track.prediction.box[0] < track.box[0] < 82.0


def test_confident_without_detection_is_the_prediction() -> None:
    bench = Bench()
    (track,) = bench.step(NONE).tracks
    assert bench.learner.calls == []
    assert track.source == "predicted"
    assert track.prediction is not None
    assert np.array_equal(track.box, track.prediction.box)
    assert track.gate is not None
    assert track.gate.confident


def test_predictions_without_detection_are_learned_on_demand() -> None:
    bench = Bench(learn_undetected=True)
    bench.step(NONE)
    assert bench.learner.calls == [("learn", 1, 5)]


def test_a_sign_unseen_for_some_frames_is_sought_whatever_the_gate_says() -> None:
    bench = Bench(relocalise_after=3)
    sources, events = [], []
    for given in (NONE, NONE, NONE, detection(82.0), NONE, NONE, NONE):
        frame = bench.step(given)
        sources.append(frame.tracks[0].source)
        events.append([event.text for event in frame.events if event.kind in ("relocalised", "rejected")])
    assert sources == [*["predicted"] * 2, "relocalised", "detected", *["predicted"] * 2, "relocalised"]
    sentence = "Track 1 has had no detection for 3 frames; a window like it is 6 px left."
    assert events == [[], [], [sentence], [], [], [], [sentence]]
    assert [name for name, *_ in bench.learner.calls] == ["relocalise", "learn", "relocalise"]


def test_a_window_that_was_sought_is_one_more_measurement() -> None:
    """Between the prediction and the window, the nearer to the window the less noise it is taken to have."""

    def left(noise: float) -> float:
        bench = Bench(relocalise_after=1, sought_noise=noise)
        (track,) = bench.step(NONE).tracks
        assert track.prediction is not None
        return float(to_cxcywh(track.prediction.box)[0] - to_cxcywh(track.box)[0])

    exact, as_usual, vague = (left(noise) for noise in (0.01, 2.0, 50.0))
    assert 6.0 >= exact > as_usual > vague >= 0.0
    assert exact > 5.5
    assert vague < 0.5


def test_the_size_of_a_window_that_was_sought_may_count_for_less_than_its_place() -> None:
    """One size for all windows says nothing of the sign's."""

    def change(size_noise: float | None, moved: float, grown: float) -> FloatArray:
        bench = Bench(relocalise_after=1, sought_noise=2.0, sought_size_noise=size_noise)
        bench.learner.moved, bench.learner.grown = moved, grown
        (track,) = bench.step(NONE).tracks
        assert track.prediction is not None
        return np.abs(to_cxcywh(track.box) - to_cxcywh(track.prediction.box))

    for moved, grown in ((6.0, 0.0), (0.0, 4.0)):
        assert np.array_equal(change(None, moved, grown), change(2.0, moved, grown))
    assert change(None, 0.0, 4.0)[2] > 5 * change(16.0, 0.0, 4.0)[2] > 0
    assert change(16.0, 6.0, 0.0)[0] > 0.8 * change(None, 6.0, 0.0)[0]


def test_a_closer_look_at_a_window_that_was_sought_tells_the_sign_s_size() -> None:
    """Where it takes what is there for a sign, the more exactly the surer; else the window counts as it is."""
    edges = np.array([70.0, 46, 108, 84])

    def box_of(seen: Sighting | None, **settings: object) -> tuple[FloatArray, str]:
        bench = Bench(relocalise_after=1, **({"closer_noise": 0.01} | settings))
        asked = []

        def look(pixels: PixelSource, box: FloatArray) -> Sighting | None:
            asked.append(box)
            return seen

        bench.core._parts = replace(bench.core._parts, look=look)
        frame = bench.step(NONE)
        (track,) = frame.tracks
        assert track.source == "relocalised"
        assert track.relocalisation is not None
        assert len(asked) == (1 if bench.core.params.pipeline.closer_look else 0)
        assert all(np.array_equal(box, track.relocalisation.box) for box in asked)
        (event,) = [event for event in frame.events if event.kind == "relocalised"]
        values = [event.values.get(name) for name in ("score", "x1", "y1", "x2", "y2")]
        assert values == ([None] * 5 if seen is None or "sees a sign" not in event.text else [seen.score, *seen.box])
        return track.box, event.text

    found, text = box_of(Sighting(edges, 5.0))
    np.testing.assert_allclose(found, edges, atol=1.5)  # the filter is linearised at 30 px
    assert text.endswith("a window like it is 6 px left, where a closer look sees a sign with score 5.0.")
    as_it_is, text = box_of(None)
    assert to_cxcywh(as_it_is)[2] < 33
    assert text.endswith("a window like it is 6 px left.")
    refused, text = box_of(Sighting(edges, 1.9), refused_doubt=False)
    assert np.array_equal(as_it_is, refused), "too unlike a sign to be measured"
    assert text.endswith("a window like it is 6 px left.")
    assert np.array_equal(as_it_is, box_of(Sighting(edges, 5.0), closer_look=False)[0])
    sure, doubtful = (box_of(Sighting(edges, score), closer_noise=1.0)[0] for score in (9.0, 3.0))
    assert to_cxcywh(sure)[2] > to_cxcywh(doubtful)[2] > to_cxcywh(as_it_is)[2]


def test_a_window_counts_the_less_the_less_a_closer_look_takes_it_for_a_sign() -> None:
    """What hides a sign looks little like one; where the look is not asked, or sees nothing, it counts in full."""

    def left(seen: Sighting | None, **settings: object) -> tuple[float, str, object]:
        bench = Bench(relocalise_after=1, **settings)
        bench.core._parts = replace(bench.core._parts, look=lambda pixels, box: seen)
        frame = bench.step(NONE)
        (track,) = frame.tracks
        assert track.prediction is not None
        (event,) = [event for event in frame.events if event.kind == "relocalised"]
        moved = float(to_cxcywh(track.prediction.box)[0] - to_cxcywh(track.box)[0])
        return moved, event.text, event.values.get("score")

    edges = np.array([70.0, 46, 108, 84])
    whole, *_ = left(None)
    hardly, text, score = left(Sighting(edges, 1.0))
    not_at_all, *_ = left(Sighting(edges, -6.0))
    assert whole > hardly > not_at_all > 0.0
    assert text.endswith("6 px left, which counts little: a closer look takes it for no sign (score 1.0).")
    assert score == 1.0
    for settings in ({"refused_doubt": False}, {"closer_look": False}, {"noise_score": 0.0}):
        assert left(Sighting(edges, -6.0), **settings)[0] == left(None, **settings)[0]
    # a detection of that score would be as much less exact as the window has become
    bench = Bench()
    doubt = bench.core.params.tracking.doubt(1.0)
    assert doubt > 2
    alike, *_ = left(None, sought_noise=3.0 * doubt, sought_size_noise=16.0 * doubt)
    assert hardly == pytest.approx(alike, rel=1e-9)


def test_a_window_far_from_where_the_sign_is_expected_is_something_else() -> None:
    """The filter's own uncertainty says how far is too far."""
    events = {}
    for sigmas in (None, 3.0):
        bench = Bench(relocalise_after=1, sought_sigmas=sigmas)
        bench.learner.moved = 30.0
        frame = bench.step(NONE)
        (track,) = frame.tracks
        assert track.relocalisation is not None
        assert track.prediction is not None
        assert (track.source == "relocalised") == (sigmas is None)
        assert np.array_equal(track.box, track.prediction.box) == (sigmas is not None)
        events[sigmas] = [(event.kind, event.text) for event in frame.events if "window" in event.text]
    assert events[None] == [
        ("relocalised", "Track 1 has had no detection for 1 frames; a window like it is 30 px left.")
    ]
    ((kind, text),) = events[3.0]
    assert kind == "rejected"
    assert "30 px left, too far from where it is expected (" in text


def test_a_sign_unseen_is_left_to_the_gate_on_demand() -> None:
    bench = Bench(relocalise_after=None)
    assert [bench.step(NONE).tracks[0].source for _ in range(4)] == ["predicted"] * 4
    assert bench.learner.calls == []


def test_a_search_without_success_leaves_a_confident_prediction() -> None:
    bench = Bench(relocalise_after=1, sought_probability=0.7)
    bench.learner.probability = 0.6
    frame = bench.step(NONE)
    assert frame.tracks[0].source == "predicted"
    assert frame.tracks[0].relocalisation is not None
    assert [event.kind for event in frame.events if event.kind == "rejected"] == []


def test_rejected_without_detection_learns_a_negative_and_relocalises() -> None:
    bench = Bench(position_unit="px", tau=15.0)
    Gate.confident = False
    frame = bench.step(NONE)
    (track,) = frame.tracks
    assert bench.learner.calls == [("learn", -1, 5), ("relocalise", 0, 5)]
    assert track.source == "relocalised"
    assert track.relocalisation is not None
    assert np.array_equal(track.box, track.relocalisation.box)
    assert track.samples == (Sample("learned", -1, "prediction", 5),)
    (event,) = [event for event in frame.events if event.kind == "relocalised"]
    assert event.text == "Prediction of track 1 rejected, L = 99.0 > 15, symmetry 0.20 is low; relocalised 6 px left."
    before = track.box
    Gate.confident = True
    (after,) = bench.step(NONE).tracks
    assert after.prediction is not None
    assert after.prediction.box[0] < 79.0, "the window is the filter's measurement as well"
    assert before[0] == pytest.approx(74.0, abs=2.0)


def test_rejected_with_detection_follows_the_parameter() -> None:
    Gate.confident = True
    paper = Bench(rejected_measurement="relocalised")
    default = Bench(rejected_measurement="detection")
    Gate.confident = False
    (by_window,) = paper.step(detection(82.0)).tracks
    assert by_window.source == "relocalised"
    assert by_window.detection == 0
    frame = default.step(detection(82.0))
    (by_detection,) = frame.tracks
    assert by_detection.source == "detected"
    assert by_detection.relocalisation is None
    assert ("relocalise", 0, 5) not in default.learner.calls
    assert ("learn", -1, 5) in default.learner.calls
    assert [event.kind for event in frame.events] == ["rejected"]


def test_an_improbable_window_does_not_replace_the_prediction() -> None:
    bench = Bench(relocalise_probability=0.7)
    bench.learner.probability = 0.6
    Gate.confident = False
    frame = bench.step(NONE)
    (track,) = frame.tracks
    assert track.source == "predicted"
    assert track.relocalisation is not None
    assert any("no window around it looks like the sign" in event.text for event in frame.events)


def test_only_a_sure_relocalisation_keeps_a_track_alive() -> None:
    def frames_until_death(probability: float) -> int:
        Gate.confident = True
        bench = Bench(max_coast=3, sure_probability=0.5, max_undetected=12)
        bench.learner.probability = probability
        Gate.confident = False
        count = 0
        while bench.step(NONE).tracks[-1].state != "dead" and count < 30:
            count += 1
        return count

    assert frames_until_death(0.2) <= 4
    assert frames_until_death(0.8) > 6


def test_kalman_filter_alone() -> None:
    bench = Bench(use_online=False)
    Gate.confident = False
    (track,) = bench.step(detection(82.0)).tracks
    assert bench.learner.calls == []
    assert track.source == "detected"
    assert track.samples == ()
    assert track.gate is not None, "the factors stay on record"
    assert not track.gate.confident
    (track,) = bench.step(NONE).tracks
    assert track.source == "predicted"


def test_the_frame_of_death_keeps_its_factors() -> None:
    bench = Bench(max_coast=0)
    frame = bench.step(NONE)
    (track,) = frame.tracks
    assert track.state == "dead"
    assert track.gate is not None
    assert track.recognition is None
    assert [event.kind for event in frame.events][-1] == "died"
    assert bench.step(NONE).tracks == ()


def test_votes_add_up_and_a_change_of_class_is_an_event() -> None:
    bench = Bench(fusion_mode="equal")
    Classifier.class_id = 9
    changed = []
    for _ in range(8):
        frame = bench.step(detection(80.0))
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
def test_odd_boxes_do_no_harm(box: list[float]) -> None:
    bench = Bench()
    one = np.array([5.0])
    odd = Detections(np.array([box]), one, np.array([0.5]), one)
    for _ in range(4):
        frame = bench.step(odd)
    assert all(np.isfinite(track.box).all() for track in frame.tracks)


def test_time_counts_in_nominal_intervals(monkeypatch: pytest.MonkeyPatch) -> None:
    steps: list[float] = []
    bench = Bench()
    predict: Callable[..., object] = bench.core._tracker.predict
    monkeypatch.setattr(bench.core._tracker, "predict", lambda dt, shift: steps.append(dt) or predict(dt, shift))
    for seconds in (0.20, 0.28, 0.28):
        bench.k += 1
        bench.core.step(FrameInput(bench.k, seconds, NONE, (0.0, 0.0), FramePixels(PICTURE)))
    assert steps == [pytest.approx(1.0), pytest.approx(2.0), pytest.approx(1e-3)]


def test_two_cores_do_not_share_anything() -> None:
    a, b = Bench(), Bench()
    a.step(detection(80.0))
    frame = b.step(detection(80.0))
    assert [track.track_id for track in frame.tracks] == [1]
