"""Memory that is reused between calls."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.channels import scratch as module
from tsr_engine.channels.scratch import Scratch


def test_the_same_request_returns_the_same_memory() -> None:
    scratch = Scratch()
    first = scratch.array("a", (2, 3), np.uint8)
    assert first.shape == (2, 3)
    assert first.flags.c_contiguous
    assert np.shares_memory(first, scratch.array("a", (2, 3), np.uint8))
    assert np.shares_memory(first, scratch.array("a", (3,), np.uint8))
    assert not np.shares_memory(first, scratch.array("b", (2, 3), np.uint8))


def test_a_smaller_shape_shares_the_memory_of_a_larger_one() -> None:
    scratch = Scratch()
    scratch.array("a", (2,), np.uint8)
    large = scratch.array("a", (50, 4), np.uint8)
    assert np.shares_memory(large, scratch.array("a", (2,), np.uint8))


def test_a_name_may_hold_other_types() -> None:
    scratch = Scratch()
    for kind in (np.uint8, np.float32, np.int16):
        assert scratch.array("a", (4, 5), kind).dtype == kind


def test_the_number_of_remembered_shapes_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_CACHED_VIEWS", 10)
    scratch = Scratch()
    largest = scratch.array("a", (100,), np.uint8)
    assert scratch.array("a", (100,), np.uint8) is largest
    for size in range(1, 60):
        assert np.shares_memory(largest, scratch.array("a", (size,), np.uint8))
    assert scratch.array("a", (100,), np.uint8) is not largest
