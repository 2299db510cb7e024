"""Raises labels of signs on one post so that they do not overlap in the first view."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tsr_engine.records import FloatArray

FIELD_OF_VIEW_RAD: Final = 0.7
"""Vertical field of view of the viewer's camera, rad."""
VIEW_HEIGHT_PX: Final = 560.0
"""Assumed height of the view, px; in a higher view labels lie further apart."""
LETTER_WIDTH_PX: Final = 7.5
"""Width of a letter, px."""
LABEL_HEIGHT_PX: Final = 24.0
"""Height of a label with its border, px."""
MAX_LETTERS: Final = 36
"""Maximum number of letters of a name; longer names are cut."""


def label_text(name: str, *more: str) -> str:
    """Text of a sign's label; its name comes first."""
    short = name if len(name) <= MAX_LETTERS else f"{name[: MAX_LETTERS - 1].rstrip()}…"
    return " · ".join([short, *more])


def label_offsets(points: ArrayLike, texts: Sequence[str], eye: Sequence[float], target: Sequence[float]) -> FloatArray:
    """Compute how far to raise each label.

    Args:
        points: shape (n, 3), middle of each label's lower edge before raising.
        texts: their n texts.
        eye: shape (3,), position of the viewer.
        target: shape (3,), point that the viewer looks at.

    Returns:
        Shape (n,), at least 0, in scene units upwards. The nearest label keeps its place.
    """
    positions = np.asarray(points, np.float64).reshape(-1, 3)
    raised_by = np.zeros(len(positions))
    forward = np.asarray(target, np.float64) - np.asarray(eye, np.float64)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    upward = np.cross(right, forward)
    from_eye = positions - np.asarray(eye, np.float64)
    depth = from_eye @ forward
    scale = VIEW_HEIGHT_PX / 2 / np.tan(FIELD_OF_VIEW_RAD / 2) / np.maximum(depth, 1e-6)
    x, y = from_eye @ right * scale, from_eye @ upward * scale
    half = np.array([len(text) for text in texts]) * LETTER_WIDTH_PX / 2
    placed: list[tuple[float, float, float]] = []
    for i in np.argsort(depth, kind="stable").tolist():
        if depth[i] <= 0:  # behind the viewer
            continue
        low = float(y[i])
        # from below upwards: each label in the way raises this one above it
        for middle, half_width, bottom in sorted(placed, key=lambda label: label[2]):
            if abs(middle - x[i]) < half_width + half[i] and abs(bottom - low) < LABEL_HEIGHT_PX:
                low = bottom + LABEL_HEIGHT_PX
        placed.append((float(x[i]), float(half[i]), low))
        raised_by[i] = (low - y[i]) / (scale[i] * upward[2])
    return raised_by
