"""Packed channels against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.channels.interleaving import MAX_INTERLEAVED, deinterleave, interleave
from tsr_engine.channels.scratch import Scratch


@pytest.mark.parametrize("channels", [1, 2, 3, 4, 7, 10])
@pytest.mark.parametrize(("height", "width", "border"), [(13, 21, 0), (13, 21, 2), (1, 1, 3), (1, 70, 4), (40, 1, 1)])
def test_channels_are_packed_and_unpacked(channels: int, height: int, width: int, border: int) -> None:
    size = (channels, height + 2 * border, width + 2 * border)
    cells = np.random.default_rng(channels).integers(0, 256, size, np.uint8)
    packed = interleave(cells, border, Scratch())
    assert [part.shape[2] for part in packed] == [
        min(MAX_INTERLEAVED, channels - i) for i in range(0, channels, MAX_INTERLEAVED)
    ]
    inner = cells[:, border : height + border, border : width + border]
    np.testing.assert_array_equal(np.concatenate(packed, axis=2), inner.transpose(1, 2, 0))

    planes = np.zeros_like(cells)
    deinterleave(np.concatenate([part.reshape(-1) for part in packed]), planes, border)
    np.testing.assert_array_equal(planes, np.pad(inner, ((0, 0), (border, border), (border, border)), mode="edge"))
