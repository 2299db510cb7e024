"""Life of tracks: birth, confirmation, coasting, re-attachment, duplicates, death."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tracking.approaching_sign import HEIGHT, PARAMS, WIDTH, approach, detections, event_kinds, run_tracker
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.records import Detections
from tsr_engine.tracking.tracker import Tracker


def test_birth_and_confirmation_after_k_detections() -> None:
    out = run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), {f: detections(approach(f, score=0.5)) for f in range(3)}, 3)
    assert [event_kinds(f) for f in out] == [["born"], [], ["confirmed"]]
    assert [f.tracks[0].state for f in out] == ["tentative", "tentative", "confirmed"]
    assert out[0].tracks[0].prediction is None
    assert out[2].tracks[0].prediction is not None
    assert out[2].tracks[0].detection == 0
    assert out[2].tracks[0].source == "detected"


def test_confirmation_counts_detections_within_its_window() -> None:
    strict = PARAMS.model_copy(update={"confirm_score": -10.0, "sure_score": None})
    found = {f: detections(approach(f)) for f in (0, 5, 10, 11)}  # the first one is more than eight frames old
    out = run_tracker(Tracker(strict, WIDTH, HEIGHT), found, 12)
    (event,) = [e for f in out for e in f.events if e.kind == "confirmed"]
    assert event.text == "Track 1 is confirmed by 3 detections in its last 8 frames."
    assert event.values == {"hits": 3, "frames": 12, "since": 0}
    at_once = strict.model_copy(update={"confirm_hits": 1})
    assert run_tracker(Tracker(at_once, WIDTH, HEIGHT), found, 1)[0].events[-1].text == (
        "Track 1 is confirmed by 1 detection in its last 1 frame."
    )


@pytest.mark.parametrize(("scores", "confirmed"), [((2.0, 1.1), True), ((2.0, 0.9), False), ((9.0,), False)])
def test_two_confident_detections_confirm_at_once(scores: tuple[float, ...], confirmed: bool) -> None:
    seen = {f: detections(approach(f, score)) for f, score in enumerate(scores)}
    out = run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), seen, 4)
    assert any(t.state == "confirmed" for f in out for t in f.tracks) is confirmed
    three = PARAMS.model_copy(update={"sure_score": None})
    assert all(t.state == "tentative" for f in run_tracker(Tracker(three, WIDTH, HEIGHT), seen, 4) for t in f.tracks)


@pytest.mark.parametrize(("hits", "survives"), [(1, 20), (3, 40)])
def test_relocalisations_prolong_the_life_of_a_tentative_track_less(hits: int, survives: int) -> None:
    """What one weak detection shows may be no sign; a track that waits there takes the detections of another one."""
    tracker = Tracker(PARAMS.model_copy(update={"max_coast": 20, "max_undetected": 40}), WIDTH, HEIGHT)
    for frame in range(hits):
        tracker.step(frame, detections(approach(frame, score=0.5)))
    undetected = 0
    while tracker.predict():
        tracker.associate(Detections.empty())
        box = np.array(approach(hits + undetected)[:4])
        tracker.correct(1, box, source="relocalised", confident=True)
        tracker.finish(hits + undetected)
        undetected += 1
    assert undetected == survives + 1


@pytest.mark.parametrize("motion", ["looming", "constant_velocity", "paper"])
def test_boxes_without_area_neither_start_nor_move_a_track(motion: str) -> None:
    params = PARAMS.model_copy(update={"motion": motion})
    x1, y1, x2, y2, _ = approach(1)
    empty = detections((x1, y1, x1, y2, 5.0), (x1, y2, x2, y2, 5.0), (x2, y2, x1, y1, 5.0))
    tracker = Tracker(params, WIDTH, HEIGHT)
    assert not tracker.step(0, empty).tracks
    first = tracker.step(1, detections(approach(0)))
    after = tracker.step(2, empty)
    assert [t.track_id for t in first.tracks] == [t.track_id for t in after.tracks] == [1]
    assert (after.tracks[0].source, after.tracks[0].detection) == ("predicted", None)
    tracker.predict()
    with pytest.raises(ValueError, match="corrected by a box with area"):
        tracker.correct(1, empty.boxes[0])


def test_weak_detections_continue_but_neither_start_nor_confirm_a_track() -> None:
    weak = {f: detections(approach(f, score=-1.8)) for f in range(6)}
    assert all(not f.tracks for f in run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), weak, 6))
    weak[0] = detections(approach(0, score=1.0))
    out = run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), weak, 6)
    assert [f.tracks[0].state for f in out] == ["tentative"] * 6
    assert [f.tracks[0].detection for f in out] == [0] * 6


def test_the_result_follows_the_detection_more_closely_than_the_state_does() -> None:
    jump = {f: detections(approach(f, offset=4.0 if f == 5 else 0.0)) for f in range(7)}
    box, after = {}, {}
    for share in (1.0, 0.35):
        out = run_tracker(Tracker(PARAMS.model_copy(update={"result_noise": share}), WIDTH, HEIGHT), jump, 7)
        box[share] = out[5].tracks[0].box
        prediction = out[6].tracks[0].prediction
        assert prediction is not None
        after[share] = prediction.box
    measured = np.array(approach(5, offset=4.0)[:4])
    assert np.abs(box[0.35] - measured).max() < np.abs(box[1.0] - measured).max()
    # The next prediction depends on the state alone.
    assert after[0.35] == pytest.approx(after[1.0], abs=0)


def test_an_uncertain_detection_moves_a_track_less() -> None:
    """The weight falls with the score below that of a clear detection; the paper's tracker ignores the score."""

    def moved(score: float, **changed: float) -> float:
        tracker = Tracker(PARAMS.model_copy(update=changed), WIDTH, HEIGHT)
        for f in range(4):
            tracker.step(f, detections(approach(f, score=9.0)))
        x1, y1, x2, y2, _ = approach(4)
        (track,) = tracker.step(4, detections((x1 + 3, y1, x2 + 3, y2, score))).tracks
        assert track.prediction is not None
        return float(track.box[0] - track.prediction.box[0])

    clear = moved(PARAMS.clear_score)
    assert moved(PARAMS.clear_score + 5) == clear
    assert clear > moved(4.0) > moved(0.0) > 0
    assert moved(0.0, noise_score=0.0) == pytest.approx(clear)
    assert PARAMS.noise_scale(PARAMS.clear_score - 1) == pytest.approx(np.exp(PARAMS.noise_score))
    # However uncertain, the measurement has a tiny weight and causes no overflow.
    assert 0 <= moved(0.0, clear_score=1e308) < 1e-6


def test_a_single_false_detection_is_forgotten() -> None:
    out = run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), {0: detections(approach(0))}, 8)
    assert "died" in [k for f in out for k in event_kinds(f)]
    assert not out[-1].tracks
    assert all(t.state == "tentative" for f in out for t in f.tracks)


def test_a_gap_is_bridged_by_predictions_and_the_track_is_re_attached() -> None:
    frames = {f: detections(approach(f)) for f in range(45) if not 20 <= f < 32}
    out = run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), frames, 45)
    assert {t.track_id for f in out for t in f.tracks} == {1}
    assert [out[f].tracks[0].source for f in range(20, 32)] == ["predicted"] * 12
    assert event_kinds(out[20]) == ["missed"]
    assert all("missed" not in event_kinds(out[f]) for f in range(21, 32))
    expected = np.array(approach(31)[:4])
    assert np.abs(out[31].tracks[0].box - expected).max() < 0.15 * (expected[2] - expected[0])


def test_score_fades_without_detection_and_returns_with_one() -> None:
    frames = {f: detections(approach(f)) for f in (0, 1, 2, 3, 6)}
    scores = [f.tracks[0].score for f in run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), frames, 7)]
    # Margin above low_score (-2) is 4, then 4 * 0.9, 4 * 0.81.
    assert scores[3:] == pytest.approx([2.0, -2 + 4 * 0.9, -2 + 4 * 0.81, 2.0])


def test_death_after_a_run_without_evidence() -> None:
    params = PARAMS.model_copy(update={"max_coast": 5})
    frames = {f: detections((300, 200, 330, 230, 2.0)) for f in range(4)}
    out = run_tracker(Tracker(params, WIDTH, HEIGHT), frames, 10)
    assert out[8].tracks
    assert not out[9].tracks
    assert event_kinds(out[9]) == ["died"]
    assert out[9].events[0].values["missed"] == 6


def test_confident_relocalisation_keeps_a_track_alive_for_a_limited_time() -> None:
    params = PARAMS.model_copy(update={"max_coast": 3, "max_undetected": 12})
    box = np.array([300.0, 200.0, 330.0, 230.0])
    alive = {}
    for confident in (True, False):
        tracker = Tracker(params, WIDTH, HEIGHT)
        for f in range(30):
            if f < 4:
                tracker.step(f, detections((*box, 2.0)))
                continue
            for track_id in tracker.predict():
                tracker.correct(track_id, box, source="relocalised", confident=confident, result=box)
            frame = tracker.finish(f)
            if frame.tracks:
                assert frame.tracks[0].source == "relocalised"
                assert frame.tracks[0].box == pytest.approx(box)
                alive[confident] = f
    assert alive == {True: 15, False: 6}


def test_a_second_detection_on_one_sign_starts_no_second_track() -> None:
    frames = {}
    for f in range(12):
        x1, y1, x2, y2, s = approach(f)
        w = x2 - x1
        nested = (x1 + 0.3 * w, y1 + 0.3 * w, x1 + 0.75 * w, y1 + 0.75 * w, 1.0)
        frames[f] = detections((x1, y1, x2, y2, s), (x1 + 0.3 * w, y1, x2 + 0.3 * w, y2, 1.0), nested)
    out = run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), frames, 12)
    assert {t.track_id for f in out for t in f.tracks} == {1}


def test_two_signs_on_one_pole_are_two_tracks() -> None:
    frames = {}
    for f in range(20):
        x1, y1, x2, y2, s = approach(f)
        frames[f] = detections((x1, y1, x2, y2, s), (x1, y2 + 1, x2, 2 * y2 - y1 + 1, s))
    out = run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), frames, 20)
    assert {t.track_id for f in out for t in f.tracks} == {1, 2}
    assert all(t.box[1] < out[-1].tracks[1].box[1] for t in out[-1].tracks[:1])


def test_coinciding_tracks_become_one() -> None:
    """A second sign moves into the first: the undetected one ends."""
    frames = {
        f: detections((300, 200, 330, 230, 2.0), (300 + 8 * (8 - f), 200, 330 + 8 * (8 - f), 230, 2.0))
        for f in range(4)
    }
    frames |= {f: detections((300, 200, 330, 230, 2.0)) for f in range(4, 12)}
    params = TrackingParams(motion="constant_velocity", duplicate_iou=0.9)
    out = run_tracker(Tracker(params, WIDTH, HEIGHT), frames, 12)
    ended = [event for f in out for event in f.events if event.kind == "died"]
    assert [t.track_id for t in out[-1].tracks] == [1]
    assert len(ended) == 1
    assert ended[0].values["into"] == 1


def test_association_alone_moves_no_box() -> None:
    tracker = Tracker(PARAMS, WIDTH, HEIGHT)
    tracker.step(0, detections(approach(0)))
    before = tracker.predict()[1].box
    assert tracker.associate(detections(approach(1, offset=3.0))) == {1: 0}
    frame = tracker.finish(1)
    assert frame.tracks[0].box == pytest.approx(before)
    assert frame.tracks[0].source == "predicted"
    assert frame.tracks[0].missed == 0


def test_ids_are_counted_per_instance() -> None:
    frames = {f: detections(approach(f), (50, 50, 80, 80, 1.0)) for f in range(3)}
    first, second = (run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), frames, 3) for _ in range(2))
    assert [[t.track_id for t in f.tracks] for f in first] == [[1, 2]] * 3
    for a, b in zip(first, second, strict=True):
        for s, t in zip(a.tracks, b.tracks, strict=True):
            assert s.track_id == t.track_id
            np.testing.assert_array_equal(s.box, t.box)
    later = Tracker(PARAMS, WIDTH, HEIGHT, first_id=40)
    assert [t.track_id for f in run_tracker(later, frames, 1) for t in f.tracks] == [40, 41]


@pytest.mark.parametrize("motion", ["paper", "constant_velocity", "looming"])
def test_noisy_approaches_keep_their_id(motion: str) -> None:
    """20 approaches at 80 % detection and 10 % edge noise."""
    ids, covered, frames = 0, 0, 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        tracker = Tracker(PARAMS.model_copy(update={"motion": motion}), WIDTH, HEIGHT)
        seen = set()
        for f in range(45):
            *box, score = approach(f)
            noisy = np.array(box) + rng.normal(0, 0.1 * (box[2] - box[0]), 4)
            out = tracker.step(f, detections((*noisy, score)) if rng.random() < 0.8 else Detections.empty())
            sure = [t for t in out.tracks if t.state == "confirmed"]
            seen |= {t.track_id for t in sure}
            frames += 1
            covered += bool(sure)
        ids += len(seen)
    assert ids <= 21
    assert covered / frames > 0.88
