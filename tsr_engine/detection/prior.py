"""The spatial prior: where in a picture signs appear (section III-A, Eq. 2, Fig. 5).

``P_spatial`` is a two-dimensional Parzen estimate with a Gaussian kernel of sign centres in coordinates normalised by
the picture's size, scaled so that its maximum is 1. It is stored as a table over the unit square.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tsr_engine.params.detector import PriorParams
from tsr_engine.records import FloatArray

GRID: Final = 128
"""Table nodes along each axis; nodes lie at (i + 1/2) / GRID."""


@dataclass(frozen=True, slots=True)
class SpatialPrior:
    """A table of ``P_spatial`` and the learned weight.

    Attributes:
        table: shape (GRID, GRID), float32, rows along y, in [0, 1] with maximum 1.
        weight: ``lambda`` of Eq. 2, learned by Eq. 8, in units of the raw score, >= 0.

    Raises:
        ValueError: the table has another shape.
    """

    table: NDArray[np.float32]
    weight: float

    def __post_init__(self) -> None:
        if self.table.shape != (GRID, GRID):
            raise ValueError(f"The prior's table must have shape ({GRID}, {GRID}). Got {self.table.shape} instead.")

    def at(self, boxes: FloatArray, width: int, height: int) -> FloatArray:
        """``P_spatial`` at the centres of boxes (n, 4) in a picture of width x height px; shape (n,), in [0, 1]."""
        from scipy.ndimage import map_coordinates  # a server shows priors without this function

        x = (boxes[:, 0] + boxes[:, 2]) / (2 * width)
        y = (boxes[:, 1] + boxes[:, 3]) / (2 * height)
        places = np.stack([y * GRID - 0.5, x * GRID - 0.5])
        values = map_coordinates(self.table.astype(np.float64), places, order=1, mode="nearest")
        return np.asarray(np.clip(values, 0.0, 1.0))


def parzen(centres: ArrayLike, bandwidth: float) -> NDArray[np.float32]:
    """Parzen estimate of a density over the unit square, scaled to a maximum of 1 (section III-A).

    Args:
        centres: shape (n, 2), normalised (x, y) in [0, 1], n >= 1.
        bandwidth: standard deviation of the Gaussian kernel, as a share of the picture's sides.

    Returns:
        Shape (GRID, GRID), float32, rows along y.

    Raises:
        ValueError: there are no centres.
    """
    points = np.asarray(centres, dtype=np.float64).reshape(-1, 2)
    if not len(points):
        raise ValueError("A Parzen estimate needs at least one centre. Got none.")
    nodes = (np.arange(GRID) + 0.5) / GRID
    kernel_x = np.exp(-0.5 * ((nodes[None] - points[:, :1]) / bandwidth) ** 2)
    kernel_y = np.exp(-0.5 * ((nodes[None] - points[:, 1:]) / bandwidth) ** 2)
    from tsr_engine.linear_algebra import product  # reading a prior does not need Numba

    density = product(np.ascontiguousarray(kernel_y.T), kernel_x)
    return np.asarray(density / density.max(), dtype=np.float32)


def learn_weight(raw: ArrayLike, prior: ArrayLike, labels: ArrayLike) -> float:
    """``lambda`` that minimises Eq. 8, ``1/2 sum (H + q lambda - y)^2`` with ``q = P - 1/2``, in closed form.

    Args:
        raw: shape (n,), detector outputs on the scale of the labels.
        prior: shape (n,), ``P_spatial`` at the detections.
        labels: shape (n,), +1 for signs, -1 for the rest.

    Returns:
        ``sum q (y - H) / sum q^2``; 0 where that is negative or undefined.
    """
    q = np.asarray(prior, dtype=np.float64) - 0.5
    residual = np.asarray(labels, dtype=np.float64) - np.asarray(raw, dtype=np.float64)
    power = float(np.sum(q * q))
    return max(0.0, float(np.sum(q * residual)) / power) if power > 0 else 0.0


def effective_weight(prior: SpatialPrior | None, params: PriorParams) -> float:
    """``lambda`` of a detector: the parameter's value if set, else the learned one; 0 without a prior or if off."""
    if prior is None or not params.use_prior:
        return 0.0
    return prior.weight if params.prior_lambda is None else params.prior_lambda


def with_prior(raw: FloatArray, prior: FloatArray, weight: float) -> FloatArray:
    """Final scores of Eq. 2, ``raw + (P - 1/2) * lambda``; shape (n,)."""
    return np.asarray(raw + (prior - 0.5) * weight)
