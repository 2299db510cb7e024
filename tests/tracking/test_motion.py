"""Motion models against filterpy, hand-computed numbers, and targets that follow each model."""

from __future__ import annotations

import numpy as np
import pytest
from filterpy.common import Q_discrete_white_noise
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from tsr_engine.geometry.boxes import to_xyxy
from tsr_engine.params import Params
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.protocols import NO_CUT_EDGES, Edges, MeasurementQuality, MotionModel
from tsr_engine.records import FloatArray
from tsr_engine.tracking.measurement_noise import MeasurementNoise
from tsr_engine.tracking.motion import make_motion
from tsr_engine.tracking.motion_constant_velocity import ConstantVelocityMotion
from tsr_engine.tracking.motion_looming import FY, RATE, LoomingMotion, LoomingNoise
from tsr_engine.tracking.motion_paper import PaperMotion

NOISE = MeasurementNoise(0.07, 0.14)
NAMES = ("paper", "constant_velocity", "looming")
STILL = (0.0, 0.0)


def model(name: str) -> MotionModel:
    return make_motion(TrackingParams(motion=name))


def looming_box(k: float, foe: tuple[float, float] = (360.0, 288.0), aspect: float = 1.0) -> np.ndarray:
    """A sign 20 px wide at k = 0 whose depth falls by 2 % of the first depth a frame, on a ray from the FOE."""
    w = 20.0 / (1.0 - 0.02 * k)
    return np.array([foe[0] + 4.0 * w, foe[1] - 2.5 * w, w, aspect * w])


def prediction_errors(motion: MotionModel, boxes: list[np.ndarray], dts: list[float]) -> list[np.ndarray]:
    state = motion.initiate(boxes[0], 720, 576)
    errors = []
    for box, dt in zip(boxes[1:], dts, strict=True):
        state = motion.predict(state, dt, STILL)
        errors.append(motion.box_of(state) - box)
        state = motion.update(state, box)
    return errors


def test_noise_by_hand() -> None:
    # 7 % of 100 and 50, 14 % of 100 and 50, doubled.
    assert np.diag(NOISE.covariance(100, 50, MeasurementQuality(2.0, 2.0))) == pytest.approx(
        [14.0**2, 7.0**2, 28.0**2, 14.0**2]
    )
    # The centre doubled, the size eight times; then both halved.
    unsure = MeasurementQuality(2.0, 8.0)
    assert np.diag(NOISE.covariance(100, 50, unsure)) == pytest.approx([14.0**2, 7.0**2, 112.0**2, 56.0**2])
    assert np.diag(NOISE.covariance(100, 50, unsure.times(0.5))) == pytest.approx([7.0**2, 3.5**2, 56.0**2, 28.0**2])


def test_the_factory_makes_the_named_model() -> None:
    assert [model(name).name for name in NAMES] == list(NAMES)
    assert make_motion(Params.preset("paper").tracking).name == "paper"


class TestPaper:
    def test_displacement_by_hand(self) -> None:
        motion = PaperMotion(NOISE, window=2)
        state = motion.initiate(np.array([100.0, 50.0, 20.0, 20.0]), 720, 576)
        # Exact measurements: every estimate is the measurement (noise 0).
        for x, ahead in ((104.0, 100.0), (110.0, 108.0), (118.0, 115.0)):
            state = motion.predict(state, 1.0, STILL)
            assert motion.box_of(state)[0] == pytest.approx(ahead)
            state = motion.update(state, np.array([x, 50.0, 20.0, 20.0]), MeasurementQuality(1e-6, 1e-6))
        # Mean of the last two displacements, 6 and 8: 118 + 7.
        assert motion.box_of(motion.predict(state, 1.0, STILL))[0] == pytest.approx(125.0, abs=1e-4)
        # Half the time, half the way.
        assert motion.box_of(motion.predict(state, 0.5, STILL))[0] == pytest.approx(121.5, abs=1e-4)

    def test_gain_by_hand(self) -> None:
        motion = PaperMotion(MeasurementNoise(0.1, 0.1), process=0.1)
        state = motion.initiate(np.array([100.0, 50.0, 10.0, 10.0]), 720, 576)
        state = motion.predict(state, 1.0, STILL)
        # P = 1 + 1, R = 1: gain 2/3, new variance 2/3.
        state = motion.update(state, np.array([103.0, 50.0, 10.0, 10.0]))
        assert motion.box_of(state)[0] == pytest.approx(102.0)
        assert np.diag(state.covariance) == pytest.approx(np.full(4, 2 / 3))

    def test_the_window_limits_the_state(self) -> None:
        motion = PaperMotion(NOISE, window=3)
        state = motion.initiate(np.array([100.0, 50.0, 20.0, 20.0]), 720, 576)
        for _ in range(10):
            state = motion.predict(state, 1.0, STILL)
        assert state.mean.shape == (4 + 3 * 5,)

    def test_camera_shift_is_not_counted_twice(self) -> None:
        motion = PaperMotion(NOISE)
        state = motion.initiate(np.array([100.0, 50.0, 20.0, 20.0]), 720, 576)
        for k in range(1, 8):
            state = motion.predict(state, 1.0, (10.0, -3.0))
            assert motion.box_of(state)[:2] == pytest.approx([100.0 + 10 * k, 50.0 - 3 * k])


class TestConstantVelocity:
    def test_equals_filterpy_object(self) -> None:
        rng = np.random.default_rng(5)
        motion = ConstantVelocityMotion(NOISE, process=0.02)
        state = motion.initiate(np.array([200.0, 100.0, 30.0, 40.0]), 720, 576)
        kf = KalmanFilter(dim_x=8, dim_z=4, dim_u=2)
        kf.x, kf.P = state.mean.copy(), state.covariance.copy()
        kf.H, kf.B = np.eye(4, 8), np.eye(8, 2)
        for k in range(40):
            dt = (1.0, 0.5, 2.0)[k % 3]
            shift = rng.normal(0, 3, 2)
            kf.F = np.eye(8) + dt * np.eye(8, k=4)
            kf.Q = np.zeros((8, 8))
            for i, size in enumerate((kf.x[2], kf.x[3], kf.x[2], kf.x[3])):
                kf.Q[np.ix_([i, i + 4], [i, i + 4])] = Q_discrete_white_noise(2, dt, (0.02 * size) ** 2)
            kf.predict(u=shift)
            state = motion.predict(state, dt, (shift[0], shift[1]))
            np.testing.assert_allclose(state.mean, kf.x, rtol=1e-10)
            np.testing.assert_allclose(state.covariance, kf.P, rtol=1e-9, atol=1e-10)
            if k % 4:
                z = np.array([200.0 + 3 * k, 100.0 - k, 30.0 + 0.5 * k, 40.0]) + rng.normal(0, 1, 4)
                kf.R = NOISE.covariance(kf.x[2], kf.x[3])
                np.testing.assert_allclose(motion.innovation(state), kf.H @ kf.P @ kf.H.T + kf.R, rtol=1e-9, atol=1e-10)
                kf.update(z)
                state = motion.update(state, z)
                np.testing.assert_allclose(state.mean, kf.x, rtol=1e-10)
                np.testing.assert_allclose(state.covariance, kf.P, rtol=1e-9, atol=1e-10)


class TestLooming:
    def test_prediction_by_hand(self) -> None:
        motion = LoomingMotion(NOISE, LoomingNoise(growth_start=0.2), foe=(0.5, 0.5))
        state = motion.initiate(np.array([460.0, 188.0, 40.0, 20.0]), 720, 576)
        # q = 1/40 falls by 20 % to 1/50; the centre's distance from (360, 288) grows by 50/40.
        ahead = motion.predict(state, 1.0, (3.0, -2.0))
        assert motion.box_of(ahead) == pytest.approx([360 + 125 + 3, 288 - 125 - 2, 50.0, 25.0])
        # Two intervals: 1/40 - 2 * 0.2/40 = 0.6/40.
        assert motion.box_of(motion.predict(state, 2.0, STILL))[2] == pytest.approx(40 / 0.6)
        # No time, no motion.
        assert motion.box_of(motion.predict(state, 0.0, STILL)) == pytest.approx([460.0, 188.0, 40.0, 20.0])

    def test_a_given_focus_applies_to_one_step_only(self) -> None:
        motion = LoomingMotion(NOISE, LoomingNoise(growth_start=0.2), foe=(0.5, 0.5))
        state = motion.initiate(np.array([460.0, 188.0, 40.0, 20.0]), 720, 576)
        ahead = motion.predict(state, 1.0, (3.0, -2.0), 388.0)
        # From (360, 388): the centre lies 200 px above it and grows away by 50/40.
        assert motion.box_of(ahead) == pytest.approx([360 + 125 + 3, 388 - 250 - 2, 50.0, 25.0])
        assert ahead.mean[FY] == 288.0
        assert state.mean[FY] == 288.0

    def test_jacobian_is_the_derivative(self) -> None:
        motion = LoomingMotion(NOISE, LoomingNoise(0.03, 0.03, 0, 0, 0, 0, 0, 0, 0.9, 0.1))
        state = motion.initiate(np.array([500.0, 150.0, 30.0, 24.0]), 720, 576)
        base = motion.predict(state, 1.5, (1.0, 2.0))
        F = np.zeros((9, 9))
        for i in range(9):
            step = 1e-6 * max(abs(state.mean[i]), 1e-3)
            moved = state.mean.copy()
            moved[i] += step
            ahead = motion.predict(type(state)(moved, state.covariance), 1.5, (1.0, 2.0))
            F[:, i] = (ahead.mean - base.mean) / step
        np.testing.assert_allclose(base.covariance, F @ state.covariance @ F.T, rtol=1e-3, atol=1e-9)

    def test_only_the_looming_model_predicts_a_looming_target_exactly(self) -> None:
        boxes = [looming_box(k, aspect=1.2) for k in range(40)]
        dts = [1.0] * 39
        last = {name: np.abs(prediction_errors(model(name), boxes, dts)[-1]).max() for name in NAMES}
        assert last["looming"] < 0.1
        assert last["constant_velocity"] > 2.0
        assert last["paper"] > 4.0

    def test_variable_frame_rate(self) -> None:
        dts = [1.0, 2.0, 0.5, 1.0, 3.0, 1.0, 0.5, 2.0, 1.0, 1.0] * 2
        times = np.concatenate([[0.0], np.cumsum(dts)])
        boxes = [looming_box(t) for t in times]
        errors = prediction_errors(model("looming"), boxes, dts)
        assert np.abs(errors[-1]).max() < 0.1

    def test_a_wrong_focus_of_expansion_is_corrected_from_the_path(self) -> None:
        boxes = [looming_box(k, foe=(340.0, 340.0)) for k in range(40)]
        errors = prediction_errors(model("looming"), boxes, [1.0] * 39)
        fixed = prediction_errors(make_motion(TrackingParams(foe_spread=0.0, drift_process=0.0)), boxes, [1.0] * 39)
        assert np.abs(errors[-1][:2]).max() < 0.5 * np.abs(fixed[-1][:2]).max()

    def test_a_wild_measurement_leaves_a_usable_state(self) -> None:
        motion = model("looming")
        state = motion.initiate(np.array([300.0, 200.0, 20.0, 20.0]), 720, 576)
        for z in ([300.0, 200.0, 500.0, 3.0], [0.0, 0.0, 1.0, 400.0], [300.0, 200.0, 20.0, 20.0]):
            state = motion.update(motion.predict(state, 1.0, STILL), np.array(z), MeasurementQuality(0.01, 0.01))
            box = motion.box_of(state)
            assert np.isfinite(box).all()
            assert (box[2:] > 0).all()

    def test_growth_is_learned(self) -> None:
        motion = model("looming")
        state = motion.initiate(looming_box(0), 720, 576)
        for k in range(1, 30):
            state = motion.update(motion.predict(state, 1.0, STILL), looming_box(k))
        assert state.mean[RATE] == pytest.approx(-0.02 / 20.0, rel=0.02)


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_state_stays_sound(name: str, seed: int) -> None:
    """Covariances stay symmetric and positive, boxes finite and non-empty, over random measurements and gaps."""
    rng = np.random.default_rng(seed)
    motion = model(name)
    state = motion.initiate(np.array([300.0, 200.0, 30.0, 30.0]), 720, 576)
    for k in range(25):
        state = motion.predict(state, float(rng.choice([0.5, 1.0, 2.0])), tuple(rng.normal(0, 5, 2)))
        if rng.random() < 0.6:
            z = looming_box(k) + rng.normal(0, 3, 4)
            state = motion.update(state, z, MeasurementQuality(*rng.uniform(0.5, 2, 2).tolist()))
        innovation = motion.innovation(state)
        assert np.allclose(innovation, innovation.T, rtol=1e-6, atol=1e-6)
        assert np.linalg.eigvalsh(innovation).min() > 0
        box = motion.box_of(state)
        assert np.isfinite(box).all()
        assert (box[2:] > 0).all()


@pytest.mark.parametrize("name", NAMES)
def test_an_unseen_edge_is_not_measured(name: str) -> None:
    motion = model(name)
    state = motion.initiate(np.array([300.0, 200.0, 30.0, 30.0]), 720, 576)
    for _ in range(5):
        state = motion.update(motion.predict(state, 1.0, STILL), np.array([300.0, 200.0, 30.0, 30.0]))
    hidden = (False, False, True, False)

    def after(left: float, right: float, cut: Edges) -> FloatArray:
        z = np.array([(left + right) / 2, 200.0, right - left, 30.0])
        return motion.box_of(motion.update(state, z, MeasurementQuality(cut=cut)))

    assert after(285.0, 300.0, hidden) == pytest.approx(after(285.0, 315.0, hidden), abs=0.2)
    assert after(285.0, 300.0, NO_CUT_EDGES)[2] < after(285.0, 315.0, NO_CUT_EDGES)[2] - 1.0
    moved, still = (to_xyxy(after(left, 315.0, hidden))[0] for left in (275.0, 285.0))
    assert moved < still - 1.0  # the edge that was seen still counts
