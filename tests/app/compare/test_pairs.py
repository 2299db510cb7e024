"""Both boxes at each place of a comparison."""

from __future__ import annotations

import numpy as np

from app.compare.figures import confusion, figures
from app.compare.pairs import Pair
from tsr_engine.evaluation.matching import match
from tsr_engine.track_table import TrackTable


def table(rows: list[tuple[int, int, tuple[float, float, float, float], int]], keys: tuple[str, ...]) -> TrackTable:
    """Rows of frame, track, box and label, in order of frames."""
    frame, track, boxes, labels = zip(*rows, strict=True)
    return TrackTable(np.array(frame), np.array(track), np.array(boxes), np.array(labels), names=keys)


TRUTH = table(
    [
        (3, 0, (10, 10, 30, 30), 14),
        (3, 1, (100, 100, 120, 120), 17),
        (4, 0, (12, 10, 32, 30), 14),
        (4, 1, (104, 100, 124, 120), 17),
    ],
    ("t1", "t2"),
)
RUN = table(
    [
        (3, 0, (10, 10, 30, 30), 13),
        (3, 1, (115, 100, 135, 120), 17),
        (4, 0, (14, 10, 34, 30), 13),
        (9, 1, (200, 100, 220, 120), 2),
    ],
    ("m5", "m6"),
)


def test_a_match_has_its_partner_and_its_iou() -> None:
    found = figures(TRUTH, RUN, match(TRUTH, RUN))["eq7"]
    assert found.frames == [4]
    (pair,) = found.pairs
    assert pair == Pair(
        box=(12, 10, 32, 30), label=14, other="m5", other_box=(14, 10, 34, 30), other_label=13, iou=0.8182
    )


def test_a_missed_box_names_the_box_with_the_largest_overlap() -> None:
    found = figures(TRUTH, RUN, match(TRUTH, RUN))["recall"]
    assert list(zip(found.tracks, found.frames, found.partners, strict=True)) == [("t2", 3, None)]
    assert (found.pairs[0].other, found.pairs[0].iou) == ("m6", round(5 / 35, 4))
    false = figures(TRUTH, RUN, match(TRUTH, RUN))["precision"]
    last = false.pairs[false.frames.index(9)]
    assert (last.box, last.other, last.other_box, last.other_label, last.iou) == (
        (200, 100, 220, 120),
        None,
        None,
        None,
        0,
    )


def test_cells_of_the_matrix_have_pairs_too() -> None:
    cells = confusion(TRUTH, RUN, match(TRUTH, RUN)).cells
    assert all(len(cell.pairs) == len(cell.frames) for cell in cells)
    wrong = next(cell for cell in cells if (cell.reference, cell.candidate) == (14, 13))
    assert [(pair.label, pair.other_label) for pair in wrong.pairs] == [(14, 13)]
    false = next(cell for cell in cells if cell.reference is None and cell.candidate == 2)
    assert false.pairs[0].box == (200, 100, 220, 120)
