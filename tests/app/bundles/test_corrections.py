"""Corrections in the frames of a clip."""

from __future__ import annotations

from typing import Any

import pytest

from app.bundles.corrections import shift_document, with_engine_label
from app.edits.documents import KeyFrame, Segment, TrackDoc

BOX = (0.0, 0.0, 10.0, 10.0)
ENDED = (Segment(track=7, first=0, last=50),)
"""An engine track that ends before the clip, which has the frames 55 to 89."""


def shifted(spans: dict[int, tuple[int, int]] | None = None, **content: Any) -> TrackDoc | None:
    return shift_document(TrackDoc(key="m7", **{"segments": ENDED, **content}), 55, 90, 50, spans or {})


def test_boxes_drawn_after_the_end_of_an_engine_track_are_kept() -> None:
    found = shifted(keys={"52": KeyFrame(box=BOX), "55": KeyFrame(box=BOX), "80": KeyFrame(box=BOX)})
    assert found is not None
    assert not found.segments
    assert found.keys == {"5": KeyFrame(box=BOX), "30": KeyFrame(box=BOX)}


def test_a_track_of_the_clip_merged_into_an_ended_one_is_kept() -> None:
    found = shifted({4: (2, 30)}, segments=(*ENDED, Segment(track=4, first=51, last=80)))
    assert found is not None
    assert found.segments == (Segment(track=4, first=2, last=30),)


@pytest.mark.parametrize("pauses", [True, False])
def test_boxes_of_a_line_that_is_interrupted_in_the_clip_are_kept(pauses: bool) -> None:
    """A line across the clip is shown in one half of it; a key frame without a box shows the engine's in the other."""
    line = {
        "40": KeyFrame(box=(40.0, 0.0, 50.0, 10.0), interpolate=pauses),
        "70": KeyFrame(occluded=True, interpolate=not pauses),
        "100": KeyFrame(box=(100.0, 0.0, 110.0, 10.0)),
    }
    found = shifted(keys=line)
    assert found is not None
    shown = range(55, 70) if pauses else range(70, 90)
    assert [f for f in range(55, 90) if found.line_at(f - 50) is not None] == [*shown]
    assert all(found.line_at(f - 50) == pytest.approx((f, 0.0, f + 10.0, 10.0)) for f in shown)


@pytest.mark.parametrize(("present", "label"), [({4, 7}, None), ({4}, 14), (set(), 14)])
def test_a_document_keeps_a_label_that_the_clip_lacks(present: set[int], label: int | None) -> None:
    merged = TrackDoc(key="m7", segments=(*ENDED, Segment(track=4, first=51, last=80)))
    assert with_engine_label(merged, {4: 3, 7: 14}, present).class_id == label
    assert with_engine_label(merged, {4: 3, 7: -1}, present).class_id is None
    own = merged.model_copy(update={"class_id": 5})
    assert with_engine_label(own, {4: 3, 7: 14}, present) == own


@pytest.mark.parametrize("bare", [55, 89])
def test_interpolated_boxes_are_kept_if_a_key_frame_without_a_box_ends_the_clip(bare: int) -> None:
    line = {
        "40": KeyFrame(box=(40.0, 0.0, 50.0, 10.0), interpolate=True),
        str(bare): KeyFrame(occluded=True, interpolate=True),
        "100": KeyFrame(box=(100.0, 0.0, 110.0, 10.0)),
    }
    found = shifted(keys=line)
    assert found is not None
    assert [found.line_at(frame - 50) for frame in (55, 70, 89)] == [(f, 0.0, f + 10.0, 10.0) for f in (55, 70, 89)]
    assert found.keys[str(bare - 50)].occluded


@pytest.mark.parametrize(("gap", "shown"), [((50, 60), range(60, 90)), ((80, 95), range(55, 80))])
def test_interpolated_boxes_are_kept_if_the_clip_ends_in_a_gap_of_the_line(gap: tuple[int, int], shown: range) -> None:
    line = {
        "40": KeyFrame(box=(40.0, 0.0, 50.0, 10.0), interpolate=True),
        str(gap[0]): KeyFrame(),
        str(gap[1]): KeyFrame(interpolate=True),
        "100": KeyFrame(box=(100.0, 0.0, 110.0, 10.0)),
    }
    found = shifted(keys=line)
    assert found is not None
    boxes = {f: found.line_at(f - 50) for f in range(55, 90)}
    assert {f: box for f, box in boxes.items() if box} == {f: pytest.approx((f, 0, f + 10, 10)) for f in shown}


@pytest.mark.parametrize(
    "content",
    [
        {},
        {"class_id": 3},
        {"keys": {"52": KeyFrame(box=BOX)}},
        {"keys": {"60": KeyFrame(occluded=True)}},
        {"keys": {"60": KeyFrame(box=BOX, outside=True)}},
        {"keys": {"60": KeyFrame(box=BOX)}, "gone": True},
    ],
)
def test_an_ended_track_that_shows_nothing_in_the_clip_is_left_out(content: dict[str, Any]) -> None:
    assert shifted(**content) is None
    assert shifted({7: (0, 0)}, **content) is not None
