"""Annotated frames: every stage has its own colour, labels do not overlap, the source is unchanged."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.io.overlay import DETECTION_COLOUR, PREDICTION_COLOUR, SOURCE_COLOURS, draw
from tsr_engine.records import (
    Detections,
    FrameEvidence,
    GateVerdict,
    Prediction,
    Recognition,
    Relocalisation,
    Source,
    TrackFrame,
    TrackState,
)

NAMES = {14: "Stop", 13: "Vorfahrt gewähren"}
GREY = 90


def recognition(class_id: int) -> Recognition:
    probabilities = np.zeros(43, np.float32)
    probabilities[class_id] = 1
    return Recognition(probabilities, 30.0, 1.0, probabilities.astype(np.float64), class_id, 0.93, 2)


def track(
    box: list[float], source: Source, track_id: int = 1, state: TrackState = "confirmed", class_id: int = 14
) -> TrackFrame:
    corners = np.array(box, dtype=np.float64)
    found = None
    if source == "relocalised":
        outer = corners + np.array([-30, -30, 30, 30])
        found = Relocalisation(outer, corners + 1, 1.2, 0.8, corners, 0.3, 220)
    return TrackFrame(
        track_id,
        state,
        source,
        corners,
        3.0,
        Prediction(corners + np.array([-12, -12, 12, 12]), np.eye(4)),
        None,
        None if source == "detected" else GateVerdict(0.5, 2.0, 10.0, 3.0, 60.0, source == "predicted"),
        found,
        (),
        recognition(class_id),
    )


def evidence(
    *tracks: TrackFrame, size: tuple[int, int] = (960, 540), boxes: list[list[float]] | None = None
) -> FrameEvidence:
    corners = np.array(boxes or [], dtype=np.float64).reshape(-1, 4)
    ones = np.ones(len(corners))
    detections = Detections(corners, ones, ones / 2, ones)
    return FrameEvidence(41, 1.64, size[0], size[1], detections, (0.0, 0.0), tuple(tracks), (), (), {})


def blank_picture(size: tuple[int, int] = (960, 540)) -> np.ndarray:
    return np.full((size[1], size[0], 3), GREY, np.uint8)


def count(picture: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int((np.abs(picture.astype(int) - colour).max(axis=-1) <= 6).sum())


@pytest.mark.parametrize("source", ["detected", "predicted", "relocalised"])
def test_results_have_the_colour_of_their_source(source: Source) -> None:
    picture = blank_picture()
    drawn = draw(picture, evidence(track([400, 200, 460, 260], source)), NAMES, legend=False)
    present = {name for name, colour in SOURCE_COLOURS.items() if count(drawn, colour) > 150}
    assert present == {source}
    assert (picture == GREY).all(), "the source picture stays"
    assert drawn.shape == picture.shape
    assert drawn.dtype == np.uint8


def test_the_sign_is_not_covered() -> None:
    drawn = draw(blank_picture(), evidence(track([400, 200, 412, 212], "detected")), NAMES, legend=False)
    assert (drawn[202:210, 402:410] == GREY).all()


def test_every_stage_is_visible() -> None:
    drawn = draw(
        blank_picture(),
        evidence(track([400, 200, 460, 260], "relocalised"), boxes=[[700, 100, 730, 130]]),
        NAMES,
        legend=False,
    )
    assert count(drawn[90:140, 690:740], DETECTION_COLOUR) > 60
    assert count(drawn, PREDICTION_COLOUR) > 60
    edge = drawn[168:173, 370:490]
    assert count(edge, SOURCE_COLOURS["relocalised"]) > 10, "the search region's upper edge"
    assert count(edge, SOURCE_COLOURS["relocalised"]) < edge.shape[1] * 3, "in dots"


def test_labels_do_not_cover_boxes_or_each_other() -> None:
    boxes = [[400.0, 200, 440, 240], [400.0, 245, 440, 285], [445.0, 200, 485, 240]]
    tracks = [track(box, "detected", number) for number, box in enumerate(boxes, 1)]
    drawn = draw(blank_picture(), evidence(*tracks), NAMES, legend=False)
    for x1, y1, x2, y2 in boxes:
        inner = drawn[int(y1) + 14 : int(y2) - 14, int(x1) + 14 : int(x2) - 14]
        assert (inner == GREY).all()


def test_tentative_tracks_have_no_label() -> None:
    quiet = draw(
        blank_picture(), evidence(track([400, 200, 460, 260], "detected", state="tentative")), NAMES, legend=False
    )
    loud = draw(blank_picture(), evidence(track([400, 200, 460, 260], "detected")), NAMES, legend=False)
    assert (quiet[50:] != GREY).any(axis=-1).sum() < (loud[50:] != GREY).any(axis=-1).sum() / 2


def test_the_class_name_is_written() -> None:
    one = draw(blank_picture(), evidence(track([400, 200, 460, 260], "detected", class_id=13)), NAMES)
    other = draw(blank_picture(), evidence(track([400, 200, 460, 260], "detected", class_id=14)), NAMES)
    nameless = draw(blank_picture(), evidence(track([400, 200, 460, 260], "detected", class_id=14)), [])
    assert (one != other).any()
    assert (nameless != other).any()


@pytest.mark.parametrize("size", [(64, 48), (321, 241), (720, 576), (1920, 1080), (3840, 2160)])
def test_any_size_and_boxes_beyond_the_frame(size: tuple[int, int]) -> None:
    width, height = size
    tracks = [
        track([-20, -20, 10, 10], "relocalised", 1),
        track([width - 5, height - 5, width + 40, height + 40], "predicted", 2),
        track([width + 50, 5, width + 80, 35], "detected", 3),
        track([5, 5, 5, 5], "predicted", 4),
    ]
    drawn = draw(blank_picture(size), evidence(*tracks, size=size, boxes=[[-9, -9, 4, 4]]), NAMES)
    assert drawn.shape == (height, width, 3)
    assert (drawn != GREY).any()


def test_an_empty_frame_has_header_and_legend_only() -> None:
    drawn = draw(blank_picture(), evidence(), NAMES)
    changed = (drawn != GREY).any(axis=-1)
    assert changed[:40, :300].any()
    assert changed[-150:, :200].any()
    assert not changed[60:-160].any()
    assert not changed[:, 320:].any()


def test_another_size_of_picture_is_refused() -> None:
    with pytest.raises(ValueError, match=r"shape \(540, 960, 3\). Got \(540, 950, 3\)"):
        draw(blank_picture()[:, :950], evidence(), NAMES)
