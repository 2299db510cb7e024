"""Detection on several cores: frames are detected side by side and come out in their order.

Detection has no memory, so that a frame's detections do not depend on when or where they are made: a run on any number
of cores stores the same bytes. Tracking needs the frames in order and stays on one core; what it costs a frame bounds
the speed (Amdahl): with ``d`` seconds of detection and ``t`` of the rest, ``n`` cores take ``max((d + t) / n, t)``.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from tsr_engine.records import Detections

__all__ = ["Detected", "detected_ahead"]


F = TypeVar("F")
Detected = tuple[Detections, float]
"""Detections of a frame, and the seconds that they took."""


def detected_ahead(
    frames: Iterator[tuple[F, float]],
    detect: Callable[[F], Detections],
    cores: int,
    wanted: Callable[[F], bool] = lambda _: True,
) -> Iterator[tuple[F, float, Detected | None]]:
    """Frames with their detections, in order.

    Args:
        frames: frames, each with a number that is passed on.
        detect: detections of a frame; called by ``cores`` threads at a time, or by the caller's own if it is one.
        cores: threads that detect, >= 1. At most ``cores + 1`` frames wait or are worked on besides the one yielded.
        wanted: whether a frame is detected; the others come with None.

    Raises:
        ValueError: ``cores`` is below 1.
        Whatever ``frames`` or ``detect`` raise, after the frames before.
    """
    if cores < 1:
        raise ValueError(f"cores must be at least 1. Got {cores}.")

    def timed(frame: F) -> Detected | None:
        if not wanted(frame):
            return None
        began = time.perf_counter()
        return detect(frame), time.perf_counter() - began

    if cores == 1:
        for frame, number in frames:
            yield frame, number, timed(frame)
        return
    waiting: deque[tuple[F, float, Future[Detected | None]]] = deque()
    pool = ThreadPoolExecutor(cores, "tsr-detect")
    try:
        for frame, number in frames:
            waiting.append((frame, number, pool.submit(timed, frame)))
            if len(waiting) > cores + 1:
                yield _first(waiting)
        while waiting:
            yield _first(waiting)
    finally:
        pool.shutdown(cancel_futures=True)


def _first(waiting: deque[tuple[F, float, Future[Detected | None]]]) -> tuple[F, float, Detected | None]:
    frame, number, found = waiting.popleft()
    return frame, number, found.result()
