"""OpenCV's single-object trackers, as far as the installed wheel has them."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from benchmarks.peers.detection_gaps import Follower
from benchmarks.peers.multi_object_trackers import Missing
from tsr_engine.records import FloatArray, Picture

WITH_WEIGHTS = ("Vit", "Nano", "DaSiamRPN")
"""Trackers that are networks; OpenCV's wheels hold their code without the weights."""

GENERIC = ("MIL", "KCF", "CSRT", *WITH_WEIGHTS)
"""Names of the trackers, as OpenCV calls them after ``Tracker``."""


class OpenCvTracker:
    """One of OpenCV's trackers; its interface has boxes in whole px."""

    def __init__(self, tracker: cv2.Tracker) -> None:
        self._tracker = tracker

    def start(self, picture: Picture, box: FloatArray) -> None:
        """Begin with a box, shape (4,)."""
        x1, y1, x2, y2 = (round(float(v)) for v in box)
        height, width = picture.shape[:2]
        # OpenCV refuses a rectangle that reaches beyond the picture.
        x1, y1 = min(max(x1, 0), width - 2), min(max(y1, 0), height - 2)
        self._tracker.init(picture, (x1, y1, max(2, min(x2, width) - x1), max(2, min(y2, height) - y1)))

    def step(self, picture: Picture) -> FloatArray | None:
        """The box in the next picture; None: lost."""
        found, (x, y, w, h) = self._tracker.update(picture)
        return np.array([x, y, x + w, y + h], dtype=np.float64) if found else None


def maker(name: str) -> Callable[[], Follower]:
    """A function that makes a new tracker.

    Raises:
        Missing: the wheel has no tracker of that name, or lacks the weights of its network.
    """
    places = (cv2, getattr(cv2, "legacy", None))
    create = next((found for place in places if (found := getattr(place, f"Tracker{name}_create", None))), None)
    if create is None:
        raise Missing(
            f"the installed OpenCV {cv2.__version__} has no Tracker{name} "
            "(the wheel opencv-contrib-python-headless has more trackers)."
        )
    if name in WITH_WEIGHTS:
        raise Missing(f"Tracker{name} is a network, and OpenCV's wheel holds no weights for it.")
    return lambda: OpenCvTracker(create())
