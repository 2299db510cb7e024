"""Makes runs with known faults from the ground truth of a clip, which a simulated annotator corrects."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from tsr_engine.records import FloatArray
from tsr_engine.track_table import TrackTable

KINDS = ("right", "label", "box", "end", "box, label and end", "missed")
"""Faults of labelled signs in the rounds; signs without a label have no faults."""
CSV_HEAD = "frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore"
"""First line of a table of the format ``tracks-csv``."""
ROUNDS = 3
"""Number of runs of a clip; with two signs, each kind occurs once."""
_FALSE_FRAMES = 14
_EXTRA_FRAMES = 12
"""Number of frames by which a track with a wrong end is too long."""
_BOX_SHIFT = 0.4
"""Displacement of a wrong box, as a share of its width."""
_MIN_FRAMES = 10
_MIN_WIDTH_PX = 14.0


@dataclass(slots=True)
class Case:
    """One track of a run, or one sign that it lacks.

    Attributes:
        kind: one of ``KINDS``, or ``false`` for a track on no sign.
        label: the correct label; -1: no label.
        truth: frame -> box of the sign, shape (4,); empty: no sign.
        box_frame: frame of the wrong box, in which the sign is largest and not cut off.
        wrong_box: the run's box in that frame, shape (4,).
    """

    kind: str
    label: int = -1
    truth: dict[int, FloatArray] = field(default_factory=dict)
    box_frame: int = -1
    wrong_box: FloatArray = field(default_factory=lambda: np.zeros(4))

    @property
    def faults(self) -> frozenset[str]:
        """The faults to correct, of ``box``, ``label`` and ``end``."""
        return frozenset(name for name in ("box", "label", "end") if name in self.kind)

    @property
    def first(self) -> int:
        """First frame of the sign."""
        return min(self.truth)

    @property
    def last(self) -> int:
        """Last frame of the sign."""
        return max(self.truth)


def make_faulty_run(
    truth: TrackTable, size: tuple[int, int], frames: int, turn: int, seed: int
) -> tuple[bytes, dict[int, Case]]:
    """A run as a table of the format ``tracks-csv``, and its faults.

    Args:
        truth: ground truth of the clip.
        size: width and height of its picture, px.
        frames: number of frames of the clip.
        turn: 0 to ``ROUNDS`` - 1; selects the kinds of faults.
        seed: random seed of the place of the false track.

    Returns:
        The table; cases by number of the track, missed signs by negative numbers.
    """
    rng = np.random.default_rng([seed, turn])
    cases: dict[int, Case] = {}
    lines = [CSV_HEAD]
    named = 0
    for number, (label, boxes) in enumerate(_signs(truth), start=1):
        kind = KINDS[(2 * turn + named) % len(KINDS)] if label >= 0 else "right"
        named += label >= 0
        where = _largest(boxes, size)
        case = Case(kind, label, boxes, where)
        if "end" in kind and case.last + 2 >= frames:  # there are no frames behind it to add
            case.kind = kind = "box" if kind == "end" else "box and label"
        cases[-number if kind == "missed" else number] = case
        if kind != "missed":
            lines += _rows(number, case, size, frames)
    number = len(cases) + 1
    cases[number] = Case("false")
    lines += _false_track(number, truth, size, frames, rng)
    return "\n".join(lines).encode(), cases


def _signs(truth: TrackTable) -> Iterator[tuple[int, dict[int, FloatArray]]]:
    """Label and boxes of each sign that is large enough and visible long enough."""
    for sign in np.unique(truth.track):
        rows = np.flatnonzero(truth.track == sign)
        widths = truth.boxes[rows, 2] - truth.boxes[rows, 0]
        rows = rows[(widths >= _MIN_WIDTH_PX / 2)]
        if len(rows) < _MIN_FRAMES or widths.max() < _MIN_WIDTH_PX:
            continue
        values, counts = np.unique(truth.class_id[rows], return_counts=True)
        boxes = dict(zip(truth.frame[rows].tolist(), truth.boxes[rows], strict=True))
        span = range(min(boxes), max(boxes) + 1)
        if len(boxes) == len(span):  # a sign with a gap would be two tracks
            yield int(values[counts.argmax()]), boxes


def _largest(boxes: Mapping[int, FloatArray], size: tuple[int, int]) -> int:
    edge = np.array([0.0, 0.0, *size])
    whole = [frame for frame, box in boxes.items() if (np.abs(box - edge) > 2).all()] or list(boxes)
    return max(whole, key=lambda frame: float(boxes[frame][2] - boxes[frame][0]))


def _rows(number: int, case: Case, size: tuple[int, int], frames: int) -> Iterator[str]:
    label = case.label if "label" not in case.faults else (case.label + 7) % 43
    last = case.truth[case.last]
    for frame in range(case.first, case.last + 1):
        box = case.truth[frame]
        if "box" in case.faults and frame == case.box_frame:
            way = _BOX_SHIFT * (box[2] - box[0])
            right = np.array([way, 0, way, 0])
            box = case.wrong_box = box + (right if box[2] + way < size[0] else -right)
        yield csv_row(frame, number, box, label)
    if "end" in case.faults:
        for frame in range(case.last + 1, min(frames, case.last + 1 + _EXTRA_FRAMES)):
            yield csv_row(frame, number, last, label)


def _false_track(
    number: int, truth: TrackTable, size: tuple[int, int], frames: int, rng: np.random.Generator
) -> Iterator[str]:
    start = int(rng.integers(0, max(1, frames - _FALSE_FRAMES)))
    near = truth.boxes[(truth.frame >= start) & (truth.frame < start + _FALSE_FRAMES)]
    while True:
        x, y = rng.uniform(0, size[0] - 40), rng.uniform(0, size[1] - 40)
        if not ((near[:, 0] < x + 60) & (near[:, 2] > x - 20) & (near[:, 1] < y + 60) & (near[:, 3] > y - 20)).any():
            break
    for frame in range(start, min(frames, start + _FALSE_FRAMES)):
        yield csv_row(frame, number, np.array([x, y, x + 30, y + 30]), 14)


def csv_row(frame: int, number: int, box: FloatArray, label: int) -> str:
    """A box of a track in a table of the format ``tracks-csv``."""
    return f"{frame},{number},{','.join(f'{value:.2f}' for value in box)},{label},1,0"
