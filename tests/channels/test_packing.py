"""Channels side by side and back against what NumPy makes of them."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.channels.packing import TOGETHER, pack, unpack
from tsr_engine.channels.scratch import Scratch


@pytest.mark.parametrize("channels", [1, 2, 3, 4, 7, 10])
@pytest.mark.parametrize("border", [0, 2])
def test_channels_stand_side_by_side_and_find_their_planes_again(channels: int, border: int) -> None:
    cells = np.random.default_rng(channels).integers(0, 256, (channels, 13 + 2 * border, 21 + 2 * border), np.uint8)
    packed = pack(cells, border, Scratch())
    assert [part.shape[2] for part in packed] == [min(TOGETHER, channels - i) for i in range(0, channels, TOGETHER)]
    inner = cells[:, border : 13 + border, border : 21 + border]
    np.testing.assert_array_equal(np.concatenate(packed, axis=2), inner.transpose(1, 2, 0))

    planes = np.zeros_like(cells)
    for number, part in enumerate(packed):
        unpack(np.ascontiguousarray(part), planes[TOGETHER * number : TOGETHER * (number + 1)], border)
    expected = np.zeros_like(cells)
    expected[:, border : 13 + border, border : 21 + border] = inner
    np.testing.assert_array_equal(planes, expected)
