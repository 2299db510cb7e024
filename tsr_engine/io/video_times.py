"""Presentation times of frames, also if the file lacks or contradicts them."""

from __future__ import annotations

import threading
from array import array
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from tsr_engine.io.frame_table import BoolArray, FrameLedger, IntArray

__all__ = ["LEAP", "NO_TIME", "Scan", "Timeline"]

NO_TIME = -(2**62)
"""Stands for a time that a packet does not have. A stamp in a file of timed packets is, for a packet without a time,
its byte position above this."""
_REORDERED = 16
"""Pictures that can follow another one in the file and be shown before it, at most."""
LEAP = 1
"""Seconds: times that run back by more begin anew. Damage puts single pictures out of order by less."""


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """All packets whose pictures are to be shown, in the file's order; arrays of shape (n,).

    Attributes:
        stamps: what the decoder hands back with the picture.
        ticks: presentation times, or decoding times in files without those; ``NO_TIME`` where there is none.
        keys: decoding can start here.
        positions: byte positions, -1 where the packet has none of its own.
        sizes: bytes.
    """

    stamps: IntArray
    ticks: IntArray
    keys: BoolArray
    positions: IntArray
    sizes: IntArray

    @classmethod
    def of(cls, rows: Iterable[tuple[int, int, bool, int, int]]) -> Scan:
        """From one tuple a packet, in the order of the attributes."""
        flat = array("q")  # an hour of video has too many frames for objects
        for row in rows:
            flat.extend(row)
        columns = np.array(flat, dtype=np.int64).reshape(-1, 5).T
        return cls(columns[0].copy(), columns[1].copy(), columns[2] != 0, columns[3].copy(), columns[4].copy())

    @property
    def early(self) -> int:
        """Packets without a time, where all of them are at the start: they are shown before the others."""
        known, missing = np.flatnonzero(self.ticks != NO_TIME), np.flatnonzero(self.ticks == NO_TIME)
        if not len(known) or not len(missing) or missing[0] > 0 or missing[-1] >= known[0] + _REORDERED:
            return 0
        return len(missing)

    def shown_order(self, leap: int) -> Scan:
        """Sorted by time, as far as the packets tell it; each part of a file whose times begin anew by itself.

        Args:
            leap: ticks by which times must run back to begin anew.
        """
        ticks = self.ticks.copy()
        known = ticks != NO_TIME
        if known.any() and self.early:
            ticks[~known] = ticks[known].min() - 1
        elif known.any():  # a packet without a time stays behind the one before it
            before = np.maximum.accumulate(np.where(known, np.arange(len(ticks)), -1))
            ticks = np.where(before < 0, ticks[known].min() - 1, ticks[before])
        highest = np.maximum.accumulate(ticks) if len(ticks) else ticks
        part = np.zeros(len(ticks), dtype=np.int64)
        if (ticks < highest - leap).any():
            top = number = 0
            for k, tick in enumerate(ticks.tolist()):
                if k and tick < top - leap:
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
    """Time at which the present part of the file begins, as the file says."""
    offset: int = 0
    """What is added to the file's times in this part."""


class Timeline:
    """The presentation time of every frame that a ledger knows, by ordinal.

    A frame has the time that the file gives it. One without a time follows the frame before it at the video's rate;
    such frames at the start precede the first frame with a time. Times that restart, as in joined files, continue from
    the frame before. All of this depends only on earlier frames and the packets, so a frame's time does not depend on
    the order of queries. In files with decoding times only (AVI), frame k is shown at the k-th of them.

    Safe to use from any thread.

    Attributes:
        address: how packets are known, see ``Kind``.
        rate: frames per second for frames without a time.
        filled: frames seen so far whose times are reckoned.
        turns: for each place where times begin anew: ordinal, time before and time there as the file says, in s.
    """

    def __init__(
        self, base: Fraction, rate: Fraction, address: str, ledger: FrameLedger, scan: Callable[[], Scan]
    ) -> None:
        """Start before the first frame.

        Args:
            base: seconds per tick.
            rate: frames per second, > 0.
            address: how packets are known, see ``Kind``.
            ledger: the frames in presentation order.
            scan: gives the packets of the file; called only where stamps are no times.
        """
        self.rate = rate
        self.filled = 0
        self.turns: list[tuple[int, float, float]] = []
        self._base = base
        self._step = 1 / (rate * base)
        self._leap = int(LEAP / base)
        self.address = address
        self._ledger = ledger
        self._scan = scan
        self._ticks = array("q")
        self._state = _State()
        self._ranked: IntArray | None = None
        self._lock = threading.RLock()

    def tick(self, k: int) -> int:
        """The time of frame k, which the ledger knows, in ticks."""
        if self.address == "position":
            return int(self._rank(k + 1)[k])
        with self._lock:
            for at in range(len(self._ticks), k + 1):
                self._ticks.append(self._next(self._state, self._ledger.stamp(at), self._reported))
            return self._ticks[k]

    def ticks(self, ahead: IntArray) -> IntArray:
        """The times of all frames of the ledger, then of those that are expected after them.

        Args:
            ahead: the stamps of the latter.
        """
        known = len(self._ledger)
        if self.address == "position":
            return self._rank(known + len(ahead))
        with self._lock:
            if known:
                self.tick(known - 1)
            reported, state = np.array(self._ticks, dtype=np.int64), replace(self._state)
        more = [self._next(state, stamp, lambda *_: None) for stamp in ahead.tolist()]
        return np.concatenate([reported, np.array(more, dtype=np.int64)])

    @property
    def plain(self) -> bool:
        """Every stamp is the time of its frame, as far as the packets tell it. Reads all of them."""
        if self.address != "time" or self.filled or self.turns:
            return False
        ticks = self._scan().ticks
        return bool((ticks != NO_TIME).all() and (ticks >= np.maximum.accumulate(ticks) - self._leap).all())

    def shown_order(self) -> Scan:
        """The packets of the file in the order in which they are expected to be shown."""
        return self._scan().shown_order(self._leap)

    def _own(self, stamp: int) -> int:
        """The time that the file gives a frame, or ``NO_TIME``."""
        if self.address == "time":
            return stamp if stamp > NO_TIME // 2 else NO_TIME
        scan = self._scan()
        return int(scan.ticks[np.searchsorted(scan.stamps, stamp)])

    def _reported(self, k: int, before: float, own: float | None) -> None:
        if own is None:
            self.filled += 1
        else:
            self.turns.append((k, before, own))
            self._ledger.joined |= self.address == "time"

    def _next(self, state: _State, stamp: int, tell: Callable[[int, float, float | None], None]) -> int:
        """The time of the frame after those of ``state``, which goes on to it."""
        own = self._own(stamp)
        last, shown = state.last, own + state.offset
        # Where a packet holds the ends of several pictures, the demuxer gives the time of one to the others too.
        again = self.address == "count" and state.count and last - self._leap <= shown <= last
        if own == NO_TIME or again:
            state.last = last + self._step if state.count else self._lead()
            tell(state.count, 0.0, None)
        else:
            if state.start is None:
                state.start = own
            elif shown < last and (shown < last - self._leap or own <= state.start):
                tell(state.count, float((last - state.offset) * self._base), float(own * self._base))
                state.start, state.offset = own, round(last + self._step) - own
            state.last = own + state.offset
        state.count += 1
        return round(state.last)

    def _lead(self) -> Fraction:
        """The time of the first frame where it has none: as many steps before the first time as packets lack one."""
        scan = self._scan()
        known = np.flatnonzero(scan.ticks != NO_TIME)
        return int(scan.ticks[known].min()) - (scan.early or int(known[0])) * self._step if len(known) else Fraction(0)

    def _rank(self, count: int) -> IntArray:
        """The first ``count`` of the decoding times, in order; beyond the last one, a tick apart."""
        if self._ranked is None:
            self._ranked = np.sort(self._scan().ticks)
        missing = count - len(self._ranked)
        if missing > 0:
            last = int(self._ranked[-1]) if len(self._ranked) else -1
            return np.concatenate([self._ranked, last + 1 + np.arange(missing)])
        return self._ranked[:count]
