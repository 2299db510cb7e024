"""Detection on several cores: processes detect frames in parallel, and the frames come out in order.

Detection has no state, so a frame's detections do not depend on when or where they are made: a run on any number of
cores stores the same bytes. Tracking needs the frames in order and stays in this process, which also detects if the
next frame is not ready. No core waits while there is a frame to detect. With ``d`` seconds of detection and ``t``
of the rest, ``n`` cores take ``max((d + t) / n, t)`` a frame.
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
    """A frame that has not come out yet.

    Attributes:
        state: ``open`` is to be given to a helper or detected here, ``own`` is to be detected here, ``given`` is with a
            helper, ``done`` has detections, a failure, or neither where nobody wants them.
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
        """Whether as many frames wait as are worth their memory."""
        helpers = len(self._working) + (self._warm and self._missing > 0)
        return len(self.waiting) > (HELD + 1) * helpers

    def first(self) -> _Place[F]:
        """The first frame, as soon as it is done; meanwhile others are detected here."""
        place = self.waiting[0]
        while place.state != "done":
            self._hear(0.0)
            self._give()
            if place.state == "done":
                break
            mine = next((each for each in self.waiting if each.state in {"open", "own"}), None)
            if mine is None:
                self._hear(None)
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

    def _give(self) -> None:
        """Let no helper be without work."""
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
        """The helper that has least to do, a new one if that is too much; None: all have enough.

        Helpers begin after the first frame: what was loaded and compiled for it is there in each.
        """
        least = min(self._working, key=lambda working: len(working.places), default=None)
        if (least is None or least.places) and self._warm and self._missing:
            self._missing -= 1
            least = _Working(Helper(self._detect, shape))
            self._working.append(least)
        return None if least is None or len(least.places) == HELD else least

    def _hear(self, seconds: float | None) -> None:
        """Take what helpers have done; wait for one of them for so long, None: until there is something."""
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
        """Go on without a helper that has ended, such as one that was killed where memory is short."""
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
    """Frames with their detections, in order.

    Args:
        frames: frames whose pictures have one shape, each with a number that is passed on.
        detect: detections of a frame by its number and picture, from this process or another.
        cores: processes that detect, >= 1, of which this is one. At most four frames a core wait or are worked on.
        wanted: whether a frame is detected; the others come with None.

    Raises:
        ValueError: ``cores`` is below 1.
        Whatever ``frames`` or ``detect`` raise, after the frames before.
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
