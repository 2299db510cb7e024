"""The table of boxes over frames."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tsr_engine.track_table import NO_CLASS, NO_SOURCE, TrackTable

ROWS = [
    (4, 7, (1.0, 2.0, 11.0, 12.0), 14, 0.5, "predicted"),
    (2, 9, (5.0, 5.0, 25.0, 25.0), 13, 0.25, "mine"),
    (2, 7, (-5.0, 2.0, 9.0, 12.0), 14, 0.75, "detected"),
]


def test_rows_in_order_of_frames_and_tracks() -> None:
    table = TrackTable.of_rows(ROWS)
    ordered = table.ordered()
    assert ordered.frame.tolist() == [2, 2, 4]
    assert ordered.track.tolist() == [7, 9, 7]
    assert ordered.source_words() == ["detected", "mine", "predicted"]
    assert [(frame, ordered.rows(at).score.tolist()) for frame, at in ordered.by_frame()] == [
        (2, [0.75, 0.25]),
        (4, [0.5]),
    ]
    assert ordered.within(2, 4).track.tolist() == [7, 9]
    assert len(ordered.within(3, 4)) == 0
    assert TrackTable.joined([ordered.within(0, 3), ordered.within(3, 9)]).boxes.tolist() == ordered.boxes.tolist()


def test_boxes_are_clipped_or_removed_at_the_edge() -> None:
    table = TrackTable.of_rows(ROWS)
    assert table.cut(5, 20).boxes[:, 0].tolist() == [1.0, 5.0, 0.0]
    assert table.inside(5, 20).track.tolist() == [7, 7]


def test_missing_columns_have_defaults() -> None:
    table = TrackTable(np.arange(2), np.zeros(2, np.int64), np.zeros((2, 4)))
    assert table.class_id.tolist() == [NO_CLASS] * 2
    assert table.source.tolist() == [NO_SOURCE] * 2
    assert table.source_words() == ["", ""]
    assert np.isnan(table.score).all()
    assert table.visibility.tolist() == [1.0, 1.0]
    assert not (table.ignore | table.occluded | table.key).any()
    assert list(TrackTable.empty().by_frame()) == []
    assert len(TrackTable.joined([])) == len(TrackTable.of_rows([])) == 0


def test_columns_are_read_only() -> None:
    frame = np.arange(2)
    table = TrackTable(frame, np.zeros(2, np.int64), np.zeros((2, 4)))
    for column in (table.frame, table.boxes, table.class_id, table.rows(slice(0, 1)).boxes):
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 1
    frame[0] = 5  # the caller's own array stays writeable


def test_tables_with_other_sources_are_not_joined() -> None:
    table = TrackTable.of_rows(ROWS)
    with pytest.raises(ValueError, match="one list of sources"):
        TrackTable.joined([table, TrackTable.empty()])
    assert TrackTable.joined([table, table]).source_words() == table.source_words() * 2


@pytest.mark.parametrize(
    ("name", "column"),
    [
        ("track", np.zeros(3, np.int64)),
        ("boxes", np.zeros((2, 3))),
        ("frame", np.zeros(2)),
        ("class_id", np.zeros(2)),
        ("ignore", np.zeros(2, np.int64)),
    ],
)
def test_other_shapes_and_types_are_refused(name: str, column: np.ndarray) -> None:
    columns: dict[str, Any] = {
        "frame": np.arange(2), "track": np.zeros(2, np.int64), "boxes": np.zeros((2, 4)), name: column
    }  # fmt: skip
    with pytest.raises(ValueError, match=rf"TrackTable\.{name} must have shape .* Got \({len(column)}"):
        TrackTable(**columns)
