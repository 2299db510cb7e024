"""Geometry of the three scenes, as pure functions.

World axes are those of viser: right-handed, z up, in units of the scene. The picture plane stands upright, so that
``x`` of the world is ``x`` of the picture, ``z`` is up, and ``y`` points away from the viewer: time in the volume,
distance in the metric drive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

UPRIGHT: Final = (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)
"""Quaternion (w, x, y, z) that turns viser's picture axes (right, down, forward) into an upright picture."""
FLAT: Final = (0.0, 1.0, 0.0, 0.0)
"""Quaternion that lays such a picture on the floor, face up, its upper edge away from the viewer."""


@dataclass(frozen=True, slots=True)
class Volume:
    """The block of a part of the video: picture plane and time.

    Attributes:
        width: width of the picture, px.
        height: height of the picture, px.
        first: time of the near face, s.
        last: time of the far face, s; not before ``first``.
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
        """Scene units per pixel."""
        return self.size / self.height

    @property
    def half_width(self) -> float:
        """Half the width of the block, scene units."""
        return self.width * self.unit / 2

    def along(self, seconds: ArrayLike) -> FloatArray:
        """Convert times, s, to ``y``, shape as given; the middle of the block is at 0."""
        span = max(self.last - self.first, 1e-6)
        return np.asarray((np.asarray(seconds, np.float64) - self.first) / span * self.depth - self.depth / 2)

    def positions(self, boxes: ArrayLike, seconds: ArrayLike) -> FloatArray:
        """World positions, shape (n, 3), of the centres of boxes, shape (n, 4), px, at times of shape (n,), s."""
        table = np.asarray(boxes, np.float64).reshape(-1, 4)
        x = ((table[:, 0] + table[:, 2]) / 2 - self.width / 2) * self.unit
        z = (self.height / 2 - (table[:, 1] + table[:, 3]) / 2) * self.unit
        return np.stack([x, np.broadcast_to(self.along(seconds), x.shape), z], axis=1)


def polyline_ids(track: ArrayLike, frame: ArrayLike, gap: int = 12) -> IntArray:
    """Number the pieces of tracks that are drawn as one line: a line ends where the track is not seen for long.

    Args:
        track: shape (n,), rows sorted by track, then frame.
        frame: shape (n,).
        gap: frames that a line may bridge, >= 1.

    Returns:
        Number of each row's piece, shape (n,), ascending from 0.
    """
    t, f = np.asarray(track, np.int64), np.asarray(frame, np.int64)
    if not len(t):
        return np.zeros(0, np.int64)
    breaks = (np.diff(t) != 0) | (np.diff(f) > gap)
    return np.concatenate([[0], np.cumsum(breaks)]).astype(np.int64)


def simplify_lines(
    strand: ArrayLike, points: ArrayLike, tolerance: float, max_rows: int, keep: ArrayLike | None = None
) -> IntArray:
    """Choose rows that draw the same lines with few corners.

    The ends of every strand stay. Of the other rows, those stay from which the simplified line would deviate by more
    than ``tolerance`` (Ramer 1972, Douglas and Peucker 1973, all strands at once), largest deviation first.

    Args:
        strand: shape (n,), ascending.
        points: shape (n, 3).
        tolerance: scene units, >= 0.
        max_rows: maximum number of rows; ends stay even if they are more.
        keep: shape (n,), rows that stay regardless of the tolerance if ``max_rows`` allows it.

    Returns:
        Row numbers in order.
    """
    s, p = np.asarray(strand, np.int64), np.asarray(points, np.float64).reshape(-1, 3)
    n = len(s)
    if not n:
        return np.zeros(0, np.int64)
    kept = np.ones(n, np.bool_)
    kept[1:-1] = (s[1:-1] != s[:-2]) | (s[1:-1] != s[2:])
    optional = np.flatnonzero(np.zeros(n, np.bool_) if keep is None else np.asarray(keep, np.bool_) & ~kept)
    free = max(0, max_rows - int(kept.sum()))
    # too many to keep all: choose evenly spread ones
    kept[optional[:: max(1, -(-len(optional) // free))] if free else optional[:0]] = True
    while (free := max_rows - int(kept.sum())) > 0:
        ends = np.flatnonzero(kept)
        distance = _distances_from_line(p, ends)
        worst = np.maximum.reduceat(distance, ends)
        # the row with the largest deviation: the first one in each span
        farthest = np.flatnonzero((distance == np.repeat(worst, np.diff(np.append(ends, n)))) & (distance > tolerance))
        if not len(farthest):
            break
        _, first = np.unique(np.searchsorted(ends, farthest, side="right"), return_index=True)
        farthest = farthest[first]
        kept[farthest[np.argsort(-distance[farthest], kind="stable")[:free]]] = True
    return np.flatnonzero(kept).astype(np.int64)


def _distances_from_line(points: FloatArray, ends: IntArray) -> FloatArray:
    """Distance of each point from the line between the ends around it; 0 at the ends, shape (n,)."""
    span = np.searchsorted(ends, np.arange(len(points)), side="right") - 1
    a, b = points[ends[span]], points[ends[np.minimum(span + 1, len(ends) - 1)]]
    direction, offset = b - a, points - a
    length = np.maximum((direction * direction).sum(axis=1), 1e-18)
    along = np.clip((offset * direction).sum(axis=1) / length, 0.0, 1.0)
    distance = np.linalg.norm(offset - along[:, None] * direction, axis=1)
    distance[ends] = 0.0
    return np.asarray(distance)


def pick_rows(
    frame: ArrayLike, track: ArrayLike, cursor: int, max_distance: int, always: ArrayLike, max_rows: int
) -> tuple[IntArray, int]:
    """Choose the rows to draw as blocks: those within ``max_distance`` frames of the cursor, and tracks in ``always``.

    If they are more than ``max_rows``, rows of tracks far from the cursor are dropped first, those of ``always`` last.

    Args:
        frame: shape (n,).
        track: shape (n,), indices of tracks.
        cursor: ordinal of the current frame.
        max_distance: frames to either side, >= 0.
        always: shape (t,), whether a track is drawn regardless of the cursor.
        max_rows: maximum number of rows, >= 1.

    Returns:
        Row numbers in order, and the number of dropped rows.
    """
    f, t = np.asarray(frame, np.int64), np.asarray(track, np.int64)
    is_always = np.asarray(always, np.bool_)[t] if len(t) else np.zeros(0, np.bool_)
    distance = np.abs(f - cursor)
    rows = np.flatnonzero((distance <= max_distance) | is_always)
    left_out = max(0, len(rows) - max_rows)
    if left_out:
        order = np.lexsort((distance[rows], ~is_always[rows]))
        rows = np.sort(rows[order[:max_rows]])
    return rows.astype(np.int64), left_out


def block_positions(
    volume: Volume, boxes: ArrayLike, seconds: ArrayLike, interval: float, min_side: float
) -> tuple[FloatArray, FloatArray]:
    """Position and size of one block per row: as wide and high as the sign's box, as deep as its frame.

    Args:
        volume: the block of the video.
        boxes: shape (n, 4), px.
        seconds: shape (n,), s.
        interval: duration of a frame, s.
        min_side: minimum width and height, scene units, so that a small sign can be clicked.

    Returns:
        Centres, shape (n, 3), and sizes, shape (n, 3), both in scene units.
    """
    table = np.asarray(boxes, np.float64).reshape(-1, 4)
    wide = np.maximum((table[:, 2] - table[:, 0]) * volume.unit, min_side)
    high = np.maximum((table[:, 3] - table[:, 1]) * volume.unit, min_side)
    deep = max(interval / max(volume.last - volume.first, 1e-6) * volume.depth, 1e-3)
    return volume.positions(table, seconds), np.stack([wide, np.full(len(table), deep), high], axis=1)


def nice_step(span: float, max_parts: int) -> float:
    """A round step that divides ``span`` seconds into at most ``max_parts`` parts.

    Steps are 1, 2 and 5 times powers of ten; above 5 s those of clocks: 10, 15, 30 s, 1, 2, 5, 10, 15, 30 min, 1 h.
    """
    min_step = span / max(1, max_parts)
    if min_step <= 0 or not math.isfinite(min_step):
        return 1.0
    if min_step > 5:
        for step in (10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1800.0, 3600.0):
            if step >= min_step:
                return step
    power = 10.0 ** math.floor(math.log10(min_step))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= min_step * (1 - 1e-9))


# ------------------------------------------------------------------------------------------------------ the prior


def surface(table: ArrayLike, width: float, depth: float, height: float, every: int = 2) -> tuple[FloatArray, IntArray]:
    """Convert a height field to a mesh over a floor whose middle is the origin.

    Args:
        table: shape (r, c), heights in [0, 1], rows along the picture's y (0: its upper edge, which is far away).
        width: width of the floor along x, scene units.
        depth: depth of the floor along y, scene units.
        height: height of the value 1, scene units.
        every: use each n-th node.

    Returns:
        Vertices (v, 3), and faces (f, 3) that face upwards.
    """
    values = np.asarray(table, np.float64)
    rows, columns = _every_nth(values.shape[0], every), _every_nth(values.shape[1], every)
    x = ((columns + 0.5) / values.shape[1] - 0.5) * width
    y = (0.5 - (rows + 0.5) / values.shape[0]) * depth
    grid_x, grid_y = np.meshgrid(x, y)
    vertices = np.stack([grid_x, grid_y, values[np.ix_(rows, columns)] * height], axis=-1).reshape(-1, 3)
    r, c = len(rows), len(columns)
    corner = (np.arange(r - 1)[:, None] * c + np.arange(c - 1)[None]).ravel()
    # the next row is nearer to the viewer, so this order of corners turns the face upwards
    lower = np.stack([corner, corner + c, corner + 1], axis=1)
    upper = np.stack([corner + 1, corner + c, corner + c + 1], axis=1)
    return vertices, np.concatenate([lower, upper]).astype(np.int64)


def grid_lines(
    table: ArrayLike, width: float, depth: float, height: float, every: int = 8, lift: float = 0.0, bends: int = 2
) -> tuple[FloatArray, FloatArray]:
    """Lines along the rows and columns of a height field.

    Args:
        table: as for :func:`surface`.
        width: width of the floor along x, scene units.
        depth: depth of the floor along y, scene units.
        height: height of the value 1, scene units.
        every: draw a line at each n-th node.
        lift: distance above the surface, scene units.
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
    for grid, values_on_grid in ((points, values), (points.transpose(1, 0, 2), values.T)):
        chosen = np.ix_(_every_nth(grid.shape[0], every), _every_nth(grid.shape[1], bends))
        corners, at = grid[chosen], values_on_grid[chosen]
        lines.append(np.stack([corners[:, :-1], corners[:, 1:]], axis=2).reshape(-1, 2, 3))
        heights.append(np.stack([at[:, :-1], at[:, 1:]], axis=2).reshape(-1, 2))
    return np.concatenate(lines), np.concatenate(heights)


def _every_nth(count: int, every: int) -> IntArray:
    """Each n-th number below ``count``, and the last one."""
    return np.unique(np.append(np.arange(0, count, max(1, every)), count - 1)).astype(np.int64)


# ----------------------------------------------------------------------------------------------- the metric drive


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera whose axis goes through the middle of the picture; the real camera is unknown.

    Attributes:
        width: width of the picture, px.
        height: height of the picture, px.
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
    """Focal length, px, of a camera with a field of view of ``view`` degrees across ``width`` px; 0 < view < 180."""
    return width / 2 / math.tan(math.radians(view) / 2)


def metric_positions(camera: Camera, boxes: ArrayLike, size: ArrayLike) -> FloatArray:
    """Positions of signs of known size, by similar triangles: ``Z = f D / w``.

    Args:
        camera: the camera.
        boxes: shape (n, 4), px; a box without width counts as one pixel wide.
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
    """The ``scale`` with which viser draws a camera's picture at ``distance``; all its frusta have one volume."""
    y = camera.height / 2 / camera.focal
    x = camera.width / 2 / camera.focal
    return float(distance * np.cbrt(x * y / 3.0))
