from typing import Any

import cv2
import numpy as np
import pytest

from tsr_engine.recognition.descriptor import CHANNELS, GRID, LENGTH, SIDE, describe, describe_patches, resize_crop


def slow_cells(patch: np.ndarray) -> np.ndarray:
    """The formula in the descriptor module's docstring, in plain NumPy loops."""
    root = np.pad(np.sqrt(patch / 255.0), ((1, 1), (1, 1), (0, 0)), mode="edge")
    dx, dy = root[1:-1, 2:] - root[1:-1, :-2], root[2:, 1:-1] - root[:-2, 1:-1]
    strongest = np.argmax(dx**2 + dy**2, axis=2)
    gx, gy = (np.take_along_axis(d, strongest[..., None], 2)[..., 0] for d in (dx, dy))
    turn = np.mod(np.arctan2(gy, gx), 2 * np.pi) / (2 * np.pi) * 18
    bins = np.zeros((GRID, GRID, 18))
    for y in range(SIDE):
        for x in range(SIDE):
            cy, cx = (y + 0.5) / 4 - 0.5, (x + 0.5) / 4 - 0.5
            for j in (int(np.floor(cy)), int(np.floor(cy)) + 1):
                for i in (int(np.floor(cx)), int(np.floor(cx)) + 1):
                    if 0 <= j < GRID and 0 <= i < GRID:
                        weight = np.hypot(gx[y, x], gy[y, x]) * (1 - abs(cy - j)) * (1 - abs(cx - i))
                        o = int(turn[y, x])
                        bins[j, i, o % 18] += weight * (1 - (turn[y, x] - o))
                        bins[j, i, (o + 1) % 18] += weight * (turn[y, x] - o)
    unsigned = bins[..., :9] + bins[..., 9:]
    both = np.concatenate([bins, unsigned], axis=2)
    energy = np.pad((unsigned**2).sum(2), 1, mode="edge")
    cells = np.zeros((GRID, GRID, CHANNELS))
    for j in (0, 1):
        for i in (0, 1):
            block = sum(energy[j + a : j + a + GRID, i + b : i + b + GRID] for a in (0, 1) for b in (0, 1))
            cells[..., :27] += 2 * np.minimum(both / np.sqrt(block + 1e-3)[..., None], 0.2)
    mean = patch.reshape(GRID, 4, GRID, 4, 3).mean((1, 3)) / 255
    b, g, r = np.moveaxis(mean, 2, 0)
    bright = mean.mean(2)
    weight = 2 / (3 * bright + 1.5 * bright.mean() + 0.05)
    cells[..., 27] = (r - g) * weight
    cells[..., 28] = (b - 0.5 * (r + g)) * weight
    cells[..., 29] = 0.5 * np.clip((bright - bright.mean()) / (bright.std() + 0.02), -2, 2)
    return cells


def drawn_sign(side: int = SIDE) -> np.ndarray:
    picture = np.full((side, side, 3), (90, 110, 100), dtype=np.uint8)
    centre, radius = (side // 2, side // 2), int(side * 0.4)
    cv2.circle(picture, centre, radius, (30, 30, 200), -1, cv2.LINE_AA)
    cv2.circle(picture, centre, int(radius * 0.75), (230, 230, 230), -1, cv2.LINE_AA)
    cv2.putText(picture, "5", (int(side * 0.38), int(side * 0.63)), 0, side / 70, (20, 20, 20), max(1, side // 24))
    return picture


@pytest.mark.parametrize("kind", ["noise", "sign", "dark", "flat"])
def test_descriptor_equals_a_slow_version(kind: str) -> None:
    noise = np.random.default_rng(3).integers(0, 256, (SIDE, SIDE, 3)).astype(np.uint8)
    patches = {"noise": noise, "sign": drawn_sign(), "dark": drawn_sign() // 16, "flat": np.full_like(noise, 77)}
    got = describe_patches(patches[kind][None]).reshape(GRID, GRID, CHANNELS)
    np.testing.assert_allclose(got, slow_cells(patches[kind]), atol=2e-3)
    assert abs(got - slow_cells(patches[kind])).mean() < 2e-4


def test_crops_of_different_sizes_in_one_batch() -> None:
    crops = [drawn_sign(side) for side in (18, 48, 131)] + [drawn_sign(60)[:, 5:50]]
    batch = describe(crops)
    assert batch.shape == (4, LENGTH)
    assert batch.dtype == np.float32
    for row, crop in zip(batch, crops, strict=True):
        np.testing.assert_array_equal(row, describe([crop])[0])


def test_an_empty_batch() -> None:
    assert describe([]).shape == (0, LENGTH)


def similarity(a: np.ndarray, b: np.ndarray, channels: slice) -> float:
    x, y = (describe([p])[0].reshape(GRID, GRID, CHANNELS)[..., channels].ravel() for p in (a, b))
    return float(x @ y / np.linalg.norm(x) / np.linalg.norm(y))


@pytest.mark.parametrize(("gain", "lift"), [(0.3, 0), (0.5, 110), (0.1, 0)])
def test_light_changes_the_gradients_less_than_another_sign_does(gain: float, lift: float) -> None:
    sign = cv2.GaussianBlur(drawn_sign(), (0, 0), 1.0)
    other = np.ascontiguousarray(sign[::-1])
    lit = np.round(sign * gain + lift).astype(np.uint8)
    gradients = slice(0, 27)
    assert similarity(sign, lit, gradients) > similarity(sign, other, gradients)


def test_shade_leaves_colours_as_they_are() -> None:
    assert similarity(drawn_sign(), (drawn_sign() * 0.3).astype(np.uint8), slice(27, 30)) > 0.98


@pytest.mark.parametrize(
    "crop", [np.zeros((10, 10), np.uint8), np.zeros((0, 4, 3), np.uint8), np.zeros((9, 9, 3), np.float32)]
)
def test_arrays_other_than_bgr_pictures_are_refused(crop: Any) -> None:
    with pytest.raises(ValueError, match="uint8 of shape"):
        resize_crop(crop)


def test_patches_of_another_size_are_refused() -> None:
    with pytest.raises(ValueError, match="Patches must have shape"):
        describe_patches(np.zeros((2, 40, 40, 3), np.uint8))
