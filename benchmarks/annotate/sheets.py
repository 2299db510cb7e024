"""Pictures for the annotator: cut-outs, and scenes in a column."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np

from benchmarks.reporting.contact_sheet import cut_square
from tsr_engine.records import FloatArray, Picture

ROWS: Final = (190, 640)
"""Range of rows in a view of a scene."""
TICK: Final = 100
BRIGHT: Final = 100.0
"""Median brightness to which darker scenes are raised."""
MIN_RANGE: Final = 40.0
"""Least assumed range of a cut-out's grey values when its contrast is stretched."""
_FRAME: Final = (255, 0, 255)


def cut(picture: Picture, box: FloatArray, side: int, margin: float) -> Picture:
    """The square around a box with its contrast stretched, without marks."""
    view = cut_square(picture, box, margin, side)
    inner = view[side // 5 : -(side // 5), side // 5 : -(side // 5)]
    low, high = np.percentile(inner, (1, 99))
    stretched = (view.astype(np.float32) - low) * (255 / max(high - low, MIN_RANGE))
    return np.asarray(np.clip(stretched, 0, 255), dtype=np.uint8)


def scene_rows(scenes: Sequence[tuple[str, Picture, FloatArray]]) -> Picture:
    """The relevant rows of scenes in a column, with thin known boxes and marks every 100 px at the edges."""
    views = []
    for name, picture, known in scenes:
        view = _brightened(picture).copy()
        for x1, y1, x2, y2 in np.round(known).astype(int):
            cv2.rectangle(view, (x1 - 2, y1 - 2), (x2 + 1, y2 + 1), _FRAME, 1)
        view = view[ROWS[0] : ROWS[1]]
        for x in range(TICK, view.shape[1], TICK):
            _mark(view, str(x), (x, 0), (x, 6), (x - 12, 16))
        for y in range(-(-ROWS[0] // TICK) * TICK, ROWS[1], TICK):
            _mark(view, str(y), (0, y - ROWS[0]), (8, y - ROWS[0]), (10, y - ROWS[0] + 4))
        cv2.putText(view, name, (2, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 255), 2, cv2.LINE_AA)
        views.append(view)
    return np.vstack(views)


def _mark(view: Picture, text: str, start: tuple[int, int], end: tuple[int, int], place: tuple[int, int]) -> None:
    cv2.line(view, start, end, _FRAME, 1)
    cv2.putText(view, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.35, _FRAME, 1, cv2.LINE_AA)


def _brightened(picture: Picture) -> Picture:
    median = float(np.median(picture))
    if median >= BRIGHT:
        return picture
    power = max(np.log(BRIGHT / 255) / np.log(max(median, 1.0) / 255), 0.4)
    steps = (255 * (np.arange(256) / 255) ** power).astype(np.uint8)
    return np.asarray(cv2.LUT(picture, steps), dtype=np.uint8)
