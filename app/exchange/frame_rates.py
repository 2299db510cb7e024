"""Computes exact frame rates from the time stamps of a video, not from its header."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from app.evidence.run_columns import IntColumn

_MAX_DENOMINATOR = 1001
"""Largest denominator of a plausible rate, such as 30000/1001."""


def exact_rate(pts: IntColumn, time_base: Fraction, nominal: float | None) -> tuple[Fraction | None, bool]:
    """Return the rate in frames per second, and whether all frames keep to it.

    A frame keeps to a rate if it lies within one tick of its expected time, because containers with coarse ticks round.

    Args:
        pts: time stamps in ticks, in order of presentation, shape (n,).
        time_base: seconds per tick.
        nominal: the header's rate.
    """
    candidates = []
    if nominal is not None and nominal > 0:
        candidates.append(Fraction(nominal).limit_denominator(_MAX_DENOMINATOR))
    steps = np.sort(np.diff(pts))
    steps = steps[steps > 0]
    if len(steps):
        candidates.append(1 / (int(steps[len(steps) // 2]) * time_base))
    for rate in candidates:
        step = float(1 / rate / time_base)
        if len(pts) and np.abs(pts - pts[0] - np.arange(len(pts)) * step).max() <= 1.0 + 1e-6:
            return rate, True
    return (candidates[0] if candidates else None), len(pts) < 2
