"""Draws lines, dashes, panels and text in sizes proportional to the picture's height."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import cv2
import numpy as np

from tsr_engine.records import FloatArray, Picture

Colour = tuple[int, int, int]
"""Blue, green, red, 0..255."""
Rectangle = tuple[float, float, float, float]

_PANEL_COLOUR: Colour = (24, 22, 20)
_PANEL_OPACITY = 0.72
_WHITE: Colour = (255, 255, 255)
_FAINT: Colour = (205, 205, 205)
_REGULAR_WEIGHT, _SEMIBOLD_WEIGHT = 400, 600


class Canvas:
    """Draws on one picture.

    Attributes:
        picture: the picture, changed in place.
        scale: 1.0 for a picture 720 px high; text and lines grow with it.
    """

    def __init__(self, picture: Picture, scale: float) -> None:
        self.picture = picture
        self.scale = scale
        self._font = cv2.FontFace("sans")
        self._occupied: list[Rectangle] = []

    def px(self, length: float) -> int:
        """Convert a length at 720 px height to px of this picture, at least 1."""
        return max(1, round(length * self.scale))

    def draw_box(self, box: FloatArray, colour: Colour, weight: int) -> None:
        """Draw a box's outline, ``weight`` px thick at 720 px, over a dark edge that keeps it visible on bright sky."""
        thickness = self.px(weight)
        x1, y1, x2, y2 = (round(float(v)) for v in box)
        # Whole pixels without anti-aliasing keep upright lines sharp.
        if weight > 1:
            cv2.rectangle(self.picture, (x1, y1), (x2 - 1, y2 - 1), _PANEL_COLOUR, thickness + 2)
        cv2.rectangle(self.picture, (x1, y1), (x2 - 1, y2 - 1), colour, thickness)

    def draw_dashed_box(self, box: FloatArray, colour: Colour, dash: float, gap: float) -> None:
        """Draw a box's outline in dashes of ``dash`` px, ``gap`` px apart (at 720 px)."""
        x1, y1, x2, y2 = (round(float(v)) for v in box)
        for start, end in pairwise([(x1, y1), (x2, y1), (x2, y2), (x1, y2), (x1, y1)]):
            self.draw_dashed_line((*start, *end), colour, dash, gap)

    def draw_dashed_line(self, ends: tuple[int, int, int, int], colour: Colour, dash: float, gap: float) -> None:
        """Draw a dashed line from ``(x1, y1)`` to ``(x2, y2)``."""
        start, end = np.array(ends[:2], dtype=float), np.array(ends[2:], dtype=float)
        length = float(np.hypot(*(end - start)))
        if not length:
            return
        along = (end - start) / length
        for offset in np.arange(0, length, self.px(dash) + self.px(gap)):
            a = start + along * offset
            b = start + along * min(length, offset + self.px(dash))
            cv2.line(
                self.picture, tuple(int(v) for v in a.round()), tuple(int(v) for v in b.round()), colour, self.px(1.4)
            )

    def draw_panel(self, area: Rectangle) -> None:
        """Draw a dark translucent rectangle behind text, clipped to the picture; labels avoid it."""
        height, width = self.picture.shape[:2]
        x1, y1, x2, y2 = (round(v) for v in area)
        x1, y1, x2, y2 = max(0, x1), max(0, y1), min(width, x2), min(height, y2)
        if x1 < x2 and y1 < y2:
            patch = self.picture[y1:y2, x1:x2]
            panel = np.full_like(patch, _PANEL_COLOUR)
            self.picture[y1:y2, x1:x2] = cv2.addWeighted(patch, 1 - _PANEL_OPACITY, panel, _PANEL_OPACITY, 0)

    def text_size(self, text: str, size: float, weight: int = _REGULAR_WEIGHT) -> tuple[int, int]:
        """Width and cap height of a line of text in px."""
        _, _, width, _ = cv2.getTextSize((0, 0), text, (0, 0), self._font, self.px(size), weight)
        return int(width), round(0.72 * self.px(size))

    def draw_text(
        self, text: str, origin: tuple[int, int], size: float, colour: Colour, weight: int = _REGULAR_WEIGHT
    ) -> None:
        """Draw a line of text; ``origin`` is the left end of its base line."""
        cv2.putText(self.picture, text, origin, colour, self._font, self.px(size), weight)

    def draw_note(self, box: FloatArray, text: str, colour: Colour) -> None:
        """Draw a small figure under a box."""
        x, y = round(float(box[0])), round(float(box[3])) + self.px(12)
        if self._is_inside((x, y - self.px(12), x + self.text_size(text, 11)[0], y)):
            self.draw_text(text, (x, y), 11, colour)

    def reserve(self, areas: Sequence[Rectangle]) -> None:
        """Set areas that labels must not cover."""
        self._occupied.extend(areas)

    def draw_label(
        self, box: FloatArray, lines: tuple[str, str], colour: Colour, thumbnail: Picture | None = None
    ) -> None:
        """Draw a headline and a smaller second line on a panel beside a box, clear of other boxes and labels.

        Args:
            box: the labelled box.
            lines: headline and second line.
            colour: colour of the bar that connects label and box.
            thumbnail: picture to enlarge at the panel's left end, such as the sign.
        """
        head, body = self.text_size(lines[0], 15, _SEMIBOLD_WEIGHT), self.text_size(lines[1], 12)
        pad, bar_width, leading = self.px(6), self.px(4), self.px(7)
        height = 2 * pad + head[1] + leading + body[1]
        inset = height if thumbnail is not None and thumbnail.size else 0
        width = bar_width + inset + 2 * pad + max(head[0], body[0])
        x, y = self._find_label_position(box, width, height)
        self.draw_panel((x, y, x + width, y + height))
        cv2.rectangle(self.picture, (x, y), (x + bar_width - 1, y + height - 1), colour, cv2.FILLED)
        left = x + bar_width + inset + pad
        if thumbnail is not None and inset:
            margin = self.px(3)  # a margin, so that the enlarged picture does not look like part of the scene
            side = inset - 2 * margin
            target = self.picture[
                y + margin : y + margin + side, x + bar_width + margin : x + bar_width + margin + side
            ]
            if target.size:
                target[:] = cv2.resize(thumbnail, (side, side), interpolation=cv2.INTER_CUBIC)[
                    : len(target), : target.shape[1]
                ]
        self.draw_text(lines[0], (left, y + pad + head[1]), 15, _WHITE, _SEMIBOLD_WEIGHT)
        self.draw_text(lines[1], (left, y + pad + head[1] + leading + body[1]), 12, _FAINT)
        self._occupied.append((x, y, x + width, y + height))

    def _find_label_position(self, box: FloatArray, width: int, height: int) -> tuple[int, int]:
        """The first free place around the box; if none is free, the place above it, moved into the picture."""
        for x, y in self._label_positions(box, width, height):
            area = (x, y, x + width, y + height)
            if self._is_inside(area) and not any(_overlap(area, other) for other in self._occupied):
                return x, y
        x, y = next(self._label_positions(box, width, height))
        rows, columns = self.picture.shape[:2]
        return max(0, min(x, columns - width)), max(0, min(y, rows - height))

    def _label_positions(self, box: FloatArray, width: int, height: int) -> Iterator[tuple[int, int]]:
        x1, y1, x2, y2 = (round(float(v)) for v in box)
        gap = self.px(6)
        for step in range(4):
            distance = gap + step * (height + gap)
            yield x1, y1 - distance - height
            yield x2 - width, y1 - distance - height
            yield x1, y2 + distance
            yield x2 - width, y2 + distance
            yield x2 + gap, y1 + step * (height + gap)
            yield x1 - gap - width, y1 + step * (height + gap)

    def _is_inside(self, area: Rectangle) -> bool:
        height, width = self.picture.shape[:2]
        return area[0] >= 0 and area[1] >= 0 and area[2] <= width and area[3] <= height


def _overlap(a: Rectangle, b: Rectangle) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
