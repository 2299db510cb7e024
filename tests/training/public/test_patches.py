"""Training windows of signs: the sign's position in a patch, and the effect of a distortion."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.detection.patch import cut_patch
from tsr_engine.detection.window import Window
from tsr_engine.training.public.patches import PATCH, random_distortion, sign_windows

BOX = np.array([100.0, 60.0, 148.0, 108.0])


def scene() -> np.ndarray:
    """A bright square on grey, exactly as large as ``BOX``."""
    picture = np.full((180, 240, 3), 60, np.uint8)
    picture[60:108, 100:148] = 220
    return picture


def square_extent(patch: np.ndarray) -> tuple[float, float, float, float]:
    """Centre and size of the bright square, px, from sums of the pixels brighter than the background."""
    light = (patch[..., 0].astype(float) - 60) / 160
    columns, rows = light.sum(0), light.sum(1)
    at = np.arange(len(patch)) + 0.5
    return columns @ at / columns.sum(), rows @ at / rows.sum(), light[len(patch) // 2].sum(), light.sum(0).max()


@pytest.mark.parametrize("sign", [24.0, 60.0])
def test_the_sign_is_centred_with_its_size(sign: float) -> None:
    x, y, width, height = square_extent(cut_patch(scene(), BOX, sign, PATCH))
    assert (x, y) == pytest.approx((PATCH / 2, PATCH / 2), abs=0.05)
    assert (width, height) == pytest.approx((sign, sign), abs=0.3)


@pytest.mark.parametrize("sign", [24.0, 60.0])
def test_a_stretch_widens_and_flattens_about_the_middle(sign: float) -> None:
    x, y, width, height = square_extent(cut_patch(scene(), BOX, sign, PATCH, np.diag(np.exp([0.2, -0.2]))))
    assert (x, y) == pytest.approx((PATCH / 2, PATCH / 2), abs=0.1)
    assert (width, height) == pytest.approx((sign * np.exp(0.2), sign * np.exp(-0.2)), abs=0.5)


@pytest.mark.parametrize("stretch", [np.eye(2), np.diag([1.1, 1 / 1.1])])
@pytest.mark.parametrize(
    "at", [[0.0, 0.0], [-90.0, -50.0], [110.0, 80.0]], ids=["inside", "first corner", "last corner"]
)
@pytest.mark.parametrize("sign", [20.5, 29.0, 46.0, 60.0, 130.0])
def test_the_kernels_give_the_pixels_of_opencv(sign: float, at: list[float], stretch: np.ndarray) -> None:
    """A turn by a billionth takes the way through OpenCV's functions and moves no pixel."""
    noise = cv2.GaussianBlur(np.random.default_rng(0).integers(0, 256, (180, 240, 3), np.uint8), (3, 3), 0)
    box, turned = BOX + 0.3 + np.tile(at, 2), stretch + np.array([[0.0, 1e-9], [-1e-9, 0.0]])
    ours = cut_patch(noise, box, sign, PATCH, stretch).astype(int)
    difference = np.abs(ours - cut_patch(noise, box, sign, PATCH, turned))
    assert difference.max() <= 1
    assert (difference > 0).mean() < 0.002


def test_no_distortion_is_the_identity() -> None:
    noise = cv2.randu(np.empty((180, 240, 3), np.uint8), 0, 255)
    for sign in (24.0, 60.0):
        plain = cut_patch(noise, BOX + 0.3, sign, PATCH)
        np.testing.assert_array_equal(plain, cut_patch(noise, BOX + 0.3, sign, PATCH, np.eye(2)))


def test_distortions_keep_the_area_and_stay_within_two_standard_deviations() -> None:
    rng = np.random.default_rng(3)
    drawn = [random_distortion(rng, 0.06, 4.0) for _ in range(400)]
    sizes = np.array([np.linalg.norm(d, axis=0) for d in drawn])
    np.testing.assert_allclose([np.linalg.det(d) for d in drawn], 1.0, atol=1e-12)
    stretch = np.log(sizes[:, 0])
    turn = np.rad2deg([np.arctan2(d[1, 0], d[0, 0]) for d in drawn])
    assert abs(stretch).max() == pytest.approx(0.12)
    assert abs(turn).max() == pytest.approx(8.0)
    assert stretch.std() == pytest.approx(0.06, rel=0.15)
    assert turn.std() == pytest.approx(4.0, rel=0.15)


def test_the_first_window_is_undistorted() -> None:
    window = Window()
    still = {"shift": 0.0, "log_scale": 0.0, "relit": 0.0, "softened": 0.0}
    # a uniform background and a square are symmetric
    plain = sign_windows(scene(), BOX, window, 3, np.random.default_rng(0), **still)
    other = sign_windows(scene(), BOX, window, 3, np.random.default_rng(0), aspect=0.1, turn=8.0, **still)
    np.testing.assert_array_equal(plain[0], plain[1])
    np.testing.assert_array_equal(plain[0], other[0])
    assert (plain[0] != other[1]).any()
    assert (other[1] != other[2]).any()
