"""Places of a scene that may show a sign: detections of low score, and blobs in the colours of signs."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from tsr_engine.detection.acf import AcfDetector
from tsr_engine.geometry.boxes import iou
from tsr_engine.params import Params
from tsr_engine.pipeline import load_detector
from tsr_engine.records import FloatArray, Picture

SAME_PLACE_IOU: Final = 0.5
"""IoU above which two boxes show the same place."""
MIN_SIDE_PX, MAX_SIDE_PX = 12, 230
"""Sides of a blob, px."""
SMOOTH: Final = 0.85
"""Least area of a blob as a share of its convex hull's."""
ROWS: Final = (80, 680)
"""Range of rows of a scene for the centres of signs."""
_COLOURS: Final = {
    "blue": ([((95, 90, 25), (132, 255, 255))], 0.45, (0.4, 2.6)),
    "yellow": ([((14, 110, 80), (33, 255, 255))], 0.45, (0.4, 2.6)),
    "red": ([((0, 90, 40), (8, 255, 255)), ((170, 90, 40), (179, 255, 255))], 0.35, (0.7, 1.4)),
}
"""Ranges of hue, saturation and value (OpenCV's), least filled share of a blob's box, range of width / height."""


def sensitive_detector() -> AcfDetector:
    """The shipped detector, with a lower score threshold and smaller signs."""
    settings = [("second_core", False), ("keep_score", -7.5), ("min_width", 13)]
    detector = load_detector(Params().with_settings(settings))
    assert isinstance(detector, AcfDetector)
    return detector


def blobs(picture: Picture) -> FloatArray:
    """Boxes (n, 4) of blue, yellow and red blobs with the size and the smooth outline of a sign."""
    hsv = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)
    found = []
    for ranges, filled, (narrow, wide) in _COLOURS.values():
        mask = np.zeros(hsv.shape[:2], np.uint8)
        for low, high in ranges:
            mask |= cv2.inRange(hsv, np.array(low), np.array(high))
        mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
        outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        for outline in outlines:
            x, y, w, h = cv2.boundingRect(outline)
            sized = min(w, h) >= MIN_SIDE_PX and max(w, h) <= MAX_SIDE_PX and ROWS[0] <= y + h / 2 <= ROWS[1]
            if not (sized and narrow <= w / h <= wide):
                continue
            area = cv2.contourArea(outline)
            if area >= filled * w * h and area >= SMOOTH * cv2.contourArea(cv2.convexHull(outline)):
                found.append((x, y, x + w, y + h))
    return np.array(found, dtype=np.float64).reshape(-1, 4)


def candidates_of(picture: Picture, known: FloatArray, detector: AcfDetector) -> FloatArray:
    """Boxes (n, 4) of candidates without known signs and without duplicates."""
    seen = [*known]
    kept = []
    for box in (*detector.detect(picture).boxes, *blobs(picture)):
        if not seen or iou(box, np.array(seen)).max() < SAME_PLACE_IOU:
            kept.append(box)
            seen.append(box)
    return np.array(kept, dtype=np.float64).reshape(-1, 4)
