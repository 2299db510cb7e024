"""Which parameters a replay can change: those of the steps after detection."""

from __future__ import annotations

__all__ = ["FIXED", "is_replayable"]

FIXED = ("detector.", "tracking.use_camera_shift", "tracking.shift_scale")
"""Parameters of steps that a replay does not repeat; a name that ends in a dot stands for its whole section."""


def is_replayable(name: str) -> bool:
    """Whether a replay may change a parameter, named in full as in ``gate.tau``."""
    return not any(name.startswith(fixed) if fixed.endswith(".") else name == fixed for fixed in FIXED)
