"""The global shift on pictures whose motion is known."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.tracking.camera_shift import UNKNOWN_SHIFT, CameraShift, fit_shift


def scene(seed: int = 3, width: int = 720, height: int = 576) -> np.ndarray:
    """Blobs and edges of many sizes, with a margin for motion."""
    rng = np.random.default_rng(seed)
    picture = np.full((height + 200, width + 200, 3), 120, np.uint8)
    for _ in range(400):
        x, y = rng.integers(0, [width + 200, height + 200])
        w, h = rng.integers(6, 60, 2)
        colour = tuple(int(c) for c in rng.integers(20, 235, 3))
        cv2.rectangle(picture, (int(x), int(y)), (int(x + w), int(y + h)), colour, -1)
    return cv2.GaussianBlur(picture, (0, 0), 1.5)


def view(
    picture: np.ndarray, dx: float, dy: float, zoom: float = 1.0, width: int = 720, height: int = 576
) -> np.ndarray:
    """The middle of the scene, zoomed about the picture's centre, then moved by (dx, dy)."""
    cx, cy = (width + 200) / 2, (height + 200) / 2
    matrix = np.array([[zoom, 0, width / 2 + dx - zoom * cx], [0, zoom, height / 2 + dy - zoom * cy]])
    return np.ascontiguousarray(cv2.warpAffine(picture, matrix, (width, height), flags=cv2.INTER_LINEAR))


@pytest.mark.parametrize("shift", [(5.0, -3.0), (-17.5, 0.0), (0.0, 9.0), (30.0, 6.0)])
def test_pure_shift(shift: tuple[float, float]) -> None:
    picture, estimator = scene(), CameraShift()
    assert estimator.step(view(picture, 0, 0)) == UNKNOWN_SHIFT
    assert estimator.step(view(picture, *shift)) == pytest.approx(shift, abs=0.3)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (8.0, -4.0)])
def test_expansion_is_not_measured_as_shift(shift: tuple[float, float]) -> None:
    picture, estimator = scene(), CameraShift()
    estimator.step(view(picture, 0, 0))
    assert estimator.step(view(picture, *shift, zoom=1.05)) == pytest.approx(shift, abs=0.4)


def test_exposure_change_is_not_measured_as_motion() -> None:
    picture, estimator = scene(), CameraShift()
    estimator.step(view(picture, 0, 0))
    darker = (view(picture, 6.0, 2.0) * 0.6).astype(np.uint8)
    assert estimator.step(darker) == pytest.approx((6.0, 2.0), abs=0.4)


def test_repeated_picture_has_no_shift_and_is_reported() -> None:
    picture, estimator = scene(), CameraShift()
    estimator.step(view(picture, 0, 0))
    estimator.step(view(picture, 4, 0))
    assert estimator.step(view(picture, 4, 0)) == (0.0, 0.0)
    assert estimator.repeated
    assert estimator.step(view(picture, 8, 0)) == pytest.approx((4.0, 0.0), abs=0.3)
    assert not estimator.repeated


def test_blank_pictures_and_a_new_size_give_no_shift() -> None:
    estimator = CameraShift()
    flat = np.full((576, 720, 3), 90, np.uint8)
    estimator.step(flat)
    assert estimator.step(flat + 5) == UNKNOWN_SHIFT
    assert estimator.step(view(scene(), 0, 0)[:400]) == UNKNOWN_SHIFT
    tiny = np.zeros((7, 9, 3), np.uint8)
    assert estimator.step(tiny) == UNKNOWN_SHIFT
    assert estimator.step(tiny + 40) == UNKNOWN_SHIFT


def test_fit_separates_rotation_from_depth_dependent_expansion() -> None:
    """Points at many depths, a fifth of them outliers."""
    rng = np.random.default_rng(11)
    points = rng.uniform([-90, -70], [90, 70], (120, 2))
    growth = rng.choice([0.005, 0.02, 0.08], 120)[:, None]
    flow = np.array([2.5, -1.25]) + growth * points + rng.normal(0, 0.05, points.shape)
    flow[:24] = rng.uniform(-10, 10, (24, 2))
    shift, _ = fit_shift(points, flow)
    assert shift == pytest.approx([2.5, -1.25], abs=0.1)


def test_fit_of_one_plane_is_exact() -> None:
    points = np.random.default_rng(2).uniform(-80, 80, (40, 2))
    shift, growth = fit_shift(points, np.array([1.0, 2.0]) + 0.03 * points)
    assert shift == pytest.approx([1.0, 2.0], abs=1e-6)
    assert growth == pytest.approx(0.03, abs=1e-8)
