"""Two views of a crop against their definition."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.recognition.test_classifier import component, crops
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.descriptor import resize_crops
from tsr_engine.recognition.shifted_views import diagonal_pairs


def shift_patch(patch: np.ndarray, pixels: float) -> np.ndarray:
    """A patch moved down and right by bilinear interpolation, with the border replicated."""
    side = len(patch)
    at = np.arange(side) - pixels
    low = np.floor(at).astype(int)
    share = (at - low)[:, None]
    ends = [np.clip(low, 0, side - 1), np.clip(low + 1, 0, side - 1)]
    wide = patch.astype(np.float64)
    rows = wide[ends[0]] * (1 - share[..., None]) + wide[ends[1]] * share[..., None]
    both: np.ndarray = rows[:, ends[0]] * (1 - share) + rows[:, ends[1]] * share
    return both


def test_views_are_shifted_by_one_and_a_half_pixels() -> None:
    patches = np.random.default_rng(3).integers(0, 256, (2, 48, 48, 3), dtype=np.uint8)
    pairs = diagonal_pairs(patches)
    assert pairs.shape == (4, 48, 48, 3)
    for i, patch in enumerate(patches):
        for view, pixels in ((0, -1.5), (1, 1.5)):
            np.testing.assert_array_less(np.abs(pairs[2 * i + view] - shift_patch(patch, pixels)), 0.51)


def test_a_uniform_patch_is_unchanged() -> None:
    flat = np.full((1, 48, 48, 3), 201, dtype=np.uint8)
    np.testing.assert_array_equal(diagonal_pairs(flat), np.repeat(flat, 2, axis=0))
    assert diagonal_pairs(flat[:0]).shape == (0, 48, 48, 3)


def test_a_paired_classifier_answers_with_the_mean_of_both() -> None:
    single = SignClassifier.from_component(component())
    paired = replace(single, paired=True)
    views = single.margins(list(diagonal_pairs(resize_crops(crops()))))
    np.testing.assert_allclose(paired.margins(crops()), (views[0::2] + views[1::2]) / 2, atol=1e-4)
    alone = [paired.probabilities([crop])[0] for crop in crops()]
    np.testing.assert_array_equal(alone, paired.probabilities(crops()))
    assert paired.probabilities([]).shape == (0, 43)


@pytest.mark.parametrize("paired", [False, True])
def test_a_component_stores_its_kind_of_views(paired: bool) -> None:
    made = component()
    if paired:
        made = replace(made, params={**made.params, "paired": True})
    assert SignClassifier.from_component(made).paired is paired
