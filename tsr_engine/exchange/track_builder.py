"""Makes tracks from the rows of a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from tsr_engine.exchange.added_attributes import RowAttributes
from tsr_engine.exchange.dataset import UNSTATED_LABEL, Track
from tsr_engine.exchange.formats import ImportLimits
from tsr_engine.exchange.label_resolver import SKIPPED_LABEL
from tsr_engine.exchange.reading import rule_error, too_many_error
from tsr_engine.exchange.track_rows import BOX, END, TrackRows, common_label, interpolate_rows
from tsr_engine.track_table import NO_CLASS, IntArray

REPEATED_BOX = "Repeated boxes were taken once"
"""Report of repeated rows."""
_SAME_PX = 1e-6


class TrackBuilder:
    """Makes the tracks of a file.

    Args:
        file: for messages about all rows.
        files: files of the rows, by index.
        limits: largest number of boxes, with those between key frames.
        interpolate: draw straight lines from each box to the track's next one.
        ids: label ids from ``LabelResolver``, by the rows' labels.
        count: called for each repeated row with a sentence, the file and the line.
    """

    def __init__(
        self,
        file: str,
        files: Sequence[str],
        limits: ImportLimits,
        interpolate: bool,
        ids: Mapping[int, int],
        count: Callable[[str, str, int | None], None],
    ) -> None:
        self._file, self._files, self._limits = file, files, limits
        self._interpolate, self._ids, self._count = interpolate, ids, count
        self._boxes = 0
        self.attributes_by_track: dict[int, Sequence[RowAttributes]] = {}
        """Attributes of the rows, by index of the track among those made."""

    def build(self, uid: str, rows: TrackRows, index: int) -> Track | None:
        """Build a track from its rows; None: it is never visible.

        The attributes of the rows are stored in ``attributes_by_track`` at ``index``.

        Raises:
            ImportFormatError: it has two different boxes in one frame, or too many boxes.
        """
        frames = np.frombuffer(rows.frame, dtype=np.int64)
        kind = np.frombuffer(rows.kind, dtype=np.int8)
        # If a box and an end share a frame, the box counts.
        order = np.lexsort((kind, frames)) if len(frames) > 1 else np.zeros(len(frames), np.int64)
        selected = order
        if len(order) > 1 and (np.diff(frames[order]) == 0).any():
            selected = self._without_repeated_rows(uid, rows, order)
        frames, kind = frames[selected], kind[selected]
        edges = np.frombuffer(rows.edges, dtype=np.float64).reshape(-1, 4)[selected]
        label = np.frombuffer(rows.label, dtype=np.int64)[selected]
        if self._ids:
            label = np.array([self._ids.get(each, each) for each in label.tolist()], np.int64)
            kept = label != SKIPPED_LABEL
            selected, frames, kind, edges, label = selected[kept], frames[kept], kind[kept], edges[kept], label[kept]
        flags = np.frombuffer(rows.flags, dtype=np.int8)[selected]
        score = np.frombuffer(rows.score, dtype=np.float64)[selected]
        is_box = kind == BOX
        if not is_box.any():
            return None
        if self._interpolate:
            self._boxes += max(int(frames[-1]), rows.until) + 1 - int(frames[0])
            if self._boxes > self._limits.boxes:
                raise too_many_error("boxes, with those between its key frames,", self._limits.boxes, self._file)
            source_rows = np.arange(len(frames))
            frames, edges, source_rows, flags, score = interpolate_rows(
                frames, is_box, edges, source_rows, flags, score, rows.until
            )
        else:
            source_rows = np.flatnonzero(is_box)
            frames, edges, flags, score = frames[is_box], edges[is_box], flags[is_box], score[is_box]
        label = label[source_rows]
        if rows.row_attributes or rows.track_attributes:
            self.attributes_by_track[index] = _attributes_by_frame(rows, selected[source_rows])
        track_label, unstated, label = common_label(label), label == UNSTATED_LABEL, np.maximum(label, NO_CLASS)
        ignore = (flags & 4) > 0
        return Track(
            uid=uid,
            label=track_label,
            frames=frames.copy(),
            boxes=edges.copy(),
            key=(flags & 1) > 0,
            occluded=(flags & 2) > 0,
            score=score.copy(),
            labels=None if (label == track_label).all() else label,
            ignore=ignore if ignore.any() else None,
            silent=unstated if unstated.any() else None,
            state=rows.state,
            source=rows.source,
            notes=tuple(rows.notes),
        )

    def _without_repeated_rows(self, uid: str, rows: TrackRows, order: IntArray) -> IntArray:
        selected: list[int] = []
        for row in order.tolist():
            previous = selected[-1] if selected else -1
            if previous < 0 or rows.frame[previous] != rows.frame[row]:
                selected.append(row)
                continue
            if rows.kind[row] == END:
                continue
            file, line = self._files[rows.file[row]], rows.line[row] if rows.line[row] >= 0 else None
            box, previous_box = rows.edges[4 * row : 4 * row + 4], rows.edges[4 * previous : 4 * previous + 4]
            if max(abs(a - b) for a, b in zip(box, previous_box, strict=True)) > _SAME_PX or (
                rows.label[row] != rows.label[previous]
            ):
                raise rule_error(
                    file,
                    line,
                    f"track {uid!r} has a second, different box in frame {rows.frame[row]}; a track has one box a "
                    "frame. Give the other sign its own id, or delete one.",
                )
            self._count(REPEATED_BOX, file, line)
        return np.array(selected, dtype=np.int64)


def _attributes_by_frame(rows: TrackRows, row_indices: IntArray) -> list[RowAttributes]:
    """Attributes of each frame of a track; all frames of one row share one object."""
    found: Mapping[int, RowAttributes] = rows.row_attributes
    if rows.track_attributes:
        found = {row: {**rows.track_attributes, **(found.get(row) or {})} for row in set(row_indices.tolist())}
    return [found.get(row) for row in row_indices.tolist()]
