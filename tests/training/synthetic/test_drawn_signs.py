"""Drawn signs are complete, varied, reproducible, and their arrows have the right direction."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.recognition.gtsrb_classes import SIGN_CLASSES
from tsr_engine.training.synthetic.classifier_augmentation import MAX_CROP_PX, LoadedCrop, plain_view
from tsr_engine.training.synthetic.drawn_signs import DRAWN_CLASSES, EMPTY, drawn_crop

POINTS = {33: (1, 0), 34: (-1, 0), 35: (0, -1), 38: (1, 1), 39: (-1, 1)}


def _paint(crop: LoadedCrop, code: int) -> np.ndarray:
    x1, y1, x2, y2 = crop.box.astype(int)
    return cv2.cvtColor(crop.pixels[y1:y2, x1:x2], code)


@pytest.mark.parametrize("class_id", [*DRAWN_CLASSES, EMPTY])
def test_same_seed_same_crop_other_seed_other_crop(class_id: int) -> None:
    first, again = (drawn_crop(class_id, np.random.default_rng(3)) for _ in range(2))
    assert np.array_equal(first.pixels, again.pixels)
    assert not np.array_equal(first.pixels, drawn_crop(class_id, np.random.default_rng(4)).pixels)
    assert first.class_id == class_id
    assert (first.box[2:] - first.box[:2]).tolist() == [MAX_CROP_PX, MAX_CROP_PX]
    assert plain_view(first).std() > 4


@pytest.mark.parametrize("class_id", sorted(POINTS))
def test_an_arrow_points_where_its_class_says(class_id: int) -> None:
    for seed in range(20):
        crop = drawn_crop(class_id, np.random.default_rng(seed))
        x1, y1, x2, y2 = crop.box.astype(int)
        red = crop.pixels[y1:y2, x1:x2, 2]
        dx, dy = np.meshgrid(*[np.arange(MAX_CROP_PX) - MAX_CROP_PX / 2 + 0.5] * 2)
        inner = np.hypot(dx, dy) < 0.4 * MAX_CROP_PX
        level, _ = cv2.threshold(np.ascontiguousarray(red[inner]), 0, 255, cv2.THRESH_OTSU)
        white = (red > level) & inner
        along = np.array(POINTS[class_id]) / np.hypot(*POINTS[class_id])
        forward, aside = dx * along[0] + dy * along[1], np.abs(dx * along[1] - dy * along[0])
        # the head is wider than the tail
        head, tail = white & (forward > 3), white & (forward < -8)
        assert np.quantile(aside[head], 0.99) > np.quantile(aside[tail], 0.99) + 1, f"seed {seed}"


def test_limits_have_a_red_ring_around_a_brighter_field() -> None:
    for class_id in (3, 7, EMPTY):
        for seed in range(10):
            lab = _paint(drawn_crop(class_id, np.random.default_rng(seed)), cv2.COLOR_BGR2LAB).astype(int)
            middle = MAX_CROP_PX // 2
            ring = lab[middle, 3:7, 1].max()
            assert ring > lab[middle - 2 : middle + 2, middle - 20 : middle + 20, 1].mean() + 8
            assert SIGN_CLASSES[class_id].name


def test_a_class_without_a_drawing_is_refused() -> None:
    with pytest.raises(ValueError, match="class_id must be one of"):
        drawn_crop(40, np.random.default_rng(0))
