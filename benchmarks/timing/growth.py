"""Measures how time grows with the number of signs in view, and with the size of the picture."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from benchmarks.timing.looped_video import RATE, SIZE
from tsr_engine.evaluation.track_tables import read_clip_truth
from tsr_engine.evidence import FramePixels
from tsr_engine.geometry.boxes import shorter_side
from tsr_engine.io.video import open_video
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, FrameInput, TrackingCore, load_detector, one_blas_thread
from tsr_engine.records import Detections, Picture

_FRAMES: Final = 30
_STARTING: Final = 12
"""Number of first frames that are not counted: they confirm tracks and compile code."""


def exponent(x: Sequence[float], y: Sequence[float]) -> float:
    """``b`` of the best ``y = a * x ** b``, by least squares of the logarithms."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def sign_faces(video: Path, truth: Path) -> list[Picture]:
    """The largest views of four signs of an annotated drive, squares of 64 px."""
    rows = read_clip_truth(truth)
    whole = (rows.visibility > 0.95) & (rows.boxes[:, :2] >= 0).all(axis=1)
    sides = np.where(whole, shorter_side(rows.boxes), 0.0)
    largest = (
        np.flatnonzero(rows.track == track)[sides[rows.track == track].argmax()] for track in np.unique(rows.track)
    )
    chosen = sorted((row for row in largest if sides[row]), key=lambda row: -sides[row])[:4]
    faces = []
    with open_video(video) as opened:
        for row in chosen:
            number, (x1, y1, x2, y2) = int(rows.frame[row]), rows.boxes[row]
            picture = next(iter(opened.frames(number, number + 1))).picture
            part = picture[round(y1) : round(y2), round(x1) : round(x2)]
            faces.append(cv2.resize(part, (64, 64), interpolation=cv2.INTER_AREA))
    return faces


def sign_cost(
    background: Picture, faces: Sequence[Picture], counts: Sequence[int], components: Components
) -> dict[int, float]:
    """Median CPU ms of a step of the core by the number of signs in view, all detected in every frame.

    Args:
        background: picture of size SIZE.
        faces: pictures of signs, pasted in turn.
        counts: numbers of signs, at most 20.
        components: trained parts; the detector is not used.
    """
    costs = {}
    with one_blas_thread():
        for count in counts:
            core = TrackingCore(Params(), components.parts, *SIZE, interval=1 / RATE)
            times = []
            for k in range(_FRAMES):
                boxes = np.array([_place(number, k) for number in range(count)])
                pixels = FramePixels(_pasted(background, faces, boxes))
                scores, prior = np.full(count, 5.0), np.full(count, 0.5)
                given = FrameInput(k, k / RATE, Detections(boxes, scores, prior, scores), (0.0, 0.0), pixels)
                began = time.process_time()
                core.step(given)
                if k >= _STARTING:
                    times.append(time.process_time() - began)
            costs[count] = 1e3 * float(np.median(times))
    return costs


def _place(number: int, k: int) -> list[float]:
    """Box of sign ``k`` in frame ``number``: signs in five columns and four rows grow from 24 px without overlap."""
    column, row = number % 5, number // 5
    side = 24 + 0.5 * k
    x, y = 110 + 125 * column + 0.3 * k, 90 + 125 * row + 0.2 * k
    return [x - side / 2, y - side / 2, x + side / 2, y + side / 2]


def _pasted(background: Picture, faces: Sequence[Picture], boxes: np.ndarray) -> Picture:
    picture = background.copy()
    for number, (x1, y1, x2, y2) in enumerate(np.round(boxes).astype(int)):
        face = faces[number % len(faces)]
        picture[y1:y2, x1:x2] = cv2.resize(face, (x2 - x1, y2 - y1), interpolation=cv2.INTER_AREA)
    return picture


def picture_cost(pictures: Sequence[Picture], factors: Sequence[float]) -> dict[tuple[int, int], float]:
    """Median CPU ms of a detection on one thread, by size: pictures are scaled to SIZE times each factor."""
    detector = load_detector(Params().with_settings([("second_core", False)]))
    sizes = [(round(SIZE[0] * factor), round(SIZE[1] * factor)) for factor in factors]
    times: dict[tuple[int, int], list[float]] = {size: [] for size in sizes}
    for number, picture in enumerate([pictures[0], *pictures]):  # the first run compiles and is not counted
        for size in sizes:
            scaled = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
            began = time.thread_time()
            detector.detect(scaled)
            if number:
                times[size].append(time.thread_time() - began)
    return {size: 1e3 * float(np.median(values)) for size, values in times.items()}
