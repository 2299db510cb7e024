"""Life of tracks: birth, confirmation, coasting, re-attachment, duplicates, death."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.params.tracking import TrackingParams
from tsr_engine.records import Detections
from tsr_engine.tracking.tracker import TrackedFrame, Tracker

WIDTH, HEIGHT = 720, 576
PARAMS = TrackingParams()


def detections(*rows: tuple[float, float, float, float, float]) -> Detections:
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    scores = table[:, 4]
    return Detections(table[:, :4], scores, np.full(len(table), 0.5), scores)


def approach(frame: int, score: float = 2.0, offset: float = 0.0) -> tuple[float, float, float, float, float]:
    """A sign that looms, to the upper right of the FOE."""
    w = 20.0 / (1.0 - 0.015 * frame)
    x, y = WIDTH / 2 + 3 * w + offset, HEIGHT / 2 - 2 * w
    return (x, y, x + w, y + w, score)


def run(tracker: Tracker, frames: dict[int, Detections], count: int) -> list[TrackedFrame]:
    return [tracker.step(f, frames.get(f, Detections.empty())) for f in range(count)]


def kinds(frame: TrackedFrame) -> list[str]:
    return [event.kind for event in frame.events]


def test_birth_and_confirmation_after_k_detections() -> None:
    out = run(Tracker(PARAMS, WIDTH, HEIGHT), {f: detections(approach(f, score=0.5)) for f in range(3)}, 3)
    assert [kinds(f) for f in out] == [["born"], [], ["confirmed"]]
    assert [f.tracks[0].state for f in out] == ["tentative", "tentative", "confirmed"]
    assert out[0].tracks[0].prediction is None
    assert out[2].tracks[0].prediction is not None
    assert out[2].tracks[0].detection == 0
    assert out[2].tracks[0].source == "detected"


def test_confirmation_counts_detections_within_its_window() -> None:
    strict = PARAMS.model_copy(update={"confirm_score": -10.0, "sure_score": None})
    found = {f: detections(approach(f)) for f in (0, 5, 10, 11)}  # the first one is more than eight frames old
    out = run(Tracker(strict, WIDTH, HEIGHT), found, 12)
    (event,) = [e for f in out for e in f.events if e.kind == "confirmed"]
    assert event.text == "Track 1 is confirmed by 3 detections in its last 8 frames."
    assert event.values == {"hits": 3, "frames": 12, "since": 0}
    at_once = strict.model_copy(update={"confirm_hits": 1})
    assert run(Tracker(at_once, WIDTH, HEIGHT), found, 1)[0].events[-1].text == (
        "Track 1 is confirmed by 1 detection in its last 1 frame."
    )


@pytest.mark.parametrize(("scores", "confirmed"), [((2.0, 1.1), True), ((2.0, 0.9), False), ((9.0,), False)])
def test_two_confident_detections_confirm_at_once(scores: tuple[float, ...], confirmed: bool) -> None:
    seen = {f: detections(approach(f, score)) for f, score in enumerate(scores)}
    out = run(Tracker(PARAMS, WIDTH, HEIGHT), seen, 4)
    assert any(t.state == "confirmed" for f in out for t in f.tracks) is confirmed
    three = PARAMS.model_copy(update={"sure_score": None})
    assert all(t.state == "tentative" for f in run(Tracker(three, WIDTH, HEIGHT), seen, 4) for t in f.tracks)


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
    assert all(not f.tracks for f in run(Tracker(PARAMS, WIDTH, HEIGHT), weak, 6))
    weak[0] = detections(approach(0, score=1.0))
    out = run(Tracker(PARAMS, WIDTH, HEIGHT), weak, 6)
    assert [f.tracks[0].state for f in out] == ["tentative"] * 6
    assert [f.tracks[0].detection for f in out] == [0] * 6


def test_the_result_follows_the_detection_more_closely_than_the_state_does() -> None:
    jump = {f: detections(approach(f, offset=4.0 if f == 5 else 0.0)) for f in range(7)}
    box, after = {}, {}
    for share in (1.0, 0.35):
        out = run(Tracker(PARAMS.model_copy(update={"result_noise": share}), WIDTH, HEIGHT), jump, 7)
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
    out = run(Tracker(PARAMS, WIDTH, HEIGHT), {0: detections(approach(0))}, 8)
    assert "died" in [k for f in out for k in kinds(f)]
    assert not out[-1].tracks
    assert all(t.state == "tentative" for f in out for t in f.tracks)


def test_a_gap_is_bridged_by_predictions_and_the_track_is_re_attached() -> None:
    frames = {f: detections(approach(f)) for f in range(45) if not 20 <= f < 32}
    out = run(Tracker(PARAMS, WIDTH, HEIGHT), frames, 45)
    assert {t.track_id for f in out for t in f.tracks} == {1}
    assert [out[f].tracks[0].source for f in range(20, 32)] == ["predicted"] * 12
    assert kinds(out[20]) == ["missed"]
    assert all("missed" not in kinds(out[f]) for f in range(21, 32))
    expected = np.array(approach(31)[:4])
    assert np.abs(out[31].tracks[0].box - expected).max() < 0.15 * (expected[2] - expected[0])


def test_score_fades_without_detection_and_returns_with_one() -> None:
    frames = {f: detections(approach(f)) for f in (0, 1, 2, 3, 6)}
    scores = [f.tracks[0].score for f in run(Tracker(PARAMS, WIDTH, HEIGHT), frames, 7)]
    # Margin above low_score (-2) is 4, then 4 * 0.9, 4 * 0.81.
    assert scores[3:] == pytest.approx([2.0, -2 + 4 * 0.9, -2 + 4 * 0.81, 2.0])


def test_death_after_a_run_without_evidence() -> None:
    params = PARAMS.model_copy(update={"max_coast": 5})
    frames = {f: detections((300, 200, 330, 230, 2.0)) for f in range(4)}
    out = run(Tracker(params, WIDTH, HEIGHT), frames, 10)
    assert out[8].tracks
    assert not out[9].tracks
    assert kinds(out[9]) == ["died"]
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


def test_death_at_the_edge_of_the_view() -> None:
    frames = {f: detections((600 + 12 * f, 200, 640 + 12 * f, 240, 2.0)) for f in range(8)}
    out = run(Tracker(PARAMS, WIDTH, HEIGHT), frames, 20)
    end = next(f for f in out if "died" in kinds(f))
    assert "in view" in end.events[0].text
    assert not out[-1].tracks


@pytest.mark.parametrize("turn", [(14.0, 0.0), (-14.0, 0.0), (0.0, 14.0), (0.0, -14.0)])
def test_a_sign_that_leaves_the_view_keeps_its_size(turn: tuple[float, float]) -> None:
    """A detection ends at the picture's edge; the sign does not."""
    side, tracker = 60.0, Tracker(TrackingParams(level_frames=0), WIDTH, HEIGHT)
    edge = (1 + np.sign(turn)) / 2 * [WIDTH, HEIGHT]  # the middle of the edge that the sign crosses
    for frame in range(10):  # its centre reaches the edge in the last frame
        centre = edge - (9 - frame) * np.array(turn)
        whole = np.concatenate([centre - side / 2, centre + side / 2])
        seen = whole.clip(0, [WIDTH, HEIGHT, WIDTH, HEIGHT])
        tracked = tracker.step(frame, detections((*seen, 2.0)), shift=turn)
    assert float(np.abs(seen - whole).max()) == pytest.approx(side / 2)
    assert tracked.tracks[0].box == pytest.approx(whole, abs=0.1 * side)


@pytest.mark.parametrize(("height", "slowing"), [(1.0, 5.0), (2.4, 3.0)], ids=["over the side", "over the corner"])
def test_a_car_that_stops_at_a_sign_keeps_it(height: float, slowing: float) -> None:
    """An unseen edge gives no measurement, not even of further growth.

    A car of 12 m/s brakes by ``slowing`` m/s^2; a sign of 0.7 m, 3 m to the side and ``height`` m above the camera.
    """
    rng = np.random.default_rng(3)
    tracker, ids, away, speed = Tracker(TrackingParams(), WIDTH, HEIGHT), set(), 40.0, 12.0
    stop = 5.45  # m before the sign, which is then cut by the edge
    for frame in range(200):
        side = 620.0 * 0.7 / away
        middle = np.array([WIDTH / 2 + 620.0 * 3.0 / away, HEIGHT / 2 - 620.0 * height / away])
        whole = np.concatenate([middle - side / 2, middle + side / 2])
        seen = (whole + rng.normal(0.0, 0.01 * side, 4)).clip(0, [WIDTH, HEIGHT, WIDTH, HEIGHT])
        tracked = tracker.step(frame, detections((*seen, 8.0)), shift=(1e-9, 1e-9))
        ids |= {t.track_id for t in tracked.tracks}
        if away - stop <= speed**2 / (2 * slowing):
            speed = max(speed - slowing / 30, 0.0)
        away = max(away - speed / 30, stop)
    assert 0.3 * side > whole[2] - WIDTH > 0.15 * side
    assert bool(whole[1] < -0.1 * side) is (height > 2)
    assert ids == {1}
    box = tracked.tracks[0].box
    assert box.clip(0, [WIDTH, HEIGHT] * 2) == pytest.approx(whole.clip(0, [WIDTH, HEIGHT] * 2), abs=0.1 * side)
    if height < 2:  # the upper and lower edges give its size
        assert box[2] - box[0] == pytest.approx(side, rel=0.15)


def test_open_edges_count_as_measured_without_the_option() -> None:
    seen = (WIDTH - 40.0, 100.0, float(WIDTH), 160.0)  # of a sign 60 px wide
    shown = {}
    for unseen in (True, False):
        tracker = Tracker(TrackingParams(open_edges=unseen, noise_size=0.02), WIDTH, HEIGHT)
        tracker.step(0, detections((WIDTH - 62.0, 100.0, WIDTH - 2.0, 160.0, 4.0)), shift=(1e-9, 1e-9))
        for frame in range(1, 6):
            box = (
                tracker.step(frame, detections((*seen, 4.0)), shift=(20.0 if frame == 1 else 1e-9, 1e-9)).tracks[0].box
            )
        shown[unseen] = float(box[2] - box[0])
    assert shown[True] > 55.0
    assert shown[False] < 50.0


def test_a_second_detection_on_one_sign_starts_no_second_track() -> None:
    frames = {}
    for f in range(12):
        x1, y1, x2, y2, s = approach(f)
        w = x2 - x1
        nested = (x1 + 0.3 * w, y1 + 0.3 * w, x1 + 0.75 * w, y1 + 0.75 * w, 1.0)
        frames[f] = detections((x1, y1, x2, y2, s), (x1 + 0.3 * w, y1, x2 + 0.3 * w, y2, 1.0), nested)
    out = run(Tracker(PARAMS, WIDTH, HEIGHT), frames, 12)
    assert {t.track_id for f in out for t in f.tracks} == {1}


def test_two_signs_on_one_pole_are_two_tracks() -> None:
    frames = {}
    for f in range(20):
        x1, y1, x2, y2, s = approach(f)
        frames[f] = detections((x1, y1, x2, y2, s), (x1, y2 + 1, x2, 2 * y2 - y1 + 1, s))
    out = run(Tracker(PARAMS, WIDTH, HEIGHT), frames, 20)
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
    out = run(Tracker(params, WIDTH, HEIGHT), frames, 12)
    ended = [event for f in out for event in f.events if event.kind == "died"]
    assert [t.track_id for t in out[-1].tracks] == [1]
    assert len(ended) == 1
    assert ended[0].values["into"] == 1


def test_camera_shift_moves_predictions_only_if_enabled() -> None:
    for use, expected in ((True, 12.0), (False, 0.0)):
        tracker = Tracker(TrackingParams(motion="paper", use_camera_shift=use), WIDTH, HEIGHT)
        tracker.step(0, detections((300, 200, 330, 230, 2.0)))
        assert tracker.predict(1.0, (12.0, 0.0))[1].box[0] == pytest.approx(300 + expected)


def test_an_undetected_sign_moves_away_from_the_given_focus() -> None:
    """The given focus is at 0.7 of the height, the filter's in the middle. Frames with detections are the same."""

    def sign(frame: int) -> tuple[float, float, float, float, float]:
        w = 20.0 / (1.0 - 0.02 * frame)
        cx, cy = 0.5 * WIDTH + 4.0 * w, 0.7 * HEIGHT - 4.0 * w
        return (cx - w / 2, cy - w / 2, cx + w / 2, cy + w / 2, 4.0)

    seen = {f: detections(sign(f)) for f in range(16)}
    out = {y: run(Tracker(TrackingParams(level_frames=0, coast_foe_y=y), WIDTH, HEIGHT), seen, 24) for y in (None, 0.7)}
    truth = np.array(sign(23)[:4])
    for y, frames in out.items():
        assert [t.source for f in frames for t in f.tracks] == ["detected"] * 16 + ["predicted"] * 8, y
    for a, b in zip(out[None][:17], out[0.7][:17], strict=True):  # the first one is predicted as before
        assert a.tracks[0].box == pytest.approx(b.tracks[0].box, abs=0.0)
    off = {y: float(np.abs(frames[-1].tracks[0].box - truth)[[1, 3]].max()) for y, frames in out.items()}
    assert off[0.7] < 0.5 * off[None]
    sideways = [frames[-1].tracks[0].box[[0, 2]] for frames in out.values()]
    assert sideways[0] == pytest.approx(sideways[1], abs=0.0)


def test_a_repeated_picture_does_not_move_and_the_next_catches_up() -> None:
    """Pictures 0 1 2 ... 9 9 11 12: the filter follows without a jump."""
    order = [*range(10), 9, 11, 12, 13]
    tracker = Tracker(PARAMS, WIDTH, HEIGHT)
    errors = []
    for f, k in enumerate(order):
        predictions = tracker.predict(1.0, (0.0, 0.0) if f == 10 else (1e-9, 0.0))
        found = detections(approach(k))
        errors += [float(np.abs(p.box - found.boxes[0]).max()) for p in predictions.values()]
        for track_id, row in tracker.associate(found).items():
            tracker.correct(track_id, found.boxes[row])
        tracker.finish(f)
    assert len(errors) == len(order) - 1
    assert max(errors[-5:]) < 0.3


def test_time_passes_in_a_still_scene() -> None:
    tracker = Tracker(TrackingParams(motion="constant_velocity"), WIDTH, HEIGHT)
    for f in range(6):
        tracker.step(f, detections((300 + 10 * f, 200, 340 + 10 * f, 240, 2.0)), shift=(1e-9, 0.0))
    still = [tracker.step(f, Detections.empty(), shift=(0.0, 0.0)).tracks[0].box[0] for f in range(6, 10)]
    steps = np.diff(still)
    assert steps[0] == pytest.approx(0.0)
    assert (steps[1:] > 5).all()


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
    first, second = (run(Tracker(PARAMS, WIDTH, HEIGHT), frames, 3) for _ in range(2))
    assert [[t.track_id for t in f.tracks] for f in first] == [[1, 2]] * 3
    for a, b in zip(first, second, strict=True):
        for s, t in zip(a.tracks, b.tracks, strict=True):
            assert s.track_id == t.track_id
            np.testing.assert_array_equal(s.box, t.box)
    later = Tracker(PARAMS, WIDTH, HEIGHT, first_id=40)
    run(later, frames, 1)
    assert later.living == (40, 41)
    assert later.next_id == 42


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
