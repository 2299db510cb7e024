"""Mirror symmetry of a crop by matching SIFT features with their mirrored descriptors.

Loy and Eklundh, "Detecting symmetry and symmetric constellations of features", ECCV 2006. Each pair of features that
are mirror images of each other votes for the axis between them, weighted by how well orientation, scale and distance
agree; the strongest axis gives the magnitude.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.linear_algebra import product
from tsr_engine.records import FloatArray, Picture

MIRROR: NDArray[np.intp] = (
    np.arange(128).reshape(4, 4, 8)[::-1][:, :, (-np.arange(8)) % 8].ravel().copy()  # 4 rows x 4 columns x 8 bins
)
"""Permutation that turns a SIFT descriptor into that of the mirrored patch.

A feature's coordinates are aligned with its orientation. There, mirroring reverses the rows of the 4 x 4 grid and the
direction of the 8 orientation bins. So a second SIFT pass is not needed.
"""
MIRROR.setflags(write=False)

_LAYERS, _EDGE, _SIGMA = 3, 10.0, 1.6
"""OpenCV's defaults; its signature requires them before the type of the descriptors."""
_MAX_FEATURES = 80
"""Largest number of features, strongest first."""
_ANGLES, _OFFSETS = 36, 32
"""Cells of the Hough space: 5 degrees by 1/32 of the side."""
_ANGLE_SIGMA = math.radians(6.0)
_OFFSET_SIGMA = 0.04
_SCALE_SIGMA = 0.12
_PHASE_POWER = 4
_COSINE_RANGE = (0.6, 0.9)
"""Cosines of two descriptors that map to similarity 0 and 1."""


@dataclass(frozen=True, slots=True)
class Symmetry:
    """The strongest mirror axis of one crop, in the crop's own px.

    Attributes:
        magnitude: square root of the mean agreement of all features with the axis, in [0, 1]; 0: no feature agrees.
        angle: angle between the axis's normal and the x axis, radians in [0, pi).
        offset: signed distance of the axis from the crop's centre along that normal.
        pairs: shape (n, 4): ``x, y`` of both features of each pair that supports the axis.
        weights: shape (n,): agreement of each pair with the axis, in [0, 1].
        features: number of features found.
    """

    magnitude: float
    angle: float
    offset: float
    pairs: FloatArray
    weights: FloatArray
    features: int


class SymmetryDetector:
    """Measures mirror symmetry at one working size.

    Args:
        size: side that crops are resized to, px; SIFT doubles it once more. Small crops have too few features at
            their original size.
        contrast: SIFT's contrast threshold; a lower one gives more and weaker features.
    """

    def __init__(self, size: int = 48, contrast: float = 0.003) -> None:
        self.size = size
        self.sift = cv2.SIFT.create(
            nfeatures=_MAX_FEATURES,
            nOctaveLayers=_LAYERS,
            contrastThreshold=contrast,
            edgeThreshold=_EDGE,
            sigma=_SIGMA,
            descriptorType=cv2.CV_8U,
        )

    def measure(self, crop: Picture) -> Symmetry:
        """The strongest mirror axis of a near-square crop.

        Args:
            crop: BGR or grey, uint8, any size; an empty or flat crop has magnitude 0.
        """
        height, width = crop.shape[:2]
        if height == 0 or width == 0:
            return _none(0)
        grey = crop if crop.ndim == 2 else cv2.cvtColor(crop, cv2.COLOR_BGR2GRAY)
        shrinks = min(height, width) > self.size
        way = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        grey = cv2.resize(grey, (self.size, self.size), interpolation=way)
        keypoints, descriptors = self.sift.detectAndCompute(grey, None)
        if len(keypoints) < 2:
            return _none(len(keypoints))
        points = np.array([(*k.pt, k.size, np.deg2rad(k.angle)) for k in keypoints], dtype=np.float64)
        points[:, :2] -= (self.size - 1) / 2
        similarity = similarities(descriptors)
        angle, offset, magnitude, partner, agreement = _strongest_axis(points, similarity, float(self.size))
        support = np.flatnonzero(partner >= 0)
        scale = np.array([width, height]) / self.size
        centre = (np.array([width, height]) - 1) / 2
        first = points[support, :2] * scale + centre
        second = points[partner[support], :2] * scale + centre
        # A crop that is not square distorts the axis a little; the mean scale is exact enough for drawing.
        pairs, weights = np.hstack([first, second]), agreement[support]
        return Symmetry(magnitude, angle, offset * float(scale.mean()), pairs, weights, len(keypoints))


def _none(features: int) -> Symmetry:
    return Symmetry(0.0, 0.0, 0.0, np.zeros((0, 4)), np.zeros(0), features)


def similarities(descriptors: NDArray[np.generic]) -> FloatArray:
    """Similarity of each mirrored feature to each other feature: shape (n, n), in [0, 1], symmetric.

    Args:
        descriptors: shape (n, 128), whole numbers from 0 to 255, so that their products have no rounding.
    """
    rows = descriptors.astype(np.int32)
    length = np.sqrt(np.maximum((rows * rows).sum(axis=1), 1))
    cosine = product(rows, np.ascontiguousarray(rows[:, MIRROR].T)) / (length[:, None] * length)
    low, high = _COSINE_RANGE
    return np.asarray(np.clip((cosine - low) / (high - low), 0.0, 1.0))


@njit(cache=True, nogil=True)
def _strongest_axis(
    points: FloatArray, similarity: FloatArray, size: float
) -> tuple[float, float, float, NDArray[np.intp], FloatArray]:
    """Find the axis with the most votes of all pairs in a Hough space of angle and offset.

    Args:
        points: shape (n, 4): x, y about the centre, scale, orientation in radians.
        similarity: shape (n, n), in [0, 1].
        size: side of the picture, px.

    Returns:
        Angle of the normal, offset, magnitude, the partner of each feature about that axis (-1: none), and the
        agreement of each such pair with the axis.
    """
    n = len(points)
    votes = np.zeros((_ANGLES, _OFFSETS))
    theta = np.zeros((n, n))
    radius = np.zeros((n, n))
    weight = np.zeros((n, n))
    reach = 0.5 * size
    for i in range(n):
        for j in range(i, n):
            if similarity[i, j] <= 0.0:
                continue
            dx = points[j, 0] - points[i, 0]
            dy = points[j, 1] - points[i, 1]
            distance = np.hypot(dx, dy)
            if i == j:
                # A feature on the axis is its own mirror image; the axis runs along its orientation.
                t = points[i, 3] + 0.5 * np.pi
            elif distance <= 1.0:
                continue
            else:
                t = np.arctan2(dy, dx)
            # Loy & Eklundh: phase weight 1 - cos(phi_i + phi_j - 2 theta), here scaled to [0, 1].
            phase = 0.5 * (1.0 - np.cos(points[i, 3] + points[j, 3] - 2.0 * t))
            ratio = (points[i, 2] - points[j, 2]) / (points[i, 2] + points[j, 2])
            scale = np.exp(-0.5 * (ratio / _SCALE_SIGMA) ** 2)
            near = np.exp(-0.5 * (distance / size) ** 2)
            w = similarity[i, j] * phase**_PHASE_POWER * scale * near
            if w < 0.02:
                continue
            t %= np.pi
            r = 0.5 * ((points[i, 0] + points[j, 0]) * np.cos(t) + (points[i, 1] + points[j, 1]) * np.sin(t))
            if abs(r) >= reach:
                continue
            theta[i, j] = theta[j, i] = t
            radius[i, j] = radius[j, i] = r
            weight[i, j] = weight[j, i] = w
            _vote(votes, t, r / reach, w)
    best = votes.argmax()
    axis_t = (best // _OFFSETS + 0.5) * np.pi / _ANGLES
    axis_r = ((best % _OFFSETS + 0.5) / _OFFSETS * 2.0 - 1.0) * reach
    partner = np.full(n, -1, np.intp)
    agreement = np.zeros(n)
    total = 0.0
    for i in range(n):
        most = 0.05
        for j in range(n):
            if weight[i, j] <= most:
                continue
            value = weight[i, j] * _agreement(theta[i, j], radius[i, j], axis_t, axis_r, size)
            if value > most:
                most = value
                partner[i] = j
        if partner[i] >= 0:
            total += most
            agreement[i] = most
    return axis_t, axis_r, math.sqrt(min(1.0, total / n)), partner, agreement


@njit(cache=True, nogil=True)
def _vote(votes: FloatArray, t: float, r: float, w: float) -> None:
    """Spread one vote over the 3 x 3 cells around it; ``(r, t)`` and ``(-r, t + pi)`` are the same line."""
    a = int(t / np.pi * _ANGLES)
    b = int((r + 1.0) / 2.0 * _OFFSETS)
    for da in range(-1, 2):
        for db in range(-1, 2):
            row = a + da
            column = b + db
            if row < 0 or row >= _ANGLES:
                row %= _ANGLES
                column = _OFFSETS - 1 - column
            if 0 <= column < _OFFSETS:
                votes[row, column] += w * (1.0 if da == 0 else 0.6) * (1.0 if db == 0 else 0.6)


@njit(cache=True, nogil=True)
def _agreement(t1: float, r1: float, t2: float, r2: float, size: float) -> float:
    """Gaussian similarity of two axes, in [0, 1]."""
    dt = t1 - t2
    dr = r1 - r2
    if dt > 0.5 * np.pi:
        dt -= np.pi
        dr = r1 + r2
    elif dt < -0.5 * np.pi:
        dt += np.pi
        dr = r1 + r2
    return float(np.exp(-0.5 * ((dt / _ANGLE_SIGMA) ** 2 + (dr / (_OFFSET_SIGMA * size)) ** 2)))
