"""The frame table: which pictures a video has, in presentation order, and when each is shown.

Ordinal k is the k-th picture of the pinned decoder after edit lists are applied. A row is **confirmed** once the
decoder has produced it; later rows are predicted from the packets. Neither frame rate nor announced count is used for
look-ups.
"""

from __future__ import annotations

import threading
from array import array
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import InputError

FORMAT = 1
MIN_PART_DISTANCE = 32
"""Least distance between frames of a joined file that share a stamp and belong to different parts."""
_KEY, _CORRUPT = 1, 2
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class FrameTable:
    """One row a frame, as arrays: 18 bytes a frame, 2.4 MB for 132,400 frames.

    Attributes:
        time_base: seconds per tick of ``pts``, exact.
        pts: shape (n,), int64, presentation time stamp in ticks.
        stamps: shape (n,), int64, the decoder's stamp of the frame: ``pts``, or in files
            without presentation times (AVI) the byte position of the frame's packet.
        key: shape (n,), True: decoding can start here.
        corrupt: shape (n,), True: the decoder concealed damage in this picture or in one it may be predicted from.
        confirmed: number of leading rows that the decoder has produced.
        complete: whether the decoder has reached the end of the file; then ``confirmed == n``.
    """

    time_base: Fraction
    pts: IntArray
    stamps: IntArray
    key: BoolArray
    corrupt: BoolArray
    confirmed: int
    complete: bool

    def __post_init__(self) -> None:
        n = len(self.pts)
        for name in ("pts", "stamps", "key", "corrupt"):
            if getattr(self, name).shape != (n,):
                raise ValueError(f"FrameTable.{name} must have shape ({n},). Got {getattr(self, name).shape} instead.")
        if not 0 <= self.confirmed <= n or (self.complete and self.confirmed != n):
            raise ValueError(f"FrameTable.confirmed must be {n} if complete, else 0..{n}. Got {self.confirmed}.")
        if self.time_base <= 0:
            raise ValueError(f"FrameTable.time_base must be positive. Got {self.time_base}.")

    def __len__(self) -> int:
        return len(self.pts)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, FrameTable):
            return False
        other_arrays = other.to_arrays()
        return all(np.array_equal(values, other_arrays[name]) for name, values in self.to_arrays().items())

    __hash__ = None  # type: ignore[assignment]

    def time(self, k: int) -> Fraction:
        """Presentation time of frame k in seconds, exact.

        Raises:
            IndexError: k is not in 0..n-1.
        """
        if not 0 <= k < len(self):
            raise IndexError(f"The video has frames 0..{len(self) - 1}. Got {k}.")
        return int(self.pts[k]) * self.time_base

    def interval(self) -> Fraction:
        """The median time from one frame to the next in seconds, exact; 1/25 for a single frame."""
        steps = np.sort(np.diff(self.pts))
        steps = steps[steps > 0]
        return int(steps[len(steps) // 2]) * self.time_base if len(steps) else Fraction(1, 25)

    def key_at_or_before(self, k: int) -> int | None:
        """The last key frame at or before frame k; None: there is none."""
        keys = np.flatnonzero(self.key[: k + 1])
        return int(keys[-1]) if len(keys) else None

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """The table as plain arrays for a NumPy archive; ``from_arrays`` reads them."""
        header = [FORMAT, self.time_base.numerator, self.time_base.denominator, self.confirmed, int(self.complete)]
        return {
            "header": np.array(header, dtype=np.int64),
            "pts": self.pts,
            "stamps": self.stamps,
            "key": self.key,
            "corrupt": self.corrupt,
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]]) -> FrameTable:
        """Invert ``to_arrays``.

        Raises:
            InputError: arrays are missing, contradict each other or have another format.
        """
        try:
            version, numerator, denominator, confirmed, complete = (int(value) for value in arrays["header"])
            if version != FORMAT:
                raise InputError(f"The frame table has format {version}, this version reads format {FORMAT}.")
            return cls(
                Fraction(numerator, denominator),
                np.array(arrays["pts"], dtype=np.int64),
                np.array(arrays["stamps"], dtype=np.int64),
                np.array(arrays["key"], dtype=np.bool_),
                np.array(arrays["corrupt"], dtype=np.bool_),
                confirmed,
                bool(complete),
            )
        except (KeyError, TypeError, ValueError, OverflowError, ZeroDivisionError) as error:
            raise InputError(f"The frame table is damaged: {error}. Import the video again.") from None


class FrameLedger:
    """A frame table under construction: rows are appended as the decoder produces frames.

    Attributes:
        time_base: seconds per tick.
        complete: whether the end of the file is known.
        damaged: whether a frame is corrupt.
        joined: whether times in the file restart, so that frames of several parts share stamps.
    """

    def __init__(self, time_base: Fraction, head: FrameTable | None = None) -> None:
        self.time_base = time_base
        self.complete = False
        self.damaged = False
        self.joined = False
        self._lock = threading.Lock()
        self._stamps = array("q")
        self._flags = bytearray()
        self._starts = b""
        self._starts_state = (0, False, False)
        if head is not None:
            self.adopt(head)

    def __len__(self) -> int:
        return len(self._stamps)

    def adopt(self, head: FrameTable) -> bool:
        """Take over the rows that an earlier pass has confirmed.

        Returns:
            Whether they agree with existing rows; if not, nothing is taken over.
        """
        n = head.confirmed
        flags = (_KEY * head.key[:n] | _CORRUPT * head.corrupt[:n]).astype(np.uint8).tobytes()
        with self._lock:
            known = len(self)
            shared = min(known, n)
            stamps = head.stamps[:n].tolist()
            if stamps[:shared] != self._stamps[:shared].tolist() or flags[:shared] != self._flags[:shared]:
                return False
            if (self.complete and n > known) or (head.complete and known > n):
                return False
            self._stamps.extend(stamps[known:])
            self._flags.extend(flags[known:])
            self.complete |= head.complete
            self.damaged |= bool(head.corrupt[:n].any())
            return True

    def record(self, k: int, stamp: int, key: bool, corrupt: bool) -> bool:
        """Add frame k, or compare it with its row if there is one.

        Returns:
            Whether the row agrees; always true for a new row.
        """
        flags = _KEY * key | _CORRUPT * corrupt
        with self._lock:
            if k > len(self):
                raise ValueError(f"Frame {k} cannot follow frame {len(self) - 1}.")
            if k < len(self):
                return self._stamps[k] == stamp and self._flags[k] == flags
            if self.complete:
                return False
            self._stamps.append(stamp)
            self._flags.append(flags)
            self.damaged |= corrupt
            return True

    def finish(self, count: int) -> bool:
        """Record that the file ends after ``count`` frames.

        Returns:
            Whether that agrees with the rows.
        """
        with self._lock:
            if count == len(self):
                self.complete = True
            return self.complete and count == len(self)

    def stamp(self, k: int) -> int:
        """The decoder's stamp of frame k."""
        return self._stamps[k]

    def confirmed_stamps(self) -> IntArray:
        """The stamps of all rows, shape (n,)."""
        return np.array(self._stamps, dtype=np.int64)

    def key_at_or_before(self, k: int) -> int | None:
        """The last confirmed key frame at or before frame k; None: there is none."""
        found = max(self._flags.rfind(flags, 0, k + 1) for flags in (_KEY, _KEY | _CORRUPT))
        return found if found >= 0 else None

    def start_at_or_before(self, k: int) -> int | None:
        """The last key frame at or before frame k with a unique stamp: no frame near it has the same one.

        Frames share a stamp if a file's clock is too coarse for its rate. The frame after the last row is unknown and
        may share that row's stamp. Frames of other parts of a joined file lie far away.
        """
        with self._lock:
            state = (len(self._stamps), self.complete, self.joined)
            if state != self._starts_state:
                stamps = np.array(self._stamps, dtype=np.int64)
                order = np.argsort(stamps, kind="stable")
                is_duplicate = np.diff(stamps[order]) == 0
                if self.joined:
                    is_duplicate &= np.diff(order) < MIN_PART_DISTANCE
                is_unique = np.ones(len(stamps), dtype=np.bool_)
                is_unique[order[1:][is_duplicate]] = is_unique[order[:-1][is_duplicate]] = False
                is_unique[-1:] &= self.complete
                is_key = (np.frombuffer(bytes(self._flags), dtype=np.uint8) & _KEY).astype(np.bool_)
                self._starts, self._starts_state = (is_key & is_unique).tobytes(), state
            found = self._starts.rfind(1, 0, k + 1)
        return found if found >= 0 else None

    def corrupt_between(self, start: int, stop: int) -> bool:
        """Whether any of the frames ``start <= k < stop`` is corrupt."""
        return any(self._flags.find(flags, start, stop) >= 0 for flags in (_CORRUPT, _KEY | _CORRUPT))

    def table(self, expected: IntArray, expected_keys: BoolArray, times: IntArray | None) -> FrameTable:
        """The confirmed rows, followed by the rows predicted from packets.

        Args:
            expected: sorted stamps of the unconfirmed packets.
            expected_keys: their key flags.
            times: presentation times of all rows if stamps are byte positions; unset: stamps are the times.
        """
        with self._lock:
            confirmed = np.array(self._stamps, dtype=np.int64)
            flags = np.frombuffer(bytes(self._flags), dtype=np.uint8)
            complete = self.complete and not len(expected)
        stamps = np.concatenate([confirmed, expected])
        key = np.concatenate([(flags & _KEY).astype(np.bool_), expected_keys])
        corrupt = np.concatenate([(flags & _CORRUPT).astype(np.bool_), np.zeros(len(expected), dtype=np.bool_)])
        pts = stamps if times is None else times
        return FrameTable(self.time_base, pts, stamps, key, corrupt, len(confirmed), complete)
