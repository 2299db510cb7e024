"""Colours: sRGB as input, linear light for computation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Linear = NDArray[np.float32]


def lin(r: float, g: float, b: float) -> Linear:
    """Convert an sRGB colour, 0 to 255, to linear (b, g, r)."""
    return np.asarray((np.array([b, g, r]) / 255) ** 2.2, np.float32)


def linear_picture(bgra: NDArray[np.uint8]) -> Linear:
    """Convert a straight-alpha sRGB picture, BGRA, to premultiplied linear float32."""
    out: Linear = np.asarray(bgra / np.float32(255), np.float32)
    out[..., :3] = out[..., :3] ** 2.2 * out[..., 3:]
    return out


def opaque(bgr: NDArray[np.uint8]) -> Linear:
    """Convert an opaque sRGB picture to premultiplied linear BGRA float32."""
    return linear_picture(np.dstack([bgr, np.full(bgr.shape[:2], 255, np.uint8)]))
