"""The explicit feature map between descriptor and support vector machine.

Filters read windows of 4x4 cells of the descriptor, every 2 cells (25 positions). A hidden layer combines their
outputs; ``max(0, .)`` follows both. The map replaces a kernel. It is learned together with the machine, so a few
hundred features replace thousands of fixed ones (Tang 2013: deep learning with linear support vector machines).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numba as nb
import numpy as np
from numpy.typing import NDArray

from tsr_engine.linear_algebra import product
from tsr_engine.recognition.descriptor import CHANNELS, GRID, describe_patches
from tsr_engine.row_copy import copy_row

WINDOW = 4
"""Side of a filter's window, cells."""
STRIDE = 2
"""Distance between windows, cells."""
POSITIONS = ((GRID - WINDOW) // STRIDE + 1) ** 2
WINDOW_LENGTH = WINDOW * WINDOW * CHANNELS

_ARRAYS = ("filters", "filter_bias", "hidden", "hidden_bias")

Array = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class FeatureMap:
    """Learned filters and hidden layer, plain float32 arrays.

    Raises:
        ValueError: a shape does not fit.
    """

    filters: Array
    """Shape (480, f)."""
    filter_bias: Array
    """Shape (f,)."""
    hidden: Array
    """Shape (25 f, h)."""
    hidden_bias: Array
    """Shape (h,)."""

    def __post_init__(self) -> None:
        f, h = self.filters.shape[1], self.hidden.shape[1]
        wanted = {"filters": (WINDOW_LENGTH, f), "filter_bias": (f,), "hidden": (POSITIONS * f, h), "hidden_bias": (h,)}
        for name, shape in wanted.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"FeatureMap.{name} must have shape {shape}. Got {getattr(self, name).shape} instead.")

    @property
    def length(self) -> int:
        """Number of features."""
        return int(self.hidden.shape[1])

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]], prefix: str = "") -> FeatureMap:
        """Make a map from arrays of any float type, named by the prefix and the attributes' names.

        Raises:
            KeyError: an array is missing.
            ValueError: shapes do not fit together.
        """
        return cls(*(np.ascontiguousarray(arrays[prefix + name], dtype=np.float32) for name in _ARRAYS))

    def to_arrays(self, prefix: str = "") -> dict[str, NDArray[np.generic]]:
        """Arrays from which :meth:`from_arrays` makes a map; matrices as float16, the type of trained ones."""
        arrays = {prefix + name: getattr(self, name) for name in _ARRAYS}
        return {name: array.astype(np.float16) if array.ndim == 2 else array for name, array in arrays.items()}

    def of_patches(self, patches: NDArray[np.uint8], together: int = 1) -> Array:
        """Features of crops, shape (n, 48, 48, 3), BGR -> (n, h); see :meth:`__call__`."""
        return self(describe_patches(patches), together)

    def __call__(self, descriptors: Array, together: int = 1) -> Array:
        """Features, shape (n, 4320) -> (n, h), all >= 0.

        Args:
            descriptors: descriptors of crops, shape (n, 4320).
            together: number of rows to map at once, a divisor of n. The hidden layer is read once for all of them. Use
                the same number for a crop each time; its features then do not depend on the batch.
        """
        out = np.empty((len(descriptors), self.length), dtype=np.float32)
        given = np.asarray(descriptors, dtype=np.float32)
        _features(given, together, self.filters, self.filter_bias, self.hidden, self.hidden_bias, out)
        return out


def linear(features: Array, weights: Array, bias: Array) -> Array:
    """``features @ weights + bias``, shapes (n, h), (h, k), (k,) -> (n, k); a row does not depend on the others."""
    return np.asarray(product(features, weights) + bias)


def windows(descriptors: Array) -> Array:
    """All windows of descriptors as rows, shape (n, 4320) -> (n * 25, 480): row by row, cell by cell."""
    out = np.empty((len(descriptors) * POSITIONS, WINDOW_LENGTH), dtype=np.float32)
    _gather(np.asarray(descriptors, dtype=np.float32), out)
    return out


@nb.njit(cache=True, nogil=True)
def _gather(descriptors, out):  # type: ignore[no-untyped-def]
    """Copies the windows; each is four runs of four neighbouring cells."""
    run, row = WINDOW * CHANNELS, 0
    for i in range(len(descriptors)):
        for top in range(0, GRID - WINDOW + 1, STRIDE):
            for left in range(0, GRID - WINDOW + 1, STRIDE):
                for y in range(WINDOW):
                    first = ((top + y) * GRID + left) * CHANNELS
                    copy_row(descriptors[i, first : first + run], out[row, y * run : (y + 1) * run])
                row += 1


@nb.njit(cache=True, nogil=True)
def _features(descriptors, together, filters, filter_bias, hidden, hidden_bias, out):  # type: ignore[no-untyped-def]
    """Maps ``together`` descriptors at a time, so that the filters' outputs stay in the first-level cache."""
    seen = np.empty((together * POSITIONS, WINDOW_LENGTH), np.float32)
    for first in range(0, len(descriptors), together):
        _gather(descriptors[first : first + together], seen)
        found = product(seen, filters)
        for row in range(len(found)):
            for j in range(len(filter_bias)):
                found[row, j] += filter_bias[j]
        _combine(found.reshape(together, -1), hidden, hidden_bias, out[first : first + together])


@nb.njit(cache=True, nogil=True)
def _combine(found, hidden, bias, out):  # type: ignore[no-untyped-def]
    """``max(0, max(0, found) @ hidden + bias)``, shape (n, 25 f) -> (n, h).

    Most outputs of the filters are not above 0, and their rows of the hidden layer are skipped. This saves time, since
    the layer is large and reading it takes longer than the arithmetic. The sums have a fixed order, so that the bits do
    not depend on a library.
    """
    for row in range(len(found)):
        for j in range(len(bias)):
            out[row, j] = bias[j]
    for i in range(found.shape[1]):
        for row in range(len(found)):
            value = found[row, i]
            if value > 0:
                for j in range(len(bias)):
                    out[row, j] += value * hidden[i, j]
    for row in range(len(found)):
        for j in range(len(bias)):
            out[row, j] = max(out[row, j], np.float32(0))
