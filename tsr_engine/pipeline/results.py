"""Result rows for the CSV and one summary per track, computed during a run."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator
from dataclasses import dataclass, field

from tsr_engine.evidence.reader import ResultRow
from tsr_engine.records import FrameEvidence, TrackFrame
from tsr_engine.track_table import NO_CLASS


@dataclass(slots=True)
class TrackSummary:
    """Summary of one track up to the current frame."""

    track_id: int
    first_frame: int
    last_frame: int
    confirmed: bool = False
    class_id: int = NO_CLASS
    """Fused class, -1 before the first recognition."""
    share: float = 0.0
    """Share of the votes for the class, in [0, 1]."""
    best_score: float = float("-inf")
    largest_side: float = 0.0
    """Longest side of any of its boxes, px."""
    frames: Counter[str] = field(default_factory=Counter)
    """Number of frames by source."""

    def extend(self, ordinal: int, track: TrackFrame) -> None:
        """Add one frame."""
        if track.recognition is not None:
            self.class_id, self.share = track.recognition.class_id, float(track.recognition.share)
        if track.state == "dead":
            return
        self.confirmed |= track.state == "confirmed"
        self.last_frame = ordinal
        self.frames[track.source] += 1
        self.best_score = max(self.best_score, float(track.score))
        x1, y1, x2, y2 = track.box.tolist()
        self.largest_side = max(self.largest_side, x2 - x1, y2 - y1)


class ResultStream:
    """Turns frames into result rows, sorted by frame and track: all frames of confirmed tracks.

    A row waits until all tracks of its frame have ended, because its class is fused over all frames of the sign (Eq.
    4). ``finish`` releases the remaining rows. Memory grows with the length of the current tracks, not with that of the
    video.
    """

    def __init__(self) -> None:
        self._waiting: deque[tuple[int, list[tuple[int, TrackFrame]]]] = deque()
        self._live: dict[int, TrackSummary] = {}
        self._ended: dict[int, TrackSummary] = {}
        self.tracks: list[TrackSummary] = []
        """Confirmed tracks that have ended, in the order of their end; after ``finish`` all, by id."""

    def add(self, frame: FrameEvidence) -> Iterator[ResultRow]:
        """Add one frame and yield the rows that are final with it."""
        alive: set[int] = set()
        rows: list[tuple[int, TrackFrame]] = []
        for track in frame.tracks:
            track_id = track.track_id
            summary = self._live.get(track_id)
            if summary is None:
                summary = self._live[track_id] = TrackSummary(track_id, frame.ordinal, frame.ordinal)
            summary.extend(frame.ordinal, track)
            if track.state != "dead":
                alive.add(track_id)
                rows.append((track_id, track))
        if rows:
            self._waiting.append((frame.ordinal, sorted(rows, key=lambda row: row[0])))
        for track_id in [i for i in self._live if i not in alive]:
            self._end(track_id)
        yield from self._final_rows()

    def finish(self) -> Iterator[ResultRow]:
        """End all tracks and yield the remaining rows."""
        for track_id in list(self._live):
            self._end(track_id)
        yield from self._final_rows()
        self.tracks.sort(key=lambda track: track.track_id)

    def _end(self, track_id: int) -> None:
        summary = self._live.pop(track_id)
        self._ended[track_id] = summary
        if summary.confirmed:
            self.tracks.append(summary)

    def _final_rows(self) -> Iterator[ResultRow]:
        while self._waiting and all(track_id in self._ended for track_id, _ in self._waiting[0][1]):
            ordinal, rows = self._waiting.popleft()
            for track_id, track in rows:
                summary = self._ended[track_id]
                if summary.confirmed:
                    yield result_row(ordinal, track, summary.class_id)
        oldest = self._waiting[0][0] if self._waiting else None
        for track_id in [i for i, s in self._ended.items() if oldest is None or s.last_frame < oldest]:
            del self._ended[track_id]


def result_row(ordinal: int, track: TrackFrame, class_id: int) -> ResultRow:
    """One row of the result CSV."""
    x1, y1, x2, y2 = (round(value, 2) for value in track.box.tolist())
    return ResultRow(ordinal, track.track_id, x1, y1, x2, y2, class_id, round(float(track.score), 4), track.source)
