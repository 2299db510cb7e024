"""The picture in linear light, painted from far to near, and the visible part of each sign."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Patch = NDArray[np.float32]


@dataclass
class SignVisibility:
    """The visible part of a sign's face while nearer objects are painted over it.

    Attributes:
        track_id: The sign.
        x: Left column of `left`.
        y: Top row of `left`.
        left: Visible coverage per pixel, 0 to 1.
        area: Whole projected area, pixels, inside the picture or not.
    """

    track_id: int
    x: int
    y: int
    left: Patch
    area: float

    def visibility(self) -> float:
        """Visible share of the face, 0 to 1."""
        return float(np.clip(self.left.sum() / self.area, 0, 1)) if self.area > 0 else 0.0


def motion_blur_kernel(dx: float, dy: float) -> Patch | None:
    """A line kernel of a length and direction in pixels; None if it would blur less than a pixel."""
    length = float(np.hypot(dx, dy))
    if length < 1.2:
        return None
    n = min(int(np.ceil(length)) | 1, 61)
    scale = min(1.0, n / length)
    kernel = np.zeros((n + 2, n + 2), np.uint8)
    c, s = (n + 1) / 2, 16
    a = (round((c - dx * scale / 2) * s), round((c - dy * scale / 2) * s))
    b = (round((c + dx * scale / 2) * s), round((c + dy * scale / 2) * s))
    cv2.line(kernel, a, b, 255, 1, cv2.LINE_AA, 4)
    out = kernel.astype(np.float32)
    return np.asarray(out / out.sum(), np.float32)


class LinearCanvas:
    """A linear-light picture that is painted from far to near.

    Attributes:
        image: (height, width, 3) float32, linear BGR.
        watched: The signs painted so far.
    """

    def __init__(self, width: int, height: int) -> None:
        self.image = np.zeros((height, width, 3), np.float32)
        self.watched: list[SignVisibility] = []

    def blend(self, patch: Patch, x: int, y: int, blur: Patch | None = None) -> None:
        """Paint a premultiplied BGRA patch with its upper left pixel at (x, y); signs below it lose coverage."""
        if blur is not None:
            r = blur.shape[0] // 2
            patch = cv2.copyMakeBorder(patch, r, r, r, r, cv2.BORDER_CONSTANT, value=(0, 0, 0, 0))
            patch = cv2.filter2D(patch, -1, blur)
            x, y = x - r, y - r
        height, width = self.image.shape[:2]
        x0, y0, x1, y1 = max(x, 0), max(y, 0), min(x + patch.shape[1], width), min(y + patch.shape[0], height)
        if x0 >= x1 or y0 >= y1:
            return
        part = patch[y0 - y : y1 - y, x0 - x : x1 - x]
        part = np.ascontiguousarray(part)
        through = 1 - part[..., 3]
        region = self.image[y0:y1, x0:x1]
        region[:] = cv2.add(
            cv2.multiply(region, cv2.merge([through, through, through])), cv2.cvtColor(part, cv2.COLOR_BGRA2BGR)
        )
        for seen in self.watched:
            h, w = seen.left.shape
            a0, b0, a1, b1 = max(x0, seen.x), max(y0, seen.y), min(x1, seen.x + w), min(y1, seen.y + h)
            if a0 < a1 and b0 < b1:
                seen.left[b0 - seen.y : b1 - seen.y, a0 - seen.x : a1 - seen.x] *= through[
                    b0 - y0 : b1 - y0, a0 - x0 : a1 - x0
                ]

    def watch(self, track_id: int, coverage: Patch, x: int, y: int, area: float) -> None:
        """Track the visible part of a sign that was just painted, given its coverage patch and place."""
        height, width = self.image.shape[:2]
        kept = coverage.copy()
        rows, columns = np.arange(y, y + kept.shape[0]), np.arange(x, x + kept.shape[1])
        kept[(rows < 0) | (rows >= height)] = 0
        kept[:, (columns < 0) | (columns >= width)] = 0
        self.watched.append(SignVisibility(track_id, x, y, kept, area))
