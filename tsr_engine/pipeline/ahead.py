"""Detection on several cores: processes detect frames in parallel, and the frames come out in order.

Detection has no state, so a run stores the same bytes on any number of cores. Tracking needs the frames in order and
stays in this process, which also detects if the next frame is not ready. No core waits while there is a frame to
detect. With ``d`` seconds of detection and ``t`` of other work, ``n`` cores take ``max((d + t) / n, t)`` seconds per
frame.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import wait
from typing import Generic, Protocol, TypeVar

from tsr_engine.pipeline.helper import HELD, Detect, Detected, Helper
from tsr_engine.records import Picture

__all__ = ["Detected", "detected_ahead"]


class _Numbered(Protocol):
    @property
    def ordinal(self) -> int: ...
    @property
    def picture(self) -> Picture: ...


F = TypeVar("F", bound=_Numbered)


@dataclass(slots=True)
class _Place(Generic[F]):
    """A frame in the queue.

    Attributes:
        state: ``open``: waits for a helper or this process; ``own``: waits for this process; ``given``: a helper works
            on it; ``done``: has detections or a failure, or is not wanted.
    """

    frame: F
    number: float
    state: str
    found: Detected | None = None
    failure: Exception | None = None


@dataclass(slots=True)
class _Working(Generic[F]):
    """A helper and its frames, in order."""

    helper: Helper
    places: deque[_Place[F]] = field(default_factory=deque)


class _Ahead(Generic[F]):
    """The frames between decoding and tracking."""

    def __init__(self, detect: Detect, cores: int) -> None:
        self._detect = detect
        self._missing = cores - 1
        self._warm = False
        self._working: list[_Working[F]] = []
        self.waiting: deque[_Place[F]] = deque()

    @property
    def full(self) -> bool:
        """Whether enough frames wait to keep all cores busy."""
        helpers = len(self._working) + (self._warm and self._missing > 0)
        return len(self.waiting) > (HELD + 1) * helpers

    def first(self) -> _Place[F]:
        """The first frame, once it is done; until then, this process detects others."""
        place = self.waiting[0]
        while place.state != "done":
            self._collect(0.0)
            self._hand_out()
            if place.state == "done":
                break
            mine = next((each for each in self.waiting if each.state in {"open", "own"}), None)
            if mine is None:
                self._collect(None)
            else:
                self._detect_here(mine)
        return self.waiting.popleft()

    def _detect_here(self, place: _Place[F]) -> None:
        began = time.perf_counter()
        try:
            place.found = self._detect(place.frame.ordinal, place.frame.picture), time.perf_counter() - began
        except Exception as error:  # noqa: BLE001 - raised when it is the frame's turn
            place.failure = error
        place.state = "done"
        self._warm = True

    def _hand_out(self) -> None:
        """Give open frames to helpers that have room for them."""
        for place in [each for each in self.waiting if each.state == "open"]:
            working = self._free(place.frame.picture.shape)
            if working is None:
                return
            try:
                working.helper.give(place.frame.ordinal, place.frame.picture)
            except OSError:
                self._lose(working)
                continue
            place.state = "given"
            working.places.append(place)

    def _free(self, shape: tuple[int, ...]) -> _Working[F] | None:
        """The helper with the fewest frames, or a new one if all have work; None if all are full.

        Helpers start after the first frame, so that they share what it loaded and compiled.
        """
        least = min(self._working, key=lambda working: len(working.places), default=None)
        if (least is None or least.places) and self._warm and self._missing:
            self._missing -= 1
            least = _Working(Helper(self._detect, shape))
            self._working.append(least)
        return None if least is None or len(least.places) == HELD else least

    def _collect(self, seconds: float | None) -> None:
        """Take the results of helpers; wait at most ``seconds`` for the first, None: without limit."""
        if not self._working:
            return
        ready = wait([working.helper.talk for working in self._working], seconds)
        for working in [each for each in self._working if each.helper.talk in ready]:
            try:
                found = working.helper.take()
            except (EOFError, OSError):
                self._lose(working)
                continue
            place = working.places.popleft()
            place.found, place.state = found, "own" if found is None else "done"

    def _lose(self, working: _Working[F]) -> None:
        """Continue without a helper that has ended, for example because memory ran out."""
        for place in working.places:
            place.state = "open"
        self._working.remove(working)
        working.helper.close()

    def close(self) -> None:
        """End all helpers."""
        for working in self._working:
            working.helper.close()
        self._working.clear()


def detected_ahead(
    frames: Iterator[tuple[F, float]],
    detect: Detect,
    cores: int,
    wanted: Callable[[F], bool] = lambda _: True,
) -> Iterator[tuple[F, float, Detected | None]]:
    """Yield frames with their detections, in order.

    Args:
        frames: frames whose pictures have one shape, each with a number that is passed on.
        detect: computes the detections of a frame from its ordinal and picture, in this process or another.
        cores: number of processes that detect, >= 1, this one included. At most four frames per core are in memory.
        wanted: whether to detect a frame; the others come with None.

    Yields:
        Frame, its number, and its detections with their seconds.

    Raises:
        ValueError: ``cores`` is below 1.
        Exception: any error of ``frames`` or ``detect``, after the frames before it.
    """
    if cores < 1:
        raise ValueError(f"cores must be at least 1. Got {cores}.")
    ahead: _Ahead[F] = _Ahead(detect, cores)
    failure: Exception | None = None
    more = True
    try:
        while True:
            while more and not ahead.full:
                try:
                    item = next(frames, None)
                except Exception as error:  # noqa: BLE001 - raised after the frames before
                    failure, item = error, None
                if item is None:
                    more = False
                else:
                    ahead.waiting.append(_Place(*item, state="open" if wanted(item[0]) else "done"))
            if not ahead.waiting:
                break
            place = ahead.first()
            if place.failure is not None:
                raise place.failure
            yield place.frame, place.number, place.found
    finally:
        ahead.close()
    if failure is not None:
        raise failure
