"""Finds presentation times of frames, also if the file lacks or contradicts them."""

from __future__ import annotations

import threading
from array import array
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from tsr_engine.io.frame_table import BoolArray, FrameLedger, IntArray

NO_TIME = -(2**62)
"""Time of a packet without one. In a file of timed packets, the stamp of a packet without a time is this number plus
its byte position."""
_MAX_REORDERED = 16
"""Largest number of pictures that follow another one in the file and are shown before it."""
MIN_RESTART_S = 1
"""Seconds by which times must go back to count as a restart. Damage puts single pictures out of order by less."""


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """All packets with visible pictures, in the file's order; arrays of shape (n,).

    Attributes:
        stamps: the decoder's stamp of the picture.
        ticks: presentation times, or decoding times in files without those; ``NO_TIME``: none.
        keys: whether decoding can start here.
        positions: byte positions; -1: the packet has none.
        sizes: sizes in bytes.
    """

    stamps: IntArray
    ticks: IntArray
    keys: BoolArray
    positions: IntArray
    sizes: IntArray

    @classmethod
    def from_packets(cls, rows: Iterable[tuple[int, int, bool, int, int]]) -> Scan:
        """Build a scan from one tuple per packet, in the order of the attributes."""
        flat = array("q")  # an hour of video has too many frames for Python objects
        for row in rows:
            flat.extend(row)
        columns = np.array(flat, dtype=np.int64).reshape(-1, 5).T
        return cls(columns[0].copy(), columns[1].copy(), columns[2] != 0, columns[3].copy(), columns[4].copy())

    @property
    def untimed_at_start(self) -> int:
        """Number of packets without a time, if all of them are at the start: they are shown before the others."""
        known, missing = np.flatnonzero(self.ticks != NO_TIME), np.flatnonzero(self.ticks == NO_TIME)
        if not len(known) or not len(missing) or missing[0] > 0 or missing[-1] >= known[0] + _MAX_REORDERED:
            return 0
        return len(missing)

    def in_display_order(self, restart_ticks: int) -> Scan:
        """Sort by time as far as the packets state it, separately for each part of a file whose times restart.

        Args:
            restart_ticks: ticks by which times must go back to count as a restart.
        """
        ticks = self.ticks.copy()
        known = ticks != NO_TIME
        if known.any() and self.untimed_at_start:
            ticks[~known] = ticks[known].min() - 1
        elif known.any():  # a packet without a time stays after the one before it
            last_known = np.maximum.accumulate(np.where(known, np.arange(len(ticks)), -1))
            ticks = np.where(last_known < 0, ticks[known].min() - 1, ticks[last_known])
        highest = np.maximum.accumulate(ticks) if len(ticks) else ticks
        part = np.zeros(len(ticks), dtype=np.int64)
        if (ticks < highest - restart_ticks).any():
            top = number = 0
            for k, tick in enumerate(ticks.tolist()):
                if k and tick < top - restart_ticks:
                    number, top = number + 1, tick
                top = max(top, tick) if k else tick
                part[k] = number
        order = np.lexsort((ticks, part))
        return Scan(*(getattr(self, name)[order] for name in self.__slots__))


@dataclass(slots=True)
class _State:
    """State of the computation after some frames."""

    count: int = 0
    last: int | Fraction = 0
    """Time of the last frame, ticks."""
    start: int | None = None
    """Start time of the current part of the file, as in the file."""
    offset: int = 0
    """Offset that is added to the file's times in this part."""


class Timeline:
    """The presentation times of all frames in a ledger, by ordinal.

    A frame has the time that the file states. A frame without one follows the frame before it at the video's rate;
    such frames at the start precede the first frame with a time. Times that restart, as in joined files, continue from
    the frame before. All of this depends only on earlier frames and the packets, so a frame's time does not depend on
    the order of queries. In files with decoding times only (AVI), frame k is shown at the k-th of them.

    Safe to use from any thread.

    Attributes:
        address: how packets are identified, see ``Kind``.
        rate: frames per second for frames without a time.
        filled: number of frames so far with a computed time.
        restarts: for each restart: ordinal, time before and time there as in the file, s.
    """

    def __init__(
        self, base: Fraction, rate: Fraction, address: str, ledger: FrameLedger, scan: Callable[[], Scan]
    ) -> None:
        """Start before the first frame.

        Args:
            base: seconds per tick.
            rate: frames per second, > 0.
            address: how packets are identified, see ``Kind``.
            ledger: the frames in presentation order.
            scan: returns the packets of the file; called only if stamps are not times.
        """
        self.rate = rate
        self.filled = 0
        self.restarts: list[tuple[int, float, float]] = []
        self._base = base
        self._step = 1 / (rate * base)
        self._restart_ticks = int(MIN_RESTART_S / base)
        self.address = address
        self._ledger = ledger
        self._scan = scan
        self._ticks = array("q")
        self._state = _State()
        self._times_in_order: IntArray | None = None
        self._lock = threading.RLock()

    def tick(self, k: int) -> int:
        """The time of frame k of the ledger, in ticks."""
        if self.address == "position":
            return int(self._sorted_times(k + 1)[k])
        with self._lock:
            for ordinal in range(len(self._ticks), k + 1):
                self._ticks.append(self._next(self._state, self._ledger.stamp(ordinal), self._record))
            return self._ticks[k]

    def ticks(self, expected: IntArray) -> IntArray:
        """The times of all frames of the ledger, then of the frames expected after them.

        Args:
            expected: stamps of the expected frames.
        """
        known = len(self._ledger)
        if self.address == "position":
            return self._sorted_times(known + len(expected))
        with self._lock:
            if known:
                self.tick(known - 1)
            known_ticks, state = np.array(self._ticks, dtype=np.int64), replace(self._state)
        expected_ticks = [self._next(state, stamp, lambda *_: None) for stamp in expected.tolist()]
        return np.concatenate([known_ticks, np.array(expected_ticks, dtype=np.int64)])

    @property
    def stamps_are_times(self) -> bool:
        """Whether every stamp is the time of its frame, as far as the packets state it. Reads all of them."""
        if self.address != "time" or self.filled or self.restarts:
            return False
        ticks = self._scan().ticks
        return bool((ticks != NO_TIME).all() and (ticks >= np.maximum.accumulate(ticks) - self._restart_ticks).all())

    def in_display_order(self) -> Scan:
        """The packets of the file in the expected order of display."""
        return self._scan().in_display_order(self._restart_ticks)

    def _stated_time(self, stamp: int) -> int:
        """The time that the file states for a frame, or ``NO_TIME``."""
        if self.address == "time":
            return stamp if stamp > NO_TIME // 2 else NO_TIME
        scan = self._scan()
        return int(scan.ticks[np.searchsorted(scan.stamps, stamp)])

    def _record(self, k: int, last_time: float, stated: float | None) -> None:
        if stated is None:
            self.filled += 1
        else:
            self.restarts.append((k, last_time, stated))
            self._ledger.joined |= self.address == "time"

    def _next(self, state: _State, stamp: int, record: Callable[[int, float, float | None], None]) -> int:
        """The time of the frame after ``state``, which is advanced to it."""
        stated = self._stated_time(stamp)
        last, shown = state.last, stated + state.offset
        # If a packet holds the ends of several pictures, the demuxer gives all of them the time of one.
        is_repeated = self.address == "count" and state.count and last - self._restart_ticks <= shown <= last
        if stated == NO_TIME or is_repeated:
            state.last = last + self._step if state.count else self._first_time()
            record(state.count, 0.0, None)
        else:
            if state.start is None:
                state.start = stated
            elif shown < last and (shown < last - self._restart_ticks or stated <= state.start):
                record(state.count, float((last - state.offset) * self._base), float(stated * self._base))
                state.start, state.offset = stated, round(last + self._step) - stated
            state.last = stated + state.offset
        state.count += 1
        return round(state.last)

    def _first_time(self) -> Fraction:
        """The time of a first frame without one: as many steps before the first time as packets lack a time."""
        scan = self._scan()
        known = np.flatnonzero(scan.ticks != NO_TIME)
        return (
            int(scan.ticks[known].min()) - (scan.untimed_at_start or int(known[0])) * self._step
            if len(known)
            else Fraction(0)
        )

    def _sorted_times(self, count: int) -> IntArray:
        """The first ``count`` decoding times in order; beyond the last, one tick apart."""
        if self._times_in_order is None:
            self._times_in_order = np.sort(self._scan().ticks)
        missing = count - len(self._times_in_order)
        if missing > 0:
            last = int(self._times_in_order[-1]) if len(self._times_in_order) else -1
            return np.concatenate([self._times_in_order, last + 1 + np.arange(missing)])
        return self._times_in_order[:count]
