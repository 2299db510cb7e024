"""An independent, slow computation of the channels: NumPy in double precision, no shared code."""

from __future__ import annotations

import numpy as np


def luv(bgr: np.ndarray) -> np.ndarray:
    rgb = bgr[..., ::-1].astype(np.float64) / 255
    to_xyz = np.array([[0.430574, 0.341550, 0.178325], [0.222015, 0.706655, 0.071330], [0.020183, 0.129553, 0.939180]])
    x, y, z = np.moveaxis(rgb @ to_xyz.T, -1, 0)
    lightness = np.where(y > (6 / 29) ** 3, 116 * np.cbrt(y) - 16, y * (29 / 3) ** 3) / 270
    total = x + 15 * y + 3 * z + 1e-35
    u = lightness * 13 * (4 * x / total - 0.197833) + 88 / 270
    v = lightness * 13 * (9 * y / total - 0.468331) + 134 / 270
    return np.stack([lightness, u, v])


def blur121(plane: np.ndarray) -> np.ndarray:
    p = np.pad(plane, 1, mode="edge")
    rows = (p[:-2] + 2 * p[1:-1] + p[2:]) / 4
    return (rows[:, :-2] + 2 * rows[:, 1:-1] + rows[:, 2:]) / 4


def triangle_blur(plane: np.ndarray, radius: int) -> np.ndarray:
    taps = np.array([radius + 1 - abs(k) for k in range(-radius, radius + 1)], dtype=np.float64)
    taps /= taps.sum()
    p = np.pad(plane, radius, mode="edge")
    rows = sum(t * p[k : k + plane.shape[0]] for k, t in enumerate(taps))
    return sum(t * rows[:, k : k + plane.shape[1]] for k, t in enumerate(taps))


def cell_means(plane: np.ndarray, shrink: int) -> np.ndarray:
    h, w = plane.shape[0] // shrink, plane.shape[1] // shrink
    return plane[: h * shrink, : w * shrink].reshape(h, shrink, w, shrink).mean((1, 3))


def channels(bgr: np.ndarray, shrink: int) -> np.ndarray:
    colour = np.stack([blur121(plane) for plane in luv(bgr)])
    padded = np.pad(colour, ((0, 0), (1, 1), (1, 1)), mode="edge")
    gx = (padded[:, 1:-1, 2:] - padded[:, 1:-1, :-2]) / 2
    gy = (padded[:, 2:, 1:-1] - padded[:, :-2, 1:-1]) / 2
    strongest = np.argmax(gx**2 + gy**2, axis=0)[None]
    gx = np.take_along_axis(gx, strongest, 0)[0]
    gy = np.take_along_axis(gy, strongest, 0)[0]
    magnitude = np.hypot(gx, gy)
    angle = np.arctan2(gy, gx)
    oriented = [magnitude * np.maximum(0, 2 * np.cos(2 * (angle - np.deg2rad(30 * k))) - 1) for k in range(6)]
    cells = np.stack([cell_means(p, shrink) for p in [*colour, magnitude, *oriented]])
    divisor = triangle_blur(cells[3], max(1, round(5 / shrink))) + 0.005
    cells[3:] /= divisor
    return cells
