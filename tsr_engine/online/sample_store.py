"""Growing buffers of the incremental SVM: samples, kernel matrix, coefficients and sets.

Samples occupy slots 0..n-1, so that rows of the kernel matrix stay contiguous; ``order`` maps a user's index to the
slot. When a sample is dropped, the last slot moves into the gap, which takes O(n) time instead of O(n^2).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tsr_engine.online.dual import Dual
from tsr_engine.online.margin import contract
from tsr_engine.online.solution_path import RESERVE
from tsr_engine.records import FloatArray


class SampleStore:
    """Samples with d features, and their part of the solution."""

    X: FloatArray
    y: FloatArray
    Q: FloatArray
    diagonal: FloatArray
    alpha: FloatArray
    g: FloatArray
    status: NDArray[np.int8]
    S: NDArray[np.int64]
    R: FloatArray
    beta: FloatArray
    slope: FloatArray
    blocked: NDArray[np.bool_]

    def __init__(self, features: int) -> None:
        self.features = features
        self.n = 0
        self._order = np.zeros(0, dtype=np.intp)
        self._allocate(0)

    def __len__(self) -> int:
        return self.n

    @property
    def order(self) -> NDArray[np.intp]:
        """Slot of each position, shape (n,)."""
        return self._order[: self.n]

    def scale(self) -> float:
        """The largest element of the kernel's diagonal, the unit of all tolerances; 1 if all are zero."""
        largest = float(self.diagonal[: self.n].max(initial=0.0))
        return largest if largest > 0.0 else 1.0

    def dual(self, C: float) -> Dual:
        """The dual and its current solution, as views for the kernels; :meth:`append` may make them stale."""
        return Dual(
            self.n, C, self.scale(), self.Q, self.y, self.alpha, self.g, self.status, self.S, self.R, self.beta,
            self.slope, self.blocked,
        )  # fmt: skip

    def append(self, x: FloatArray, label: float) -> int:
        """Add a sample; returns its slot. The caller computes the kernel row."""
        if self.n == len(self.y):
            self._allocate(max(32, 2 * self.n))
        slot = self.n
        self.X[slot] = x
        self.y[slot] = label
        self.alpha[slot] = 0.0
        self.status[slot] = RESERVE
        self._order[slot] = slot
        self.n += 1
        return slot

    def leave_margin(self, slot: int, size: int) -> int:
        """Remove a slot from S if it is a member; returns the new size of S."""
        positions = np.flatnonzero(self.S[:size] == slot)
        if len(positions):
            contract(self.R, self.S, size, int(positions[0]))
            size -= 1
        return size

    def drop(self, position: int, size: int) -> None:
        """Free the slot of a position; it must not be in S."""
        slot = int(self._order[position])
        last = self.n - 1
        self._order[position:last] = self._order[position + 1 : self.n].copy()
        self.n = last
        if slot != last:
            self.order[self.order == last] = slot
            members = self.S[:size]
            members[members == last] = slot
            for name in ("X", "y", "alpha", "g", "status", "diagonal"):
                buffer = getattr(self, name)
                buffer[slot] = buffer[last]
            self.Q[slot, :last] = self.Q[last, :last]
            self.Q[:last, slot] = self.Q[:last, last]
            self.Q[slot, slot] = self.Q[last, last]

    def copy(self) -> SampleStore:
        """A deep copy."""
        copied = SampleStore.__new__(SampleStore)
        copied.__dict__.update(
            {key: value.copy() if isinstance(value, np.ndarray) else value for key, value in self.__dict__.items()}
        )
        return copied

    def _allocate(self, capacity: int) -> None:
        """Allocate buffers for ``capacity`` samples and copy the current ones."""
        n = self.n
        shapes: dict[str, tuple[tuple[int, ...], type]] = {
            "X": ((capacity, self.features), np.float64),
            "y": ((capacity,), np.float64),
            "Q": ((capacity, capacity), np.float64),
            "diagonal": ((capacity,), np.float64),
            "alpha": ((capacity,), np.float64),
            "g": ((capacity,), np.float64),
            "status": ((capacity,), np.int8),
            "S": ((capacity,), np.int64),
            "R": ((capacity + 1, capacity + 1), np.float64),
            "beta": ((capacity + 1,), np.float64),
            "slope": ((capacity,), np.float64),
            "blocked": ((capacity,), np.bool_),
            "_order": ((capacity,), np.intp),
        }
        for name, (shape, kind) in shapes.items():
            buffer: NDArray[np.generic] = np.zeros(shape, dtype=kind)
            old = getattr(self, name, None)
            if n and old is not None:
                used = tuple(slice(0, length) for length in old.shape)
                buffer[used] = old
            setattr(self, name, buffer)
