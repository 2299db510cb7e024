import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.channels import reference
from tsr_engine.channels.column_pairs import MARGIN_CELLS, STRIP_CELLS
from tsr_engine.channels.compute import CHANNELS, compute_channels
from tsr_engine.channels.quantise import channel_bytes, quantise


def picture(seed: int, height: int, width: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    coarse = rng.integers(0, 256, (height // 5 + 2, width // 5 + 2, 3), dtype=np.uint8)
    smooth = np.kron(coarse, np.ones((5, 5, 1), np.uint8))[:height, :width]
    noise = rng.integers(-20, 21, smooth.shape)
    return np.clip(smooth.astype(int) + noise, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("shrink", [1, 2, 3, 4])
def test_channels_equal_the_slow_version(shrink: int) -> None:
    bgr = picture(shrink, 61, 83)
    fast = compute_channels(bgr, shrink)
    slow = reference.channels(bgr, shrink)
    assert fast.shape == slow.shape == (CHANNELS, 61 // shrink, 83 // shrink)
    np.testing.assert_allclose(fast, slow, atol=1e-3, rtol=0)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**20), st.integers(2, 40), st.integers(2, 40), st.sampled_from([1, 2]))
def test_any_size_and_content_is_accepted(seed: int, height: int, width: int, shrink: int) -> None:
    bgr = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    np.testing.assert_allclose(compute_channels(bgr, shrink), reference.channels(bgr, shrink), atol=1e-3, rtol=0)


@pytest.mark.parametrize("degrees", [0, 30, 60, 90, 120, 150])
def test_an_edge_falls_into_the_bin_of_its_direction(degrees: int) -> None:
    y, x = np.mgrid[0:64, 0:64] - 31.5
    angle = np.deg2rad(degrees)
    ramp = 128 + 100 * np.tanh((np.cos(angle) * x + np.sin(angle) * y) / 3)
    grey = np.repeat(ramp[..., None], 3, 2).astype(np.uint8)
    middle = compute_channels(grey, 2)[4:, 12:20, 12:20].mean((1, 2))
    assert int(np.argmax(middle)) == degrees // 30
    assert middle[degrees // 30] > 3 * np.delete(middle, degrees // 30).max()


def test_a_flat_picture_has_no_gradient() -> None:
    cells = compute_channels(np.full((20, 20, 3), 90, np.uint8), 2)
    assert np.abs(cells[3:]).max() < 1e-4
    assert np.ptp(cells[:3], axis=(1, 2)).max() < 1e-6


@pytest.mark.parametrize(
    "bad", [np.zeros((5, 5), np.uint8), np.zeros((5, 5, 3), np.float32), np.zeros((1, 9, 3), np.uint8)]
)
def test_other_arrays_are_refused(bad: np.ndarray) -> None:
    with pytest.raises(ValueError, match="Got"):
        compute_channels(bad, 2)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**20), st.integers(4, 60), st.integers(4, 60), st.sampled_from([1, 2, 4]))
def test_the_stream_of_bytes_equals_the_two_steps(seed: int, height: int, width: int, shrink: int) -> None:
    bgr = picture(seed, height, width)
    streamed = channel_bytes(bgr, shrink)
    stepwise = quantise(compute_channels(bgr, shrink))
    assert streamed.shape == stepwise.shape
    assert np.abs(streamed.astype(int) - stepwise).max() <= 1


@pytest.mark.parametrize(
    "columns", [STRIP_CELLS - 1, STRIP_CELLS, STRIP_CELLS + 1, 2 * STRIP_CELLS, 2 * STRIP_CELLS + MARGIN_CELLS]
)
@pytest.mark.parametrize("odd", [0, 1])
def test_strips_of_columns_join_without_a_seam(columns: int, odd: int) -> None:
    bgr = picture(columns, 21, 2 * columns + odd)
    difference = np.abs(channel_bytes(bgr).astype(int) - quantise(compute_channels(bgr)))
    assert difference.shape == (CHANNELS, 10, columns)
    assert difference.max() <= 1
    assert np.count_nonzero(difference) < 0.001 * difference.size
