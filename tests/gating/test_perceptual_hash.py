"""The perceptual hash of known pictures, and the memory of earlier crops."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.fft import dctn

from tsr_engine.gating import HashMemory, hamming, perceptual_hash
from tsr_engine.gating.perceptual_hash import hash_bits, hash_picture


def picture(seed: int, side: int = 32) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (side, side, 3), dtype=np.uint8)


def bits_of(crop: np.ndarray) -> np.ndarray:
    return hash_bits(hash_picture(crop))


@given(st.integers(0, 2**32 - 1))
def test_against_an_independent_dct(seed: int) -> None:
    grey = hash_picture(picture(seed))
    low = dctn(grey.astype(np.float64), norm="ortho")[:8, :8].ravel()
    # Values within rounding of the median may fall on either side.
    clear = np.abs(low - np.median(low)) > 1e-2
    assert (hash_bits(grey)[clear] == (low > np.median(low))[clear]).all()


def test_a_pure_frequency_sets_its_own_bit() -> None:
    x = (np.arange(32) + 0.5) * np.pi / 32
    for u, v in [(0, 3), (5, 0), (7, 7), (2, 6)]:
        wave = np.cos(u * x)[:, None] * np.cos(v * x)[None, :]
        grey = (128 + 100 * wave).astype(np.float32)
        assert hash_bits(grey).reshape(8, 8)[u, v]
        negative = hash_bits((128 - 100 * wave).astype(np.float32)).reshape(8, 8)
        assert not negative[u, v]


def test_half_of_the_bits_are_set() -> None:
    value = perceptual_hash(hash_picture(picture(1)))
    assert value.bit_count() == 32
    assert [value >> (63 - i) & 1 for i in range(64)] == bits_of(picture(1)).tolist()


def test_brightness_and_contrast_change_few_bits() -> None:
    base = picture(2).astype(np.float64) * 0.4 + 50
    first = bits_of(base.astype(np.uint8))
    for gain, offset in [(1.0, 40.0), (1.0, -40.0), (1.5, 0.0), (0.7, 10.0)]:
        changed = np.clip(base * gain + offset, 0, 255).astype(np.uint8)
        assert hamming(first, bits_of(changed)) <= 4


def test_unrelated_pictures_differ_in_about_half_of_the_bits() -> None:
    distances = [hamming(bits_of(picture(a)), bits_of(picture(a + 1))) for a in range(50)]
    assert 26 < np.mean(distances) < 38


def test_the_memory_is_the_mean_and_is_immutable() -> None:
    crops = [picture(k) for k in range(4)]
    memory = HashMemory.empty()
    for crop in crops:
        before = memory.mean.copy()
        grown = memory.add(crop)
        assert (memory.mean == before).all()
        memory = grown
    expected = np.mean([hash_picture(c) for c in crops], axis=0)
    np.testing.assert_allclose(memory.mean, expected, atol=1e-3)
    assert memory.count == 4


def test_a_limited_memory_forgets() -> None:
    old, new = np.zeros((32, 32, 3), np.uint8), np.full((32, 32, 3), 200, np.uint8)
    memory = HashMemory.empty()
    for _ in range(50):
        memory = memory.add(old, limit=4)
    memory = memory.add(new, limit=4)
    np.testing.assert_allclose(memory.mean, 50.0)
    plain = HashMemory.empty().add(old).add(new).add(new).add(new)
    np.testing.assert_allclose(plain.mean, 150.0)


def test_distance_to_itself_and_to_nothing() -> None:
    crop = picture(9, 50)
    assert HashMemory.empty().add(crop).distance(crop) == 0
    with pytest.raises(ValueError, match="empty memory"):
        HashMemory.empty().distance(crop)


def test_any_size_is_accepted() -> None:
    for shape in [(1, 1, 3), (3, 200, 3), (0, 5, 3), (16, 16)]:
        assert hash_picture(np.full(shape, 7, np.uint8)).shape == (32, 32)
