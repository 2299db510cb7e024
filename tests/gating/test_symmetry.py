"""Mirror symmetry on drawn shapes, noise and mirrored pictures."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.gating import SymmetryDetector
from tsr_engine.gating.symmetry import MIRROR
from tsr_engine.records import Picture

DETECTOR = SymmetryDetector()


def draw_shape(kind: str, side: int = 48) -> Picture:
    """A sign-like shape, drawn large and downscaled with anti-aliasing and camera noise.

    Without noise the two halves tie exactly, and SIFT drops extrema that tie with a neighbour.
    """
    s = 480
    im = np.full((s, s, 3), (110, 120, 100), np.uint8)
    white, red = (235, 235, 235), (30, 30, 190)
    if kind == "circle":
        cv2.circle(im, (240, 240), 220, red, -1)
        cv2.circle(im, (240, 240), 160, white, -1)
        cv2.rectangle(im, (120, 205), (360, 275), (20, 20, 20), -1)
    elif kind == "triangle":
        cv2.fillPoly(im, [np.array([[240, 30], [455, 420], [25, 420]])], red)
        cv2.fillPoly(im, [np.array([[240, 140], [365, 365], [115, 365]])], white)
        cv2.rectangle(im, (225, 210), (255, 330), (20, 20, 20), -1)
    elif kind == "octagon":
        corners = [
            (240 + 225 * np.cos(np.pi / 8 + k * np.pi / 4), 240 + 225 * np.sin(np.pi / 8 + k * np.pi / 4))
            for k in range(8)
        ]
        cv2.fillPoly(im, [np.array(corners, np.int32)], red)
        cv2.rectangle(im, (110, 200), (370, 280), white, -1)
    else:
        raise ValueError(kind)
    small = cv2.resize(im, (side, side), interpolation=cv2.INTER_AREA)
    grain = np.random.default_rng(side).normal(0.0, 3.0, small.shape)
    return np.clip(small + grain, 0, 255).astype(np.uint8)


def noise(seed: int, side: int = 96, smooth: float = 3.0) -> Picture:
    """Smooth random blobs: as many features as a sign, no symmetry."""
    rng = np.random.default_rng(seed)
    field = cv2.GaussianBlur(rng.normal(size=(side, side)).astype(np.float32), (0, 0), smooth)
    grey = cv2.normalize(field, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)
    return np.ascontiguousarray(np.repeat(grey[:, :, None], 3, axis=2))


def mirrored_noise(seed: int) -> Picture:
    picture = noise(seed)
    half = picture.shape[1] // 2
    picture[:, half:] = picture[:, :half][:, ::-1]
    return picture


@pytest.mark.parametrize("side", [24, 48, 90])
@pytest.mark.parametrize("kind", ["circle", "triangle", "octagon"])
def test_signs_are_more_symmetric_than_noise(kind: str, side: int) -> None:
    background = [DETECTOR.measure(cv2.resize(noise(seed), (side, side))).magnitude for seed in range(12)]
    assert DETECTOR.measure(draw_shape(kind, side)).magnitude > max(background) + 0.1


@pytest.mark.parametrize("seed", range(5))
def test_the_axis_of_a_mirrored_picture_is_found(seed: int) -> None:
    found = DETECTOR.measure(mirrored_noise(seed))
    assert found.magnitude > 0.5
    assert min(found.angle, np.pi - found.angle) < np.deg2rad(6)
    assert abs(found.offset) < 4.0
    # Both features of a pair lie equally far from the axis, at the same height.
    first, second = found.pairs[:, :2], found.pairs[:, 2:]
    assert len(found.pairs) >= 8
    assert np.median(np.abs((first[:, 0] + second[:, 0]) / 2 - 47.5)) < 2.0
    assert np.median(np.abs(first[:, 1] - second[:, 1])) < 2.0


def test_the_axis_turns_with_the_picture() -> None:
    picture = mirrored_noise(3)
    upright = DETECTOR.measure(picture)
    turned = DETECTOR.measure(np.ascontiguousarray(np.rot90(picture)))
    assert abs(turned.angle - np.pi / 2) < np.deg2rad(6)
    assert turned.magnitude == pytest.approx(upright.magnitude, abs=0.15)


def test_mirroring_and_contrast_change_little() -> None:
    for kind in ("circle", "triangle", "octagon"):
        crop = draw_shape(kind, 64)
        magnitude = DETECTOR.measure(crop).magnitude
        flipped = np.ascontiguousarray(crop[:, ::-1])
        darker = (crop * 0.5 + 20).astype(np.uint8)
        assert DETECTOR.measure(flipped).magnitude == pytest.approx(magnitude, abs=0.3)
        assert DETECTOR.measure(darker).magnitude == pytest.approx(magnitude, abs=0.3)


def test_the_permutation_gives_the_descriptors_of_the_mirrored_picture() -> None:
    grey = cv2.cvtColor(noise(1, side=200, smooth=4.0), cv2.COLOR_BGR2GRAY)
    sift = cv2.SIFT.create()
    keypoints, descriptors = sift.detectAndCompute(grey, None)
    mirror_image = [
        cv2.KeyPoint(grey.shape[1] - 1 - k.pt[0], k.pt[1], k.size, (180 - k.angle) % 360, k.response, k.octave)
        for k in keypoints
    ]
    _, expected = sift.compute(np.ascontiguousarray(grey[:, ::-1]), mirror_image)
    error = np.linalg.norm(descriptors[:, MIRROR] - expected, axis=1) / np.linalg.norm(expected, axis=1)
    unpermuted = np.linalg.norm(descriptors - expected, axis=1) / np.linalg.norm(expected, axis=1)
    assert len(keypoints) > 50
    assert np.median(error) < 0.08
    assert error.max() < 0.25
    assert np.median(unpermuted) > 0.5
    assert sorted(MIRROR) == list(range(128))
    assert (MIRROR[MIRROR] == np.arange(128)).all()


def test_poor_crops_have_no_symmetry() -> None:
    for crop in (
        np.zeros((0, 0, 3), np.uint8),
        np.zeros((5, 0, 3), np.uint8),
        np.full((1, 1, 3), 9, np.uint8),
        np.full((30, 30, 3), 200, np.uint8),
        np.full((30, 30), 200, np.uint8),
    ):
        found = DETECTOR.measure(crop)
        assert found.magnitude == 0.0
        assert found.pairs.shape == (0, 4)


def test_magnitudes_are_in_range_and_reproducible() -> None:
    rng = np.random.default_rng(5)
    for _ in range(40):
        h, w = rng.integers(4, 60, 2)
        crop = rng.integers(0, 256, (h, w, 3), dtype=np.uint8)
        magnitude = DETECTOR.measure(crop).magnitude
        assert 0.0 <= magnitude <= 1.0
        assert SymmetryDetector().measure(crop).magnitude == magnitude
