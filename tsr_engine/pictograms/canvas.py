"""An anti-aliased vector canvas: polygons, strokes and discs in unit coordinates, as pixels and as SVG."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.pictograms.paths import Points, path

Colour = tuple[int, int, int]

_SHIFT = 6
_FACTOR, _LEAST = 4, 640


def arc(cx: float, cy: float, rx: float, ry: float, start: float, end: float, n: int = 24) -> Points:
    """Points on an ellipse.

    Args:
        cx: Centre, right.
        cy: Centre, down.
        rx: Half width.
        ry: Half height.
        start: First angle in degrees, clockwise from the right (y points down).
        end: Last angle in degrees.
        n: Number of points.

    Returns:
        (n, 2) array.
    """
    angle = np.radians(np.linspace(start, end, n))
    return np.stack([cx + rx * np.cos(angle), cy + ry * np.sin(angle)], axis=1)


def regular(n: int, radius: float, first: float) -> Points:
    """A regular polygon of `n` corners; the first is at `first` degrees (clockwise from the right)."""
    return arc(0, 0, radius, radius, first, first + 360 * (n - 1) / n, n)


def rounded(corners: Points, radius: float, n: int = 8) -> Points:
    """A convex polygon with each corner replaced by a circular arc.

    Args:
        corners: (k, 2) corners in order.
        radius: Radius of the arcs in the same unit.
        n: Points an arc.

    Returns:
        (k * n, 2) outline.
    """
    out = []
    for before, at, after in zip(np.roll(corners, 1, 0), corners, np.roll(corners, -1, 0), strict=True):
        u, v = before - at, after - at
        u, v = u / np.hypot(*u), v / np.hypot(*v)
        half = np.arccos(np.clip((u * v).sum(), -1, 1)) / 2
        middle = (u + v) / np.hypot(*(u + v))
        centre = at + middle * radius / np.sin(half)
        first, last = at + u * radius / np.tan(half) - centre, at + v * radius / np.tan(half) - centre
        a0, a1 = np.arctan2(first[1], first[0]), np.arctan2(last[1], last[0])
        turn = (a1 - a0 + np.pi) % (2 * np.pi) - np.pi
        angle = a0 + turn * np.linspace(0, 1, n)
        out.append(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    return np.concatenate(out)


def turned(points: Points, degrees: float) -> Points:
    """Points rotated clockwise (y down) about the origin."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x, y = points[:, 0], points[:, 1]
    return np.stack([x * c - y * s, x * s + y * c], axis=1)


def thick(points: Points, width: float) -> list[Points]:
    """A polyline of a given width as polygons: one quadrilateral per segment and a disc at each joint."""
    polygons = []
    for a, b in itertools.pairwise(points):
        along = b - a
        length = np.hypot(*along)
        if length == 0:
            continue
        side = np.array([-along[1], along[0]]) / length * width / 2
        polygons.append(np.stack([a + side, b + side, b - side, a - side]))
    polygons.extend(arc(x, y, width / 2, width / 2, 0, 360, 20) for x, y in points[1:-1])
    return polygons


def as_points(points: Points | str) -> Points:
    """Points as they are, or those of the text of a `path`; (n, 2)."""
    return path(points) if isinstance(points, str) else np.asarray(points, np.float64)


class Canvas:
    """A drawing over [-1, 1] x [-1, 1] (y down): polygons in the order in which they are painted.

    It stores vectors, so one drawing gives pictures of any size and an SVG.
    """

    def __init__(self) -> None:
        self._outlines: list[Points] = []
        self._fills: list[tuple[Points, Colour]] = []

    def outline(self, points: Points) -> None:
        """Make the inside of a polygon opaque: the silhouette."""
        self._outlines.append(np.asarray(points, np.float64))

    def fill(self, points: Points | str, colour: Colour) -> None:
        """Fill a polygon, (n, 2) points or the text of a `path`, with an sRGB colour (r, g, b)."""
        self._fills.append((as_points(points), colour))

    def stroke(self, points: Points | str, width: float, colour: Colour, *, caps: bool = False) -> None:
        """Draw a polyline, points or the text of a `path`, of a given width; with `caps` its ends are round."""
        points = as_points(points)
        for polygon in thick(points, width):
            self.fill(polygon, colour)
        if caps:
            for x, y in (points[0], points[-1]):
                self.disc(x, y, width / 2, colour)

    def placed(
        self,
        scale: float,
        dx: float = 0.0,
        dy: float = 0.0,
        *,
        mirror: bool = False,
        turn: float = 0.0,
        colours: Mapping[Colour, Colour] | None = None,
    ) -> Canvas:
        """A canvas with its own axes that paints on this one.

        Args:
            scale: Length of its unit on this canvas.
            dx: Its origin on this canvas, to the right.
            dy: Its origin on this canvas, downwards.
            mirror: Whether its x axis points to the left.
            turn: Clockwise rotation, degrees.
            colours: Colours and their replacements.

        Returns:
            A canvas to draw on; its silhouette is ignored.
        """
        return _Placed(self, scale, (dx, dy), mirror, turn, colours or {})

    def halves(self) -> tuple[Canvas, Canvas]:
        """This canvas mirrored left to right, and as it is: for symmetrical drawings."""
        return self.placed(1, mirror=True), self.placed(1)

    def disc(self, x: float, y: float, radius: float, colour: Colour) -> None:
        """Fill a disc."""
        self.fill(arc(x, y, radius, radius, 0, 360, 72), colour)

    def polygons(self) -> list[Points]:
        """All filled polygons, in the order in which they are painted."""
        return [points for points, _ in self._fills]

    def picture(self, size: int) -> NDArray[np.uint8]:
        """The drawing as pixels.

        It is drawn `_FACTOR` times larger, and at least `_LEAST` pixels wide, then reduced by area: anti-aliased
        edges grow by a fraction of a drawn pixel.

        Args:
            size: Side of the picture in pixels.

        Returns:
            (size, size, 4) picture, BGRA, sRGB, straight alpha.

        Raises:
            ValueError: The size is below 1.
        """
        if size < 1:
            raise ValueError(f"size must be at least 1 pixel, got {size}: ask for the side of the picture.")
        n = size * max(_FACTOR, -(-_LEAST // size))
        bgr = np.zeros((n, n, 3), np.uint8)
        for points, colour in self._fills:
            cv2.fillPoly(bgr, [_fixed(points, n)], colour[::-1], cv2.LINE_AA, _SHIFT)
        alpha = np.zeros((n, n), np.uint8)
        for points in self._outlines:
            cv2.fillPoly(alpha, [_fixed(points, n)], 255, cv2.LINE_AA, _SHIFT)
        bgr = cv2.resize(bgr, (size, size), interpolation=cv2.INTER_AREA)
        alpha = cv2.resize(alpha, (size, size), interpolation=cv2.INTER_AREA)
        return np.dstack([bgr, alpha])

    def svg(self) -> str:
        """The drawing as an SVG document, transparent around the silhouette."""
        clip = "".join(_path(points) for points in self._outlines)
        groups = [
            f'<g fill="#{colour[0]:02x}{colour[1]:02x}{colour[2]:02x}">'
            + "".join(f'<path d="{_path(points)}"/>' for points, _ in group)
            + "</g>"
            for colour, group in itertools.groupby(self._fills, key=lambda fill: fill[1])
        ]
        return (
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="-1000 -1000 2000 2000" fill-rule="evenodd">'
            f'<clipPath id="s"><path d="{clip}"/></clipPath><g clip-path="url(#s)">{"".join(groups)}</g></svg>\n'
        )


class _Placed(Canvas):
    """A canvas whose polygons land on another one."""

    def __init__(
        self,
        onto: Canvas,
        scale: float,
        origin: tuple[float, float],
        mirror: bool,
        turn: float,
        colours: Mapping[Colour, Colour],
    ) -> None:
        super().__init__()
        self._onto, self._origin, self._colours = onto, np.array(origin), colours
        self._scale = np.array([-scale if mirror else scale, scale])
        self._turn = turn

    def fill(self, points: Points | str, colour: Colour) -> None:
        scaled = as_points(points) * self._scale
        self._onto.fill(turned(scaled, self._turn) + self._origin, self._colours.get(colour, colour))


def _fixed(points: Points, n: int) -> NDArray[np.int32]:
    """Points in pixels of a picture `n` wide, as OpenCV's fixed-point numbers."""
    pixels = (points + 1) * n / 2 - 0.5
    return np.round(pixels * (1 << _SHIFT)).astype(np.int32)


def _path(points: Points) -> str:
    """A polygon as data of an SVG path, in thousandths."""
    return "M" + "L".join(f"{x},{y}" for x, y in np.round(points * 1000).astype(int).tolist()) + "Z"
