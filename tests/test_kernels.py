"""Kernels take views of arrays without counting references."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError
from numpy.typing import NDArray

from tsr_engine.kernels import kernel


def add_rows(rows: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    for y in range(1, rows.shape[0]):
        for row in (rows[y], rows[y - 1]):
            for x in range(row.shape[0]):
                out[x] += row[x]


def test_views_are_not_counted() -> None:
    rows, sums = np.arange(6.0).reshape(3, 2), np.zeros((2, 2))
    plain, uncounted = njit(add_rows), kernel(cache=False)(add_rows)
    plain(rows, sums[0])
    uncounted(rows, sums[1])
    assert sums.tolist() == [[8.0, 12.0]] * 2
    calls = [next(iter(compiled.inspect_asm().values())).count("NRT_incref") for compiled in (plain, uncounted)]
    assert calls[0] > calls[1] == 0


def test_a_kernel_that_makes_an_array_is_refused() -> None:
    @kernel(cache=False)
    def make(count: int) -> NDArray[np.float64]:
        return np.zeros(count)

    with pytest.raises(TypingError, match="built-in function empty"):
        make(3)
