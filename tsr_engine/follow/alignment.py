"""Alignment of a template with a picture: place and scale, to a fraction of a pixel.

Gauss-Newton on the sum of squared differences, as in efficient second-order minimisation (Benhimane & Malis 2004): the
gradient is the mean of the template's and the picture's. Gain and offset of the light are estimated as well. Cauchy
weights of the residuals reduce the effect of objects that cover a part of the sign.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.records import FloatArray

_MAX_ITERATIONS = 12
_MIN_STEP_PX = 0.005
"""px of the template: a smaller step ends the iteration."""
_MAX_STEP_PX = 1.5
_CHANNELS = 3


@njit(cache=True, nogil=True)
def align(
    region: NDArray[np.float32], template: NDArray[np.float32], weights: NDArray[np.float32], start: FloatArray
) -> FloatArray:
    """Move and scale a template until it matches the picture.

    Args:
        region: shape (H, W, 3), the picture around the place.
        template: shape (h, w, 3).
        weights: shape (h, w), >= 0, weight of each pixel of the template.
        start: shape (3,): centre (x, y) of the template in the region, in pixel-centre coordinates; and region px per
            template px.

    Returns:
        Shape (6,): centre x, centre y, scale, weighted correlation in [-1, 1], share of the weight that fits in [0, 1],
        and standard error of the natural logarithm of the scale.
    """
    height, width = weights.shape
    n = 4 + _CHANNELS
    cx, cy, scale = start[0], start[1], start[2]
    patch = np.empty((height, width, _CHANNELS), np.float32)
    lengths = np.empty((height, width), np.float32)
    grad_x, grad_y = np.zeros((height, width, _CHANNELS)), np.zeros((height, width, _CHANNELS))
    for i in range(1, height - 1):
        for j in range(1, width - 1):
            for c in range(_CHANNELS):
                grad_x[i, j, c] = 0.25 * (template[i, j + 1, c] - template[i, j - 1, c])
                grad_y[i, j, c] = 0.25 * (template[i + 1, j, c] - template[i - 1, j, c])
    gain, offset = 1.0, np.zeros(_CHANNELS)
    row = np.empty(n)
    error = 1.0
    inlier_share = 0.0
    gain, correlation = _fit_light(region, template, weights, cx, cy, scale, patch, offset)
    for _ in range(_MAX_ITERATIONS):
        spread = _residual_lengths(template, weights, patch, gain, offset, lengths)
        normal, target = np.zeros((n, n)), np.zeros(n)
        total = inlier_share = squares = 0.0
        for i in range(1, height - 1):
            y = i - (height - 1) / 2.0
            for j in range(1, width - 1):
                if weights[i, j] <= 0.0:
                    continue
                x = j - (width - 1) / 2.0
                robust = 1.0 / (1.0 + (lengths[i, j] / spread) ** 2)
                weight = weights[i, j] * robust
                total += weights[i, j]
                inlier_share += weight
                for c in range(_CHANNELS):
                    gx = gain * grad_x[i, j, c] + 0.25 * (patch[i, j + 1, c] - patch[i, j - 1, c])
                    gy = gain * grad_y[i, j, c] + 0.25 * (patch[i + 1, j, c] - patch[i - 1, j, c])
                    row[0], row[1], row[2] = gx, gy, gx * x + gy * y
                    row[3] = -template[i, j, c]
                    for k in range(_CHANNELS):
                        row[4 + k] = -1.0 if k == c else 0.0
                    residual = patch[i, j, c] - gain * template[i, j, c] - offset[c]
                    squares += weight * residual * residual
                    for a in range(n):
                        scaled = weight * row[a]
                        target[a] -= scaled * residual
                        for b in range(a, n):
                            normal[a, b] += scaled * row[b]
        for a in range(n):
            for b in range(a):
                normal[a, b] = normal[b, a]
            normal[a, a] += 1e-6 * normal[a, a] + 1e-9
        inverse = np.linalg.inv(normal)
        step = inverse @ target
        inlier_share /= max(total, 1e-9)
        error = np.sqrt(inverse[2, 2] * squares / max(_CHANNELS * total, 1.0))
        dx = min(max(step[0], -_MAX_STEP_PX), _MAX_STEP_PX)
        dy = min(max(step[1], -_MAX_STEP_PX), _MAX_STEP_PX)
        ds = min(max(step[2], -0.08), 0.08)
        cx += scale * dx
        cy += scale * dy
        scale *= 1.0 + ds
        gain, correlation = _fit_light(region, template, weights, cx, cy, scale, patch, offset)
        if abs(dx) + abs(dy) + abs(ds) * height / 2.0 < _MIN_STEP_PX:
            break
    return np.array([cx, cy, scale, correlation, inlier_share, error])


@njit(cache=True, nogil=True)
def _fit_light(
    region: NDArray[np.float32],
    template: NDArray[np.float32],
    weights: NDArray[np.float32],
    cx: float,
    cy: float,
    scale: float,
    patch: NDArray[np.float32],
    offset: FloatArray,
) -> tuple[float, float]:
    """Sample the region under the template and fit the offsets of light; returns the gain and the correlation."""
    height, width = weights.shape
    rows, columns, _ = region.shape
    sums = np.zeros((_CHANNELS, 2))
    total = 1e-9
    for i in range(height):
        v = min(max(cy + scale * (i - (height - 1) / 2.0), 0.0), rows - 1.001)
        v0 = int(v)
        fv = np.float32(v - v0)
        for j in range(width):
            u = min(max(cx + scale * (j - (width - 1) / 2.0), 0.0), columns - 1.001)
            u0 = int(u)
            fu = np.float32(u - u0)
            total += weights[i, j]
            for c in range(_CHANNELS):
                top = region[v0, u0, c] + fu * (region[v0, u0 + 1, c] - region[v0, u0, c])
                low = region[v0 + 1, u0, c] + fu * (region[v0 + 1, u0 + 1, c] - region[v0 + 1, u0, c])
                value = top + fv * (low - top)
                patch[i, j, c] = value
                sums[c, 0] += weights[i, j] * value
                sums[c, 1] += weights[i, j] * template[i, j, c]
    cross = energy = energy_template = 0.0
    for c in range(_CHANNELS):
        sums[c, 0] /= total
        sums[c, 1] /= total
    for i in range(height):
        for j in range(width):
            for c in range(_CHANNELS):
                a = patch[i, j, c] - sums[c, 0]
                b = template[i, j, c] - sums[c, 1]
                cross += weights[i, j] * a * b
                energy += weights[i, j] * a * a
                energy_template += weights[i, j] * b * b
    gain = min(max(cross / (energy_template + 1e-6), 0.05), 20.0)
    for c in range(_CHANNELS):
        offset[c] = sums[c, 0] - gain * sums[c, 1]
    return gain, cross / np.sqrt(energy * energy_template + 1e-6)


@njit(cache=True, nogil=True)
def _residual_lengths(
    template: NDArray[np.float32],
    weights: NDArray[np.float32],
    patch: NDArray[np.float32],
    gain: float,
    offset: FloatArray,
    lengths: NDArray[np.float32],
) -> float:
    """Write the lengths of residuals into ``lengths``; returns the spread at which a residual counts half."""
    height, width = weights.shape
    used = np.empty(height * width)
    count = 0
    for i in range(height):
        for j in range(width):
            squares = 0.0
            for c in range(_CHANNELS):
                residual = patch[i, j, c] - gain * template[i, j, c] - offset[c]
                squares += residual * residual
            lengths[i, j] = np.sqrt(squares)
            if weights[i, j] > 0.0:
                used[count] = lengths[i, j]
                count += 1
    return max(2.5 * np.median(used[:count]), 4.0) if count else 4.0
