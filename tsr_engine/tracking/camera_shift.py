"""Global shift of the picture between two frames: the part of the flow that camera rotation explains.

A moving and turning camera causes two flows. Every point moves away from the focus of expansion (FOE), near points
faster, and the rotation shifts the whole picture. Flow across the ray from the FOE comes only from the rotation, at any
depth, so every tracked point gives one exact equation for the shift. Flow along the ray has less weight, with one
common growth for all points.
"""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.linear_algebra import solve
from tsr_engine.records import FloatArray, Picture

_POINTS = 120
_CELL = 12
"""Side of the cells of the small picture, px; the strongest corner of each is tracked."""
_MIN_POINTS = 8
_RADIAL_WEIGHT = 0.3
"""Weight of the equations along the ray, in [0, 1]; 1 is the plain similarity without rotation."""
_ITERATIONS = 6
_MIN_SCALE = 0.15
"""Floor of the robust residual scale, px of the small picture."""


UNKNOWN_SHIFT = (1e-9, 1e-9)
"""The shift if too few points can be tracked: almost zero, but not the exact zero of a repeated picture."""


class CameraShift:
    """Estimates the shift from sparse Lucas-Kanade flow on a small grey picture; holds the previous one.

    Only a picture that repeats the last one has a shift of exactly (0.0, 0.0). The tracker then stands still in this
    frame and catches up in the next.

    Args:
        scale: factor by which the picture is reduced.
        foe: focus of expansion as shares of the picture's width and height.
    """

    def __init__(self, scale: int = 4, foe: tuple[float, float] = (0.5, 0.5)) -> None:
        self._scale = scale
        self._foe = foe
        self._previous: Picture | None = None
        self.repeated = False
        """Whether the last picture repeated the one before it."""

    def step(self, picture: Picture) -> tuple[float, float]:
        """Shift (dx, dy) from the previous picture to this one, px of the full picture.

        Exactly zero for a picture that repeats the last one; ``UNKNOWN_SHIFT`` for the first picture, after a change of
        size, and if too few points can be tracked.
        """
        measured = self.flow(picture)
        if measured is None:
            return (0.0, 0.0) if self.repeated else UNKNOWN_SHIFT
        points, flow, small = measured
        height, width = picture.shape[:2]
        shift = fit_shift(points - [self._foe[0] * small[0], self._foe[1] * small[1]], flow)[0]
        return float(shift[0] * width / small[0]), float(shift[1] * height / small[1])

    def flow(self, picture: Picture) -> tuple[FloatArray, FloatArray, tuple[int, int]] | None:
        """Optical flow from the previous picture to this one.

        Returns:
            Points of the previous small picture, and their flow, shape (n, 2) each, in px of the small picture; and its
            width and height. None for the first picture, a repeated one (then ``repeated`` is set), one of another
            size, and if too few points can be tracked.
        """
        height, width = picture.shape[:2]
        small = (max(width // self._scale, 16), max(height // self._scale, 16))
        grey = cv2.cvtColor(cv2.resize(picture, small, interpolation=cv2.INTER_LINEAR), cv2.COLOR_BGR2GRAY)
        previous, self._previous = self._previous, grey
        self.repeated = False
        if previous is None or previous.shape != grey.shape:
            return None
        if cv2.norm(previous, grey, cv2.NORM_L1) <= 0.25 * grey.size:
            self.repeated = True
            return None
        start = _corners(previous)
        if len(start) < _MIN_POINTS:
            return None
        end, is_found, _ = cv2.calcOpticalFlowPyrLK(
            _match_exposure(previous, grey), grey, start, None, winSize=(9, 9), maxLevel=3, criteria=(3, 10, 0.03)
        )
        is_tracked = is_found[:, 0] == 1
        points = start[is_tracked, 0].astype(np.float64) + 0.5
        flow = (end[is_tracked, 0] - start[is_tracked, 0]).astype(np.float64)
        return None if len(points) < _MIN_POINTS else (points, flow, small)


def fit_shift(points: FloatArray, flow: FloatArray) -> tuple[FloatArray, float]:
    """Robust fit of ``flow = shift + growth * points`` with most weight on the component across the ray.

    Iteratively reweighted least squares with Cauchy weights, scale from the median absolute residual.

    Args:
        points: shape (n, 2), n >= 2, relative to the FOE.
        flow: shape (n, 2), same unit.

    Returns:
        The shift, shape (2,), and the growth per frame.
    """
    points = np.ascontiguousarray(points, dtype=np.float64)
    flow = np.ascontiguousarray(flow, dtype=np.float64)
    # The start is the median flow, so that a few outliers do not spoil the first round.
    start = np.array([*np.median(flow, axis=0), 0.0])
    solution = _fit_reweighted(points, flow, start, _RADIAL_WEIGHT**2, _ITERATIONS, _MIN_SCALE)
    return solution[:2], float(solution[2])


@njit(cache=True, nogil=True)
def _fit_reweighted(
    points: FloatArray, flow: FloatArray, start: FloatArray, radial: float, rounds: int, min_scale: float
) -> FloatArray:
    """The rounds of ``fit_shift``: shift x, shift y, growth."""
    n = len(points)
    dx, dy, growth = start[0], start[1], start[2]
    across = np.empty(n)
    for _ in range(rounds):
        for i in range(n):
            radius = max(np.hypot(points[i, 0], points[i, 1]), 1e-6)
            ux, uy = points[i, 0] / radius, points[i, 1] / radius
            across[i] = abs(ux * (flow[i, 1] - dy) - uy * (flow[i, 0] - dx))
        spread = 2.0 * max(1.4826 * np.median(across), min_scale)
        normal = np.zeros((3, 3))
        target = np.zeros((3, 1))
        for i in range(n):
            radius = max(np.hypot(points[i, 0], points[i, 1]), 1e-6)
            ux, uy = points[i, 0] / radius, points[i, 1] / radius
            along = ux * (flow[i, 0] - dx) + uy * (flow[i, 1] - dy) - growth * radius
            # Across the ray: -uy dx + ux dy = cross; along it: ux dx + uy dy + radius growth = run.
            a = 1.0 / (1.0 + (across[i] / spread) ** 2)
            b = radial / (1.0 + (along / spread) ** 2)
            cross = ux * flow[i, 1] - uy * flow[i, 0]
            run = ux * flow[i, 0] + uy * flow[i, 1]
            normal[0, 0] += a * uy * uy + b * ux * ux
            normal[0, 1] += (b - a) * ux * uy
            normal[1, 1] += a * ux * ux + b * uy * uy
            normal[0, 2] += b * ux * radius
            normal[1, 2] += b * uy * radius
            normal[2, 2] += b * radius * radius
            target[0, 0] += b * ux * run - a * uy * cross
            target[1, 0] += b * uy * run + a * ux * cross
            target[2, 0] += b * radius * run
        normal[1, 0], normal[2, 0], normal[2, 1] = normal[0, 1], normal[0, 2], normal[1, 2]
        for k in range(3):
            normal[k, k] += 1e-9
        solved = solve(normal, target)
        dx, dy, growth = solved[0, 0], solved[1, 0], solved[2, 0]
    return np.array([dx, dy, growth])


def _match_exposure(before: Picture, grey: Picture) -> Picture:
    """The earlier picture with the later one's mean and contrast, since optical flow assumes constant brightness."""
    mean_before, std_before = (float(v[0, 0]) for v in cv2.meanStdDev(before))
    mean, std = (float(v[0, 0]) for v in cv2.meanStdDev(grey))
    if min(std, std_before) < 1.0 or (abs(mean - mean_before) < 1.0 and abs(std - std_before) < 1.0):
        return before
    levels = (np.arange(256) - mean_before) * (std / std_before) + mean
    adapted: Picture = cv2.LUT(before, np.clip(np.rint(levels), 0, 255).astype(np.uint8))
    return adapted


def _corners(grey: Picture) -> NDArray[np.float32]:
    """The ``_POINTS`` best of the strongest corners of all cells; shape (n, 1, 2), float32."""
    strength = cv2.cornerMinEigenVal(grey, 3)
    rows, columns = grey.shape[0] // _CELL, grey.shape[1] // _CELL
    cells = strength[: rows * _CELL, : columns * _CELL].reshape(rows, _CELL, columns, _CELL)
    cells = cells.transpose(0, 2, 1, 3).reshape(rows * columns, _CELL * _CELL)
    positions = cells.argmax(axis=1)
    best = cells[np.arange(len(cells)), positions]
    order = np.argsort(-best, kind="stable")[:_POINTS]
    order = order[best[order] > max(1e-5, 0.002 * float(best.max(initial=0.0)))]
    y = (order // columns) * _CELL + positions[order] // _CELL
    x = (order % columns) * _CELL + positions[order] % _CELL
    return np.stack([x, y], axis=1).astype(np.float32)[:, None]
