"""Speed limits with smaller digits: the digits shrink, ring and surroundings are unchanged."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop
from tsr_engine.training.synthetic.inset_signs import INSET_CLASSES, inset_crop

SIDE, BORDER = 64, 8


def _limit() -> LoadedCrop:
    """A ring around a white field with a black square of the size of a German limit's digits, on stripes."""
    whole = SIDE + 2 * BORDER
    picture = np.full((whole, whole, 3), 120, np.uint8)
    picture[::4] = 60
    middle = (whole // 2 * 16 - 8,) * 2
    cv2.circle(picture, middle, SIDE // 2 * 16, (40, 30, 190), -1, cv2.LINE_AA, 4)
    cv2.circle(picture, middle, round(0.71 * SIDE / 2 * 16), (235, 235, 235), -1, cv2.LINE_AA, 4)
    reach = round(0.42 * SIDE / 2)
    picture[whole // 2 - reach : whole // 2 + reach, whole // 2 - reach : whole // 2 + reach] = 20
    return LoadedCrop(picture, np.array([BORDER, BORDER, BORDER + SIDE, BORDER + SIDE], float), 3)


def _count_dark(crop: LoadedCrop) -> int:
    inside = crop.pixels[BORDER + 8 : -BORDER - 8, BORDER + 8 : -BORDER - 8]
    return int((inside.max(axis=2) < 90).sum())


def test_digits_shrink_and_the_ring_is_unchanged() -> None:
    crop = _limit()
    whole = _count_dark(crop)
    shares = []
    for seed in range(30):
        inset = inset_crop(crop, np.random.default_rng(seed))
        assert inset.class_id == crop.class_id
        assert np.array_equal(inset.box, crop.box)
        shares.append(_count_dark(inset) / whole)
        blue, _, red = inset.pixels[BORDER + SIDE // 2, BORDER + 3].astype(int)
        assert red > blue + 80, seed
        for corner in ((0, 0), (0, -1), (-1, 0), (-1, -1)):
            assert np.array_equal(inset.pixels[corner], crop.pixels[corner])
    assert 0.3 < min(shares) < 0.55
    assert 0.7 < max(shares) < 1.0


def test_same_seed_same_crop() -> None:
    crop = _limit()
    first, again = (inset_crop(crop, np.random.default_rng(3)).pixels for _ in range(2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, inset_crop(crop, np.random.default_rng(4)).pixels)


def test_a_sign_without_a_limit_is_refused() -> None:
    crop = _limit()
    with pytest.raises(ValueError, match="class_id must be one of"):
        inset_crop(LoadedCrop(crop.pixels, crop.box, 6), np.random.default_rng(0))
    assert 6 not in INSET_CLASSES
