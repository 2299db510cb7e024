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
    "corner_rows",
    "drape",
    "focal_length",
    "frustum_scale",
    "metric_positions",
    "nice_step",
    "pick_rows",
    "strands",
    "surface",
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


def strands(track: ArrayLike, frame: ArrayLike, gap: int = 12) -> IntArray:
    """Pieces that lines are drawn through without a break: a track, up to where it is not seen for long.

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


def corner_rows(
    strand: ArrayLike, points: ArrayLike, tolerance: float, most: int, keep: ArrayLike | None = None
) -> IntArray:
    """Rows that draw the same lines with few corners.

    The ends of every strand stay. Of the others, those stay from which the line would otherwise pass by at more than
    ``tolerance`` (Ramer 1972, Douglas and Peucker 1973, all strands at once), the farthest first.

    Args:
        strand: shape (n,), ascending.
        points: shape (n, 3).
        tolerance: scene units, >= 0.
        most: rows to end with at most, though ends stay however many they are.
        keep: shape (n,), rows that stay if ``most`` allows it, whatever the tolerance.

    Returns:
        Row numbers in order.
    """
    s, p = np.asarray(strand, np.int64), np.asarray(points, np.float64).reshape(-1, 3)
    n = len(s)
    if not n:
        return np.zeros(0, np.int64)
    kept = np.ones(n, np.bool_)
    kept[1:-1] = (s[1:-1] != s[:-2]) | (s[1:-1] != s[2:])
    wanted = np.flatnonzero(np.zeros(n, np.bool_) if keep is None else np.asarray(keep, np.bool_) & ~kept)
    room = max(0, most - int(kept.sum()))
    # too many to keep them all: evenly spread
    kept[wanted[:: max(1, -(-len(wanted) // room))] if room else wanted[:0]] = True
    while (room := most - int(kept.sum())) > 0:
        ends = np.flatnonzero(kept)
        off = _off_the_line(p, ends)
        worst = np.maximum.reduceat(off, ends)
        # the row itself: the first one of each span that is as far off
        far = np.flatnonzero((off == np.repeat(worst, np.diff(np.append(ends, n)))) & (off > tolerance))
        if not len(far):
            break
        _, first = np.unique(np.searchsorted(ends, far, side="right"), return_index=True)
        far = far[first]
        kept[far[np.argsort(-off[far], kind="stable")[:room]]] = True
    return np.flatnonzero(kept).astype(np.int64)


def _off_the_line(points: FloatArray, ends: IntArray) -> FloatArray:
    """How far each point is from the line between the ends around it; 0 at the ends, shape (n,)."""
    span = np.searchsorted(ends, np.arange(len(points)), side="right") - 1
    a, b = points[ends[span]], points[ends[np.minimum(span + 1, len(ends) - 1)]]
    way, here = b - a, points - a
    length = np.maximum((way * way).sum(axis=1), 1e-18)
    along = np.clip((here * way).sum(axis=1) / length, 0.0, 1.0)
    off = np.linalg.norm(here - along[:, None] * way, axis=1)
    off[ends] = 0.0
    return np.asarray(off)


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
