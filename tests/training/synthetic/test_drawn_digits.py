"""Digits drawn by strokes have their typical holes in every typeface."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.training.synthetic.drawn_digits import STROKED, stroked_digits

HOLES = {"0": 1, "1": 0, "2": 0, "3": 0, "5": 0, "6": 1, "7": 0, "8": 2}


def _count_parts(mask: np.ndarray) -> int:
    """Connected parts of a mask."""
    return int(cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)[0]) - 1


@pytest.mark.parametrize("digit", sorted(HOLES))
def test_a_digit_is_one_stroke_with_its_holes_in_every_face(digit: str) -> None:
    for seed in range(80):
        mask = stroked_digits(digit, np.random.default_rng(seed))
        assert _count_parts(mask < 128) - 1 == HOLES[digit], seed
        assert int(cv2.connectedComponents((mask >= 128).astype(np.uint8))[0]) - 1 == 1, seed
        assert not np.concatenate([mask[0], mask[-1], mask[:, 0], mask[:, -1]]).any(), seed


def test_faces_differ_in_weight_width_and_corners() -> None:
    inks, widths = [], []
    for seed in range(40):
        mask = stroked_digits("0", np.random.default_rng(seed))
        rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        inks.append((mask > 128).sum() / (len(rows) * len(columns)))
        widths.append(len(columns) / len(rows))
    assert max(inks) > 1.5 * min(inks)
    assert max(widths) > 1.3 * min(widths)


def test_a_number_is_its_digits_side_by_side() -> None:
    mask = stroked_digits("120", np.random.default_rng(5))
    assert int(cv2.connectedComponents((mask >= 128).astype(np.uint8))[0]) - 1 == 3
    assert np.array_equal(mask, stroked_digits("120", np.random.default_rng(5)))


@pytest.mark.parametrize("text", ["", "4", "6O"])
def test_other_characters_than_digits_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match=f"text must be made of {STROKED}"):
        stroked_digits(text, np.random.default_rng(0))
