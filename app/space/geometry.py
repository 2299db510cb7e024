"""The numbers behind the three scenes, as pure functions.

World axes are those of viser: right-handed, z up, in units of the scene. The picture plane stands upright, so that
``x`` of the world is ``x`` of the picture, ``z`` is up, and ``y`` leads away from the viewer: time in the volume,
distance in the metric drive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "FLAT",
    "UPRIGHT",
    "Camera",
    "Volume",
    "bead_places",
    "drape",
    "focal_length",
    "frustum_scale",
    "metric_positions",
    "nice_step",
    "pick_rows",
    "polyline_rows",
    "surface",
    "thin_rows",
]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

UPRIGHT: Final = (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)
"""Quaternion (w, x, y, z) that stands up a picture which viser lays out as right, down, forward."""
FLAT: Final = (0.0, 1.0, 0.0, 0.0)
"""Quaternion that lays such a picture on the floor, its upper edge away from the viewer, seen from above."""


@dataclass(frozen=True, slots=True)
class Volume:
    """The block that a stretch of video fills: picture plane against time.

    Attributes:
        width: of the picture, px.
        height: of the picture, px.
        first: seconds at the near face.
        last: seconds at the far face, not before ``first``.
        size: height of the block, scene units.
        depth: length of the block along time, scene units.
    """

    width: int
    height: int
    first: float
    last: float
    size: float = 4.0
    depth: float = 10.0

    @property
    def unit(self) -> float:
        """Scene units a pixel."""
        return self.size / self.height

    @property
    def half_width(self) -> float:
        """Half the width of the block, scene units."""
        return self.width * self.unit / 2

    def along(self, seconds: ArrayLike) -> FloatArray:
        """``y`` of moments, shape as given; the middle of the stretch is at 0."""
        span = max(self.last - self.first, 1e-6)
        return np.asarray((np.asarray(seconds, np.float64) - self.first) / span * self.depth - self.depth / 2)

    def places(self, boxes: ArrayLike, seconds: ArrayLike) -> FloatArray:
        """World positions of the centres of boxes, shape (n, 4) in px, at moments of shape (n,): shape (n, 3)."""
        table = np.asarray(boxes, np.float64).reshape(-1, 4)
        x = ((table[:, 0] + table[:, 2]) / 2 - self.width / 2) * self.unit
        z = (self.height / 2 - (table[:, 1] + table[:, 3]) / 2) * self.unit
        return np.stack([x, np.broadcast_to(self.along(seconds), x.shape), z], axis=1)


def polyline_rows(track: ArrayLike, frame: ArrayLike, gap: int = 12) -> IntArray:
    """Rows that a line leads on from: row i and row i + 1 belong to one track and lie at most ``gap`` frames apart.

    Args:
        track: shape (n,), rows sorted by track, then frame.
        frame: shape (n,).
        gap: frames that a line may bridge, >= 1.

    Returns:
        Shape (m,), each i < n - 1.
    """
    t, f = np.asarray(track, np.int64), np.asarray(frame, np.int64)
    return np.flatnonzero((np.diff(t) == 0) & (np.diff(f) <= gap)).astype(np.int64)


def thin_rows(track: ArrayLike, most: int, keep: ArrayLike | None = None) -> IntArray:
    """Rows that draw the same lines with fewer corners.

    The first and last row of every track stay, and those of ``keep``; of the others every k-th, with the smallest k
    that leaves at most ``most`` of them.

    Args:
        track: shape (n,), rows sorted by track.
        most: rows to aim at, >= 1.
        keep: shape (n,), rows that must stay.

    Returns:
        Row numbers in order.
    """
    t = np.asarray(track, np.int64)
    n = len(t)
    if n <= most:
        return np.arange(n, dtype=np.int64)
    ends = np.ones(n, np.bool_)
    ends[1:-1] = (t[1:-1] != t[:-2]) | (t[1:-1] != t[2:])
    must = ends if keep is None else ends | np.asarray(keep, np.bool_)
    step = math.ceil(n / max(1, most))
    chosen = must | (np.arange(n) % step == 0)
    return np.flatnonzero(chosen).astype(np.int64)


def pick_rows(
    frame: ArrayLike, track: ArrayLike, cursor: int, reach: int, always: ArrayLike, most: int
) -> tuple[IntArray, int]:
    """Rows that become tangible: those within ``reach`` frames of the cursor, and those of the tracks in ``always``.

    If they are more than ``most``, tracks far from the cursor lose theirs first, but those in ``always`` lose theirs
    last.

    Args:
        frame: shape (n,).
        track: shape (n,), positions of tracks.
        cursor: ordinal of the present frame.
        reach: frames to either side, >= 0.
        always: shape (t,), whether a track shows whatever the cursor.
        most: rows at most, >= 1.

    Returns:
        Row numbers in order, and how many rows had to be left out.
    """
    f, t = np.asarray(frame, np.int64), np.asarray(track, np.int64)
    held = np.asarray(always, np.bool_)[t] if len(t) else np.zeros(0, np.bool_)
    distance = np.abs(f - cursor)
    rows = np.flatnonzero((distance <= reach) | held)
    left_out = max(0, len(rows) - most)
    if left_out:
        order = np.lexsort((distance[rows], ~held[rows]))
        rows = np.sort(rows[order[:most]])
    return rows.astype(np.int64), left_out


def bead_places(
    volume: Volume, boxes: ArrayLike, seconds: ArrayLike, interval: float, least: float
) -> tuple[FloatArray, FloatArray]:
    """Position and size of one block a row: as wide and high as the sign's box, as deep as its frame.

    Args:
        volume: where they stand.
        boxes: shape (n, 4), px.
        seconds: shape (n,).
        interval: duration of a frame, s.
        least: least width and height, scene units, so that a small sign can be hit.

    Returns:
        Centres, shape (n, 3), and sizes, shape (n, 3), both in scene units.
    """
    table = np.asarray(boxes, np.float64).reshape(-1, 4)
    wide = np.maximum((table[:, 2] - table[:, 0]) * volume.unit, least)
    high = np.maximum((table[:, 3] - table[:, 1]) * volume.unit, least)
    deep = max(interval / max(volume.last - volume.first, 1e-6) * volume.depth, 1e-3)
    return volume.places(table, seconds), np.stack([wide, np.full(len(table), deep), high], axis=1)


def nice_step(span: float, most: int) -> float:
    """A round step that divides ``span`` seconds into at most ``most`` parts.

    Steps are 1, 2 and 5 times powers of ten; above 5 s those of clocks: 10, 15, 30 s, 1, 2, 5, 10, 15, 30 min, 1 h.
    """
    least = span / max(1, most)
    if least <= 0 or not math.isfinite(least):
        return 1.0
    if least > 5:
        for step in (10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1800.0, 3600.0):
            if step >= least:
                return step
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= least * (1 - 1e-9))


# ------------------------------------------------------------------------------------------------------ the prior


def surface(table: ArrayLike, width: float, depth: float, height: float, every: int = 2) -> tuple[FloatArray, IntArray]:
    """A height field as a mesh over a floor whose middle is the origin.

    Args:
        table: shape (r, c), heights in [0, 1], rows along the picture's y (0: its upper edge, which lies far away).
        width: of the floor along x, scene units.
        depth: of the floor along y.
        height: of the value 1.
        every: take each n-th node.

    Returns:
        Vertices (v, 3), and faces (f, 3) that face upwards.
    """
    values = np.asarray(table, np.float64)
    rows, columns = _nodes(values.shape[0], every), _nodes(values.shape[1], every)
    x = ((columns + 0.5) / values.shape[1] - 0.5) * width
    y = (0.5 - (rows + 0.5) / values.shape[0]) * depth
    grid_x, grid_y = np.meshgrid(x, y)
    vertices = np.stack([grid_x, grid_y, values[np.ix_(rows, columns)] * height], axis=-1).reshape(-1, 3)
    r, c = len(rows), len(columns)
    corner = (np.arange(r - 1)[:, None] * c + np.arange(c - 1)[None]).ravel()
    # the next row lies nearer to the viewer: this order of corners turns the face upwards
    lower = np.stack([corner, corner + c, corner + 1], axis=1)
    upper = np.stack([corner + 1, corner + c, corner + c + 1], axis=1)
    return vertices, np.concatenate([lower, upper]).astype(np.int64)


def drape(
    table: ArrayLike, width: float, depth: float, height: float, every: int = 8, lift: float = 0.0, bends: int = 2
) -> tuple[FloatArray, FloatArray]:
    """Lines along the rows and columns of a height field, as over a cloth.

    Args:
        table: as for :func:`surface`.
        width: of the floor along x.
        depth: of the floor along y.
        height: of the value 1.
        every: a line each n-th node.
        lift: how far above the surface, scene units.
        bends: a line bends at each n-th node.

    Returns:
        Segments (m, 2, 3), and the value at each of their ends (m, 2).
    """
    values = np.asarray(table, np.float64)
    r, c = values.shape
    x = ((np.arange(c) + 0.5) / c - 0.5) * width
    y = (0.5 - (np.arange(r) + 0.5) / r) * depth
    points = np.stack([*np.meshgrid(x, y), values * height + lift], axis=-1)
    lines, heights = [], []
    for cloth, level in ((points, values), (points.transpose(1, 0, 2), values.T)):
        chosen = np.ix_(_nodes(cloth.shape[0], every), _nodes(cloth.shape[1], bends))
        corners, at = cloth[chosen], level[chosen]
        lines.append(np.stack([corners[:, :-1], corners[:, 1:]], axis=2).reshape(-1, 2, 3))
        heights.append(np.stack([at[:, :-1], at[:, 1:]], axis=2).reshape(-1, 2))
    return np.concatenate(lines), np.concatenate(heights)


def _nodes(count: int, every: int) -> IntArray:
    """Each n-th number below ``count``, and the last one."""
    return np.unique(np.append(np.arange(0, count, max(1, every)), count - 1)).astype(np.int64)


# ----------------------------------------------------------------------------------------------- the metric drive


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera whose axis meets the middle of the picture: nothing else is known about the real one.

    Attributes:
        width: of the picture, px.
        height: of the picture, px.
        focal: focal length, px.
    """

    width: int
    height: int
    focal: float

    @property
    def vertical_view(self) -> float:
        """Vertical field of view, rad."""
        return 2 * math.atan(self.height / 2 / self.focal)


def focal_length(width: int, view: float) -> float:
    """Focal length in px of a camera that sees ``view`` degrees across ``width`` px; 0 < view < 180."""
    return width / 2 / math.tan(math.radians(view) / 2)


def metric_positions(camera: Camera, boxes: ArrayLike, size: ArrayLike) -> FloatArray:
    """Where signs of known size stand, by similar triangles: ``Z = f D / w``.

    Args:
        camera: what saw them.
        boxes: shape (n, 4), px; a box without width is taken as one pixel wide.
        size: shape (n,) or one number: real width ``D``, m.

    Returns:
        Shape (n, 3), metres from the camera: to the right, ahead (``Z``), up.
    """
    table = np.asarray(boxes, np.float64).reshape(-1, 4)
    wide = np.maximum(table[:, 2] - table[:, 0], 1.0)
    ahead = camera.focal * np.asarray(size, np.float64) / wide
    right = ((table[:, 0] + table[:, 2]) / 2 - camera.width / 2) * ahead / camera.focal
    up = (camera.height / 2 - (table[:, 1] + table[:, 3]) / 2) * ahead / camera.focal
    return np.stack([right, ahead, up], axis=1)


def frustum_scale(camera: Camera, distance: float) -> float:
    """The ``scale`` that makes viser draw a camera's picture at ``distance``: it normalises frusta to one volume."""
    y = camera.height / 2 / camera.focal
    x = camera.width / 2 / camera.focal
    return float(distance * np.cbrt(x * y / 3.0))
