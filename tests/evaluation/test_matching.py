"""Matching all frames at once against matching them one by one."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from tsr_engine.evaluation.matching import match
from tsr_engine.geometry.boxes import area, intersection, iou, non_overlap
from tsr_engine.track_table import TrackTable

MIN_OVERLAP = 0.5


def one_by_one(reference: TrackTable, candidate: TrackTable) -> tuple[list[tuple[int, int]], list[int]]:
    """Matched rows, and candidate rows that neither match nor are excused."""
    held: dict[int, int] = {}
    matches: list[tuple[int, int]] = []
    justified: set[int] = set()
    for frame in np.unique(candidate.frame):
        rows = np.flatnonzero(candidate.frame == frame)
        here = reference.frame == frame
        counted, ignored = np.flatnonzero(here & ~reference.ignore), np.flatnonzero(here & reference.ignore)
        overlap = iou(reference.boxes[counted], candidate.boxes[rows])
        gain = np.where(overlap >= MIN_OVERLAP, overlap, 0.0)
        kept = [[held.get(sign) == track for track in candidate.track[rows]] for sign in reference.track[counted]]
        gain += 10.0 * (gain > 0) * np.reshape(kept, gain.shape)
        for i, j in zip(*linear_sum_assignment(-gain), strict=True):
            if gain[i, j] > 0:
                matches.append((int(counted[i]), int(rows[j])))
                held[int(reference.track[counted[i]])] = int(candidate.track[rows[j]])
        boxes, cover = candidate.boxes[rows], reference.boxes[ignored]
        own = intersection(boxes, cover) / area(boxes)[:, None]
        justified |= set(rows[(np.maximum(iou(boxes, cover), own) >= MIN_OVERLAP).any(axis=1)].tolist())
    justified |= {row for _, row in matches}
    return matches, [row for row in range(len(candidate)) if row not in justified]


# Sides and places of many values, so that no two assignments of a frame have the same total.
place = st.tuples(st.integers(0, 5), st.integers(0, 3), *[st.floats(0, 12, width=32)] * 2, st.floats(12, 40, width=32))


def table(drawn: list[tuple[int, int, float, float, float]], jitter: float, ignored: bool) -> TrackTable:
    rows = sorted({(f, t): (f, t, x, y, s) for f, t, x, y, s in drawn}.values())
    frame, track = (np.array([row[k] for row in rows], np.int64) for k in (0, 1))
    numbers = np.arange(len(rows))
    x, y, side = (np.array([row[k] for row in rows]) + jitter * np.sin(numbers * (k + 1)) for k in (2, 3, 4))
    boxes = np.column_stack([x, y, x + side, y + side])
    return TrackTable(frame, track, boxes, ignore=(numbers % 4 == 3) & ignored)


@settings(max_examples=150, deadline=None)
@given(st.lists(place, max_size=30), st.lists(place, max_size=30))
def test_all_at_once_equals_one_by_one(
    one: list[tuple[int, int, float, float, float]], two: list[tuple[int, int, float, float, float]]
) -> None:
    reference, candidate = table(one, 0.013, True), table(two, 0.029, False)
    found = match(reference, candidate, MIN_OVERLAP)
    matches, false = one_by_one(reference, candidate)
    assert list(zip(found.reference.tolist(), found.candidate.tolist(), strict=True)) == matches
    assert found.false.tolist() == false
    assert found.error.tolist() == [
        non_overlap(reference.boxes[a], candidate.boxes[b])[0, 0].item() for a, b in matches
    ]
    counted = np.flatnonzero(~reference.ignore)
    assert found.missed.tolist() == np.setdiff1d(counted, found.reference).tolist()
    assert found.counted == len(counted)


def test_boxes_apart_never_match() -> None:
    apart = np.array([[0.0, 0.0, 10.0, 10.0], [50.0, 0.0, 60.0, 10.0]])
    zero = np.zeros(1, np.int64)
    found = match(TrackTable(zero, zero, apart[:1]), TrackTable(zero, zero, apart[1:]), 0.0)
    assert (len(found.reference), found.missed.tolist(), found.false.tolist()) == (0, [0], [0])
