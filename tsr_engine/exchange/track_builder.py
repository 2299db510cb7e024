"""Makes tracks from the rows of a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from tsr_engine.exchange.added_attributes import RowAttributes
from tsr_engine.exchange.dataset import UNSTATED_LABEL, Track
from tsr_engine.exchange.formats import ImportLimits
from tsr_engine.exchange.label_resolver import SKIPPED_LABEL
from tsr_engine.exchange.reading import refuse, too_many_error
from tsr_engine.exchange.track_rows import BOX, END, TrackRows, common_label, interpolate_rows
from tsr_engine.track_table import NO_CLASS, IntArray

__all__ = ["TrackBuilder"]

_SAME_PX = 1e-6


class CountRepair(Protocol):
    """Counts a repair: what, file and line."""

    def __call__(self, what: str, file: str, line: int | str | None = None) -> None: ...


class TrackBuilder:
    """Makes the tracks of a file.

    Args:
        file: for messages.
        limits: largest number of boxes, with those between key frames.
        interpolate: draw straight lines from each box to the track's next one.
        ids: label ids from ``LabelResolver``, by the rows' labels.
        count: called for each repeated row.
    """

    def __init__(
        self, file: str, limits: ImportLimits, interpolate: bool, ids: Mapping[int, int], count: CountRepair
    ) -> None:
        self._file, self._limits, self._interpolate, self._ids, self._count = file, limits, interpolate, ids, count
        self._boxes = 0
        self.said: dict[int, Sequence[RowAttributes]] = {}
        """Attributes of the rows, by index of the track among those made."""

    def make(self, uid: str, rows: TrackRows, place: int) -> Track | None:
        """Make a track from its rows, and store their attributes in ``said`` at ``place``; None: it is never visible.

        Raises:
            ImportFormatError: it has two different boxes in one frame, or too many boxes.
        """
        frames = np.frombuffer(rows.frame, dtype=np.int64)
        kind = np.frombuffer(rows.kind, dtype=np.int8)
        # If a box and an end share a frame, the box counts.
        order = np.lexsort((kind, frames)) if len(frames) > 1 else np.zeros(len(frames), np.int64)
        take = order
        if len(order) > 1 and (np.diff(frames[order]) == 0).any():
            take = self._without_twins(uid, rows, order)
        frames, kind = frames[take], kind[take]
        edges = np.frombuffer(rows.edges, dtype=np.float64).reshape(-1, 4)[take]
        label = np.frombuffer(rows.label, dtype=np.int64)[take]
        if self._ids:
            label = np.array([self._ids.get(each, each) for each in label.tolist()], np.int64)
            left = label != SKIPPED_LABEL
            take, frames, kind, edges, label = take[left], frames[left], kind[left], edges[left], label[left]
        flags = np.frombuffer(rows.flags, dtype=np.int8)[take]
        score = np.frombuffer(rows.score, dtype=np.float64)[take]
        is_box = kind == BOX
        if not is_box.any():
            return None
        if self._interpolate:
            self._boxes += max(int(frames[-1]), rows.until) + 1 - int(frames[0])
            if self._boxes > self._limits.boxes:
                raise too_many_error("boxes, with those between its key frames,", self._limits.boxes, self._file)
            at = np.arange(len(frames))
            frames, edges, at, flags, score = interpolate_rows(frames, is_box, edges, at, flags, score, rows.until)
        else:
            at = np.flatnonzero(is_box)
            frames, edges, flags, score = frames[is_box], edges[is_box], flags[is_box], score[is_box]
        label = label[at]
        if rows.said or rows.always:
            self.said[place] = _attributes_by_frame(rows, take[at])
        common, silent, label = common_label(label), label == UNSTATED_LABEL, np.maximum(label, NO_CLASS)
        ignore = (flags & 4) > 0
        return Track(
            uid=uid,
            label=common,
            frames=frames.copy(),
            boxes=edges.copy(),
            key=(flags & 1) > 0,
            occluded=(flags & 2) > 0,
            score=score.copy(),
            labels=None if (label == common).all() else label,
            ignore=ignore if ignore.any() else None,
            silent=silent if silent.any() else None,
            state=rows.state,
            source=rows.source,
            notes=tuple(rows.notes),
        )

    def _without_twins(self, uid: str, rows: TrackRows, order: IntArray) -> IntArray:
        take: list[int] = []
        for place in order.tolist():
            before = take[-1] if take else -1
            if before < 0 or rows.frame[before] != rows.frame[place]:
                take.append(place)
                continue
            if rows.kind[place] == END:
                continue
            line = rows.place[place] if rows.place[place] >= 0 else None
            ours, other = rows.edges[4 * place : 4 * place + 4], rows.edges[4 * before : 4 * before + 4]
            if max(abs(a - b) for a, b in zip(ours, other, strict=True)) > _SAME_PX or (
                rows.label[place] != rows.label[before]
            ):
                raise refuse(
                    self._file,
                    line,
                    f"track {uid!r} has a second, different box in frame {rows.frame[place]}; a track has one box a "
                    "frame. Give the other sign its own id, or delete one.",
                )
            self._count("Repeated boxes were taken once", self._file, line)
        return np.array(take, dtype=np.int64)


def _attributes_by_frame(rows: TrackRows, places: IntArray) -> list[RowAttributes]:
    """Attributes of each frame of a track; all frames of one row share one object."""
    known: dict[int, RowAttributes] = {}
    for place in set(places.tolist()):
        own = rows.said.get(place)
        known[place] = own if own is not None and not rows.always else {**rows.always, **(own or {})} or None
    return [known[place] for place in places.tolist()]
