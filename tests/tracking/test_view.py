"""Tracks at the edge of the view, and while the camera turns, drives or stands still."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tracking.approaching_sign import HEIGHT, PARAMS, WIDTH, approach, detections, event_kinds, run_tracker
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.records import Detections
from tsr_engine.tracking.tracker import Tracker


def test_death_at_the_edge_of_the_view() -> None:
    frames = {f: detections((600 + 12 * f, 200, 640 + 12 * f, 240, 2.0)) for f in range(8)}
    out = run_tracker(Tracker(PARAMS, WIDTH, HEIGHT), frames, 20)
    end = next(f for f in out if "died" in event_kinds(f))
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
    out = {
        y: run_tracker(Tracker(TrackingParams(level_frames=0, coast_foe_y=y), WIDTH, HEIGHT), seen, 24)
        for y in (None, 0.7)
    }
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
