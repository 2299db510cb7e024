"""Checks of the arguments of ``IncrementalSVC``; each message names what was expected and what was given."""

from __future__ import annotations

import math
from collections.abc import Iterable
from numbers import Integral, Real
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tsr_engine.records import FloatArray

MAX_C: Final = 1e12
"""Largest ``C``, and largest ``C K(x, x)``. Above it, coefficients are so small relative to C that they round to 0."""


def check_parameters(C: object, kernel: object, gamma: object) -> None:
    """Check the parameters of a machine.

    Raises:
        ValueError: C or gamma is not a finite number > 0 (gamma may be None), C is above :data:`MAX_C`, or the kernel
            is unknown.
    """
    if not _positive(C, MAX_C):
        raise ValueError(_message("C", f"a number greater than 0 and at most {MAX_C:g}", C))
    if kernel not in ("linear", "rbf"):
        raise ValueError(_message("kernel", "'linear' or 'rbf'", kernel))
    if gamma is not None and not _positive(gamma):
        raise ValueError(_message("gamma", "None or a finite number greater than 0", gamma))


def as_samples(X: ArrayLike, features: int) -> FloatArray:
    """Samples as a contiguous array of shape (m, d).

    Args:
        X: shape (m, d), finite.
        features: expected d; 0: any.

    Raises:
        ValueError: the samples are not numbers, not finite, or of another shape.
    """
    try:
        samples = np.asarray(X, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"The samples X of IncrementalSVC must be numbers. Got {type(X).__name__} instead.") from None
    if samples.ndim != 2 or samples.shape[1] == 0:
        raise ValueError(f"The samples X of IncrementalSVC must have shape (m, d), d > 0. Got {samples.shape} instead.")
    if features and samples.shape[1] != features:
        raise ValueError(
            f"The samples X of IncrementalSVC must have {features} features. Got {samples.shape[1]} instead."
        )
    if not np.isfinite(samples).all():
        raise ValueError("The samples X of IncrementalSVC must be finite. Got NaN or infinity instead.")
    return np.ascontiguousarray(samples)


def check_scale(samples: FloatArray, C: float) -> None:
    """Check that samples (m, d) are short enough for a linear kernel.

    Raises:
        ValueError: ``C |x|^2`` is above :data:`MAX_C`.
    """
    largest = C * float((samples * samples).sum(axis=1).max(initial=0.0))
    if largest > MAX_C:
        raise ValueError(
            f"The samples X of IncrementalSVC must have C |x|^2 <= {MAX_C:g} with a linear kernel. Got {largest:.3g} "
            "instead; scale the features."
        )


def as_labels(y: ArrayLike, expected: int) -> FloatArray:
    """Labels as floats, shape (expected,).

    Raises:
        ValueError: the shape is another one, or a label is neither -1 nor +1.
    """
    labels = np.asarray(y)
    if labels.shape != (expected,):
        raise ValueError(f"The labels y of IncrementalSVC must have shape ({expected},). Got {labels.shape} instead.")
    wrong = [value for value in labels.tolist() if value not in (-1, 1)]
    if wrong:
        raise ValueError(f"The labels y of IncrementalSVC must be -1 or +1. Got {wrong[0]!r} instead.")
    return labels.astype(np.float64)


def as_indices(indices: int | Iterable[int] | NDArray[np.generic], n: int) -> list[int]:
    """Indices of samples as a list of numbers in 0..n-1.

    Raises:
        IndexError: an index is out of range.
        ValueError: an index occurs twice or is not a whole number.
    """
    chosen = list(np.atleast_1d(np.asarray(indices if isinstance(indices, (int, np.ndarray)) else list(indices))))
    for value in chosen:
        if not isinstance(value, Integral):
            raise ValueError(f"The indices to unlearn must be whole numbers. Got {value!r} instead.")  # noqa: TRY004
        if not n:
            raise IndexError(f"There are no samples to unlearn. Got the index {value}.")
        if not 0 <= int(value) < n:
            raise IndexError(f"The indices to unlearn must be in 0..{n - 1} ({n} samples). Got {value} instead.")
    numbers = [int(value) for value in chosen]
    if len(set(numbers)) != len(numbers):
        raise ValueError(f"The indices to unlearn must not repeat. Got {numbers} instead.")
    return numbers


def _message(name: str, expected: str, got: object) -> str:
    return f"The '{name}' parameter of IncrementalSVC must be {expected}. Got {got!r} instead."


def _positive(value: object, maximum: float = math.inf) -> bool:
    number = isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    return number and 0 < float(value) <= maximum  # type: ignore[arg-type]
