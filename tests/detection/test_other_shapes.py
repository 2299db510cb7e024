"""Detections of other shapes that stay beside the known ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tsr_engine.detection.other_shapes import OtherShapes
from tsr_engine.records import Detections, FloatArray


@dataclass
class _Found:
    found: Detections

    def detect(self, picture: Any) -> Detections:
        return self.found


def _detections(boxes: FloatArray, *scores: float) -> Detections:
    return Detections(boxes, *(np.array(scores) for _ in range(3)))


def _remaining_scores(found: Detections, known: Detections) -> list[float]:
    others = object.__new__(OtherShapes)
    others.detector = _Found(found)  # type: ignore[assignment]
    return [float(score) for score in others.detect(np.zeros((9, 9, 3), np.uint8), known).raw_scores]


def test_a_sure_known_box_or_the_better_box_of_two_stays() -> None:
    place = np.array([[10.0, 10, 50, 50]])
    found = _detections(place + 3, 2.0)
    assert _remaining_scores(found, _detections(place, 0.5)) == []
    assert _remaining_scores(found, _detections(place, -0.5)) == [2.0]
    assert _remaining_scores(_detections(place + 3, -1.0), _detections(place, -0.5)) == []
    assert _remaining_scores(found, _detections(place + 40, 0.5)) == [2.0]


def test_a_sign_that_contains_a_known_one_stays() -> None:
    zone, limit = np.array([[10.0, 10, 50, 50]]), np.array([[15.0, 12, 44, 41]])  # IoU 0.53
    assert _remaining_scores(_detections(zone, 2.0), _detections(limit, 9.0)) == [2.0]
    assert _remaining_scores(_detections(limit, 2.0), _detections(zone, 9.0)) == [], (
        "a part of a known sign is no other one"
    )
