"""Enlarging by 3/2, and halving the result, against OpenCV, to the bit."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.channels.upsample import is_three_halves, upsample


@pytest.mark.parametrize("size", [(2, 2), (2, 64), (48, 2), (4, 6), (34, 30), (64, 128), (94, 182), (202, 350)])
@pytest.mark.parametrize("kind", ["noise", "black and white", "white"])
def test_planes_are_enlarged_and_halved_as_by_opencv(size: tuple[int, int], kind: str) -> None:
    height, width = size
    source = np.random.default_rng(height * width).integers(0, 256, (3, height, width), dtype=np.uint8)
    if kind == "black and white":
        source = np.where(source < 128, 0, 255).astype(np.uint8)
    elif kind == "white":
        source[:] = 255
    wide = (3 * width // 2, 3 * height // 2)
    assert is_three_halves(source, wide)
    target = np.full((3, wide[1], wide[0]), 7, np.uint8)
    half = (wide[0] // 2, wide[1] // 2)
    halved = np.full((3, half[1], half[0]), 7, np.uint8)
    upsample(source, target, halved)
    expected = [cv2.resize(plane, wide, interpolation=cv2.INTER_LINEAR) for plane in source]
    np.testing.assert_array_equal(target, expected)
    even = [plane[: 2 * half[1], : 2 * half[0]] for plane in expected]
    np.testing.assert_array_equal(halved, [cv2.resize(plane, half, interpolation=cv2.INTER_AREA) for plane in even])


@pytest.mark.parametrize(
    ("height", "width", "size"),
    [(5, 4, (6, 7)), (4, 5, (7, 6)), (4, 4, (6, 5)), (4, 4, (8, 8)), (4, 4, (4, 4)), (0, 4, (6, 0))],
)
def test_other_ratios_and_odd_sides_are_refused(height: int, width: int, size: tuple[int, int]) -> None:
    assert not is_three_halves(np.zeros((3, height, width), np.uint8), size)
