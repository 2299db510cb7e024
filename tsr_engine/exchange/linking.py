"""Links boxes without a track id to tracks, frame by frame, by overlap.

The method is greedy: it joins the best pair of an open track and a box of the frame first. Pairs of equal class come
before pairs of different classes; then the larger overlap counts. A track with two boxes or more is predicted by its
last step, since signs beside the road move by most of their width from frame to frame. A track without a box for
``GAP`` frames is closed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsr_engine.exchange.checks import ImportValidator
from tsr_engine.exchange.formats import Switch
from tsr_engine.geometry.boxes import iou
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.plural import plural

__all__ = ["GAP", "LEAST_IOU", "LINK_SWITCH", "LooseBoxes"]

LEAST_IOU = 0.2
"""Boxes with less overlap are two signs."""
GAP = 3
"""Frames for which a sign may be missed."""

LINK_SWITCH = Switch(
    "link",
    ("iou", "none"),
    f"Boxes without track id: linked where they overlap (IoU of {LEAST_IOU} or more, up to {GAP} frames missed), or "
    "each a track of one frame.",
)


@dataclass(frozen=True, slots=True)
class _Box:
    frame: int
    edges: tuple[float, float, float, float]
    label: int
    line: int | str | None
    key: bool
    occluded: bool
    ignore: bool
    score: float
    said: JsonMapping | None


class LooseBoxes:
    """Collects boxes without track id and passes them to a validator as tracks."""

    def __init__(self, validator: ImportValidator, file: str) -> None:
        """Take a validator, and the file's name for messages."""
        self._validator = validator
        self._file = file
        self._boxes: list[tuple[_Box, str]] = []

    def __len__(self) -> int:
        return len(self._boxes)

    def add(
        self,
        frame: int,
        edges: tuple[float, float, float, float],
        label: int,
        *,
        file: str,
        line: int | str | None = None,
        key: bool = True,
        occluded: bool = False,
        ignore: bool = False,
        score: float = math.nan,
        said: JsonMapping | None = None,
    ) -> None:
        """Take a box, with the arguments of ``ImportValidator.box``; only its edges are checked before ``finish``."""
        if not self._validator.boxes.takes(edges, file, line):
            return
        self._boxes.append((_Box(frame, edges, label, line, key, occluded, ignore, score, said), file))

    def finish(self) -> None:
        """Pass on all boxes, linked unless the switch ``link`` is ``none``; report the numbers of boxes and tracks.

        Raises:
            ImportFormatError: a box breaks a rule.
        """
        if not self._boxes:
            return
        boxes = [box for box, _ in self._boxes]
        linked = self._validator.target.switches.get("link", "iou") == "iou"
        number = link(boxes) if linked else list(range(len(boxes)))
        names: dict[int, str] = {}
        free = 1
        for track in number:
            if track not in names:
                while f"box{free}" in self._validator:
                    free += 1
                names[track] = f"box{free}"
                free += 1
        for (box, file), track in zip(self._boxes, number, strict=True):
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
                said=box.said,
            )
        how = f"linked to {plural(len(names), 'track')} by overlap" if linked else "taken as tracks of one frame"
        untied = plural(len(boxes), "box has", "boxes have")
        self._validator.repair(f"{self._file}: {untied} no track id: {how}.")
        self._boxes.clear()


def link(boxes: list[_Box]) -> list[int]:
    """Track number of each box; tracks are numbered in the order in which they begin."""
    order = sorted(range(len(boxes)), key=lambda k: (boxes[k].frame, k))
    number = [-1] * len(boxes)
    last: dict[int, int] = {}
    before: dict[int, int] = {}
    tracks = 0
    at = 0
    while at < len(order):
        frame = boxes[order[at]].frame
        end = at
        while end < len(order) and boxes[order[end]].frame == frame:
            end += 1
        now = order[at:end]
        last = {track: k for track, k in last.items() if frame - boxes[k].frame <= GAP + 1}
        for track, k in _pairs(boxes, last, before, now):
            number[k] = track
            before[track] = last[track]
        for k in now:
            if number[k] < 0:
                number[k] = tracks
                tracks += 1
            last[number[k]] = k
        at = end
    return number


def _pairs(boxes: list[_Box], last: dict[int, int], before: dict[int, int], now: list[int]) -> list[tuple[int, int]]:
    """Joined pairs of track and box; ``last`` and ``before`` are the two latest boxes of each track."""
    if not last:
        return []
    tracks = list(last)
    overlap = _iou(
        np.array([_expected(boxes, last[t], before.get(t), boxes[now[0]].frame) for t in tracks]),
        np.array([boxes[k].edges for k in now]),
    )
    same = np.array([[boxes[last[t]].label == boxes[k].label for k in now] for t in tracks])
    rows, columns = np.nonzero(overlap >= LEAST_IOU)
    best = np.lexsort((columns, rows, -overlap[rows, columns], ~same[rows, columns]))
    taken_rows: set[int] = set()
    taken_columns: set[int] = set()
    out: list[tuple[int, int]] = []
    for row, column in zip(rows[best].tolist(), columns[best].tolist(), strict=True):
        if row not in taken_rows and column not in taken_columns:
            taken_rows.add(row)
            taken_columns.add(column)
            out.append((tracks[row], now[column]))
    return out


def _expected(boxes: list[_Box], last: int, before: int | None, frame: int) -> tuple[float, ...]:
    """The predicted box of a track: its last box, moved by the last step of its centre."""
    end = boxes[last]
    if before is None:
        return end.edges
    start = boxes[before]
    part = (frame - end.frame) / (end.frame - start.frame)
    dx, dy = ((end.edges[k] + end.edges[k + 2] - start.edges[k] - start.edges[k + 2]) / 2 * part for k in (0, 1))
    x1, y1, x2, y2 = end.edges
    return x1 + dx, y1 + dy, x2 + dx, y2 + dy


def _iou(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Intersection over union of each pair, shape (len(a), len(b)); 0 if a box has no area or is not finite."""
    with np.errstate(all="ignore"):  # the boxes have not been checked yet
        return iou(a, b)
