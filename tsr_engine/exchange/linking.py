"""Links boxes without a track id to tracks, frame by frame, by overlap.

The method is greedy: it joins the best pair of an open track and a box of the frame first. Pairs of equal class come
before pairs of different classes; then the larger overlap counts. A track with two boxes or more is predicted by its
last step, since signs beside the road move by most of their width from frame to frame. A track without a box for
``MAX_GAP_FRAMES`` frames is closed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsr_engine.exchange.box_rules import Edges
from tsr_engine.exchange.formats import Switch
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.track_builder import REPEATED_BOX
from tsr_engine.geometry.boxes import iou
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.plural import plural

MIN_IOU = 0.2
"""Boxes with less overlap are two signs."""
MAX_GAP_FRAMES = 3
"""Frames for which a sign may be missed."""

LINK_SWITCH = Switch(
    "link",
    ("iou", "none"),
    f"Boxes without track id: linked where they overlap (IoU of {MIN_IOU} or more, up to {MAX_GAP_FRAMES} frames "
    "missed), or each a track of one frame.",
)


@dataclass(frozen=True, slots=True)
class _Box:
    frame: int
    edges: Edges
    label: int
    line: int | str | None
    key: bool
    occluded: bool
    ignore: bool
    score: float
    attributes: JsonMapping | None


class UntrackedBoxes:
    """Collects boxes without track id and passes them to a validator as tracks."""

    def __init__(self, validator: ImportValidator, file: str) -> None:
        """Take a validator, and the file's name for messages."""
        self._validator = validator
        self._file = file
        self._boxes: list[tuple[_Box, str]] = []
        self._seen: set[tuple[int, Edges, int]] = set()

    def __len__(self) -> int:
        return len(self._boxes)

    def add(
        self,
        frame: int,
        edges: Edges,
        label: int,
        *,
        file: str,
        line: int | str | None = None,
        key: bool = True,
        occluded: bool = False,
        ignore: bool = False,
        score: float = math.nan,
        attributes: JsonMapping | None = None,
    ) -> None:
        """Take a box, with the arguments of ``ImportValidator.box``; only its edges are checked before ``finish``.

        A box that repeats one of the same frame and label is left out and counted, as Ultralytics does: two tracks
        would show one sign.
        """
        if not self._validator.boxes.check(edges, file, line):
            return
        if (frame, edges, label) in self._seen:
            self._validator.count(REPEATED_BOX, file, line)
            return
        self._seen.add((frame, edges, label))
        self._boxes.append((_Box(frame, edges, label, line, key, occluded, ignore, score, attributes), file))

    def finish(self) -> None:
        """Pass on all boxes, linked unless the switch ``link`` is ``none``; report the numbers of boxes and tracks.

        Raises:
            ImportFormatError: a box breaks a rule.
        """
        if not self._boxes:
            return
        boxes = [box for box, _ in self._boxes]
        linked = self._validator.target.switches.get("link", "iou") == "iou"
        track_of_box = link_boxes(boxes) if linked else list(range(len(boxes)))
        names: dict[int, str] = {}
        next_number = 1
        for track in track_of_box:
            if track not in names:
                while f"box{next_number}" in self._validator:
                    next_number += 1
                names[track] = f"box{next_number}"
                next_number += 1
        for (box, file), track in zip(self._boxes, track_of_box, strict=True):
            self._validator.box(
                names[track],
                box.frame,
                box.edges,
                box.label,
                file=file,
                line=box.line,
                key=box.key,
                occluded=box.occluded,
                ignore=box.ignore,
                score=box.score,
                attributes=box.attributes,
            )
        result = f"linked to {plural(len(names), 'track')} by overlap" if linked else "taken as tracks of one frame"
        count = plural(len(boxes), "box has", "boxes have")
        self._validator.repair(f"{self._file}: {count} no track id: {result}.")
        self._boxes.clear()
        self._seen.clear()


def link_boxes(boxes: list[_Box]) -> list[int]:
    """Track number of each box; tracks are numbered in the order in which they begin."""
    order = sorted(range(len(boxes)), key=lambda k: (boxes[k].frame, k))
    track_of_box = [-1] * len(boxes)
    last: dict[int, int] = {}
    second_last: dict[int, int] = {}
    tracks = 0
    start = 0
    while start < len(order):
        frame = boxes[order[start]].frame
        end = start
        while end < len(order) and boxes[order[end]].frame == frame:
            end += 1
        current = order[start:end]
        last = {track: k for track, k in last.items() if frame - boxes[k].frame <= MAX_GAP_FRAMES + 1}
        for track, k in _match(boxes, last, second_last, current):
            track_of_box[k] = track
            second_last[track] = last[track]
        for k in current:
            if track_of_box[k] < 0:
                track_of_box[k] = tracks
                tracks += 1
            last[track_of_box[k]] = k
        start = end
    return track_of_box


def _match(
    boxes: list[_Box], last: dict[int, int], second_last: dict[int, int], current: list[int]
) -> list[tuple[int, int]]:
    """Joined pairs of track and box; ``last`` and ``second_last`` are the two latest boxes of each track."""
    if not last:
        return []
    tracks = list(last)
    overlap = _iou(
        np.array([_predict(boxes, last[t], second_last.get(t), boxes[current[0]].frame) for t in tracks]),
        np.array([boxes[k].edges for k in current]),
    )
    same_label = np.array([[boxes[last[t]].label == boxes[k].label for k in current] for t in tracks])
    rows, columns = np.nonzero(overlap >= MIN_IOU)
    best = np.lexsort((columns, rows, -overlap[rows, columns], ~same_label[rows, columns]))
    used_rows: set[int] = set()
    used_columns: set[int] = set()
    out: list[tuple[int, int]] = []
    for row, column in zip(rows[best].tolist(), columns[best].tolist(), strict=True):
        if row not in used_rows and column not in used_columns:
            used_rows.add(row)
            used_columns.add(column)
            out.append((tracks[row], current[column]))
    return out


def _predict(boxes: list[_Box], last: int, second_last: int | None, frame: int) -> tuple[float, ...]:
    """The predicted box of a track: its last box, moved by the last step of its centre."""
    end = boxes[last]
    if second_last is None:
        return end.edges
    start = boxes[second_last]
    steps = (frame - end.frame) / (end.frame - start.frame)
    dx, dy = ((end.edges[k] + end.edges[k + 2] - start.edges[k] - start.edges[k + 2]) / 2 * steps for k in (0, 1))
    x1, y1, x2, y2 = end.edges
    return x1 + dx, y1 + dy, x2 + dx, y2 + dy


def _iou(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Intersection over union of each pair, shape (len(a), len(b)); 0 if a box has no area or is not finite."""
    with np.errstate(all="ignore"):  # the boxes have not been checked yet
        return iou(a, b)
