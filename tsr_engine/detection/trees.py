"""A boosted ensemble of decision trees over byte features, with a soft cascade's rejection thresholds.

Trees are complete: ``2**depth - 1`` inner nodes in heap order, ``2**depth`` leaves. A node sends a window to its right
child if ``feature >= threshold``. Scores are whole numbers in units of ``1 / UNIT``, so that a vectorised scan and a
plain loop give the same bits on every machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

UNIT: Final = 256
"""Leaf values and scores per unit of log-odds / 2."""
NEVER: Final = -(2**30)
"""A rejection threshold that no score falls below."""


@dataclass(frozen=True, slots=True)
class TreeEnsemble:
    """``sum_t alpha_t h_t(x)`` of Eq. 1 with its cascade.

    Attributes:
        features: shape (trees, 2**depth - 1), int32: index ``(channel * window + row) * window + column``.
        thresholds: shape (trees, 2**depth - 1), uint8.
        leaves: shape (trees, 2**depth), int16, in 1/UNIT; they include the tree's weight.
        rejection: shape (trees,), int32: a window is dropped if its sum after tree t is below ``rejection[t]``.
        window: side of the window in cells.

    Raises:
        ValueError: shapes do not fit together.
    """

    features: NDArray[np.int32]
    thresholds: NDArray[np.uint8]
    leaves: NDArray[np.int16]
    rejection: NDArray[np.int32]
    window: int

    def __post_init__(self) -> None:
        trees, nodes = self.features.shape
        if nodes & (nodes + 1) or not nodes:
            raise ValueError(f"A tree must have 2**depth - 1 inner nodes. Got {nodes} instead.")
        expected = {"thresholds": (trees, nodes), "leaves": (trees, nodes + 1), "rejection": (trees,)}
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise ValueError(
                    f"TreeEnsemble.{name} must have shape {shape}. Got {getattr(self, name).shape} instead."
                )

    def __len__(self) -> int:
        return len(self.features)

    @property
    def depth(self) -> int:
        """Depth of every tree."""
        return int(self.features.shape[1] + 1).bit_length() - 1

    def with_rejection(self, rejection: NDArray[np.int32]) -> TreeEnsemble:
        """The same trees with other rejection thresholds."""
        return TreeEnsemble(self.features, self.thresholds, self.leaves, rejection.astype(np.int32), self.window)

    def partial_sums(self, samples: NDArray[np.uint8]) -> NDArray[np.int32]:
        """Cumulative sums after each tree, without rejection.

        Args:
            samples: shape (n, features), uint8.

        Returns:
            Shape (n, trees), int32, in 1/UNIT.
        """
        return np.asarray(_partial_sums(samples, self.features, self.thresholds, self.leaves))

    def scores(self, samples: NDArray[np.uint8]) -> NDArray[np.int32]:
        """Sums over all trees, without rejection; shape (n,), in 1/UNIT."""
        return np.asarray(_scores(samples, self.features, self.thresholds, self.leaves))


@njit(cache=True, nogil=True)
def leaf_of(sample, features, thresholds):  # type: ignore[no-untyped-def]
    """Number of the leaf that a sample reaches in one tree."""
    nodes = features.shape[0]
    k = 0
    while k < nodes:
        k = 2 * k + (2 if sample[features[k]] >= thresholds[k] else 1)
    return k - nodes


@njit(cache=True, nogil=True)
def _partial_sums(samples, features, thresholds, leaves):  # type: ignore[no-untyped-def]
    out = np.empty((samples.shape[0], features.shape[0]), np.int32)
    for i in range(samples.shape[0]):
        total = np.int32(0)
        for t in range(features.shape[0]):
            total += leaves[t, leaf_of(samples[i], features[t], thresholds[t])]
            out[i, t] = total
    return out


@njit(cache=True, nogil=True)
def _scores(samples, features, thresholds, leaves):  # type: ignore[no-untyped-def]
    out = np.empty(samples.shape[0], np.int32)
    for i in range(samples.shape[0]):
        total = np.int32(0)
        for t in range(features.shape[0]):
            total += leaves[t, leaf_of(samples[i], features[t], thresholds[t])]
        out[i] = total
    return out
