"""Tileable fractal noise."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Plane = NDArray[np.float32]


def fractal(rng: np.random.Generator, size: int, slope: float, low: float = 1.0, high: float = 1e9) -> Plane:
    """Tileable noise whose amplitude falls as frequency to the power of -`slope`.

    Args:
        rng: Source of the phases.
        size: Side of the tile in texels.
        slope: 0 is white, 1 is pink, about 1.7 looks like clouds and terrain.
        low: Lowest frequency, in periods per tile.
        high: Highest frequency, in periods per tile.

    Returns:
        (size, size) float32 with mean 0 and standard deviation 1; its opposite borders match.
    """
    fy, fx = np.fft.fftfreq(size) * size, np.fft.rfftfreq(size) * size
    frequency = np.hypot(fy[:, None], fx[None])
    gain = np.where((frequency >= low) & (frequency <= high), np.maximum(frequency, 1.0) ** -slope, 0.0)
    spectrum = np.fft.rfft2(rng.standard_normal((size, size))) * gain
    plane = np.fft.irfft2(spectrum, s=(size, size))
    return np.asarray((plane - plane.mean()) / plane.std(), np.float32)


def sample(tile: NDArray[np.float32], u: Plane, v: Plane, metres: float) -> NDArray[np.float32]:
    """Sample a tile at points given in metres.

    Args:
        tile: (n, n) or (n, n, c) tileable picture.
        u: Coordinates along the columns, metres.
        v: Coordinates along the rows, metres, the same shape.
        metres: Length of the tile's side.

    Returns:
        Values of the shape of `u` (and channels), bilinear.
    """
    n = tile.shape[0]
    scale = np.float32(n / metres)
    sampled = cv2.remap(
        tile,
        np.mod(u * scale, np.float32(n)),
        np.mod(v * scale, np.float32(n)),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_WRAP,
    )
    return np.asarray(sampled, np.float32)


def mipmaps(picture: NDArray[np.float32]) -> list[NDArray[np.float32]]:
    """A picture and its successive halvings by area, down to 4 pixels."""
    levels = [picture]
    while min(levels[-1].shape[:2]) > 4:
        h, w = levels[-1].shape[:2]
        levels.append(cv2.resize(levels[-1], (max(w // 2, 1), max(h // 2, 1)), interpolation=cv2.INTER_AREA))
    return levels
