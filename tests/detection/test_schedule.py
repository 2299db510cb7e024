"""A scan that is spread over several frames."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sample_videos import SHIPPED
from tsr_engine.detection.acf import AcfDetector
from tsr_engine.detection.scan_schedule import bands_of_frame, rows_of
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.video import open_video
from tsr_engine.params import Params
from tsr_engine.pipeline import VideoDetector, load_detector
from tsr_engine.records import Detections, Picture

TURNS = 3


@given(st.integers(2, 12), st.integers(0, 500), st.integers(1, 3), st.floats(0.0, 60.0))
def test_each_cycle_searches_everything_once(turns: int, start: int, smallest: int, reach: float) -> None:
    bands = [(40.0, 300.0), (40.0, 300.0), (0.0, 360.0), (0.0, 360.0)]
    seen: list[list[tuple[float, float]]] = [[] for _ in bands]
    for frame in range(start, start + turns):
        for i, band in enumerate(bands_of_frame(bands, range(smallest), [reach] * 4, frame, turns)):
            if band is not None:
                seen[i].append(band)
    for i, (parts, (low, high)) in enumerate(zip(seen, bands, strict=True)):
        assert len(parts) == (turns - 1 if i < smallest else 1)
        ordered = sorted(parts)
        assert ordered[0][0] == low
        assert ordered[-1][1] == high
        for (_, above), (below, _) in pairwise(ordered):
            assert above - below >= min(2 * reach, above - low, high - below) - 1e-9


def test_bands_get_complete_rows() -> None:
    assert rows_of([None, (10.4, 20.2), (12.0, 30.7)], 100) == (10, 31)
    assert rows_of([(-3.0, 200.0)], 100) == (0, 100)
    assert rows_of([None], 100) == (0, 100)


@pytest.fixture(scope="module")
def detector() -> AcfDetector:
    return load_detector(Params().with_settings([("scan_turns", TURNS)]))


@pytest.fixture(scope="module")
def picture() -> Picture:
    with open_video(SHIPPED[0].video) as video:
        return video.read(60).picture


def clear_detections(found: Detections) -> Detections:
    return found.select(found.scores > 2)


def test_a_cycle_finds_what_one_scan_finds(detector: AcfDetector, picture: Picture) -> None:
    whole = clear_detections(detector.detect(picture))
    parts = [clear_detections(detector.detect_part(picture, frame)) for frame in range(7, 7 + TURNS)]
    assert len(whole)
    found = np.concatenate([part.boxes for part in parts])
    assert (iou(whole.boxes, found).max(axis=1) > 0.7).all()
    assert (iou(found, whole.boxes).max(axis=1) > 0.7).all()


def test_an_expected_sign_is_found_in_every_band(detector: AcfDetector, picture: Picture) -> None:
    whole = clear_detections(detector.detect(picture))
    shaken = whole.boxes + 0.1 * np.tile(whole.boxes[:, 2:] - whole.boxes[:, :2], 2)
    for frame in range(TURNS):
        found = detector.revisit(picture, detector.detect_part(picture, frame), shaken)
        assert (iou(whole.boxes, found.boxes).max(axis=1) > 0.7).all()
        assert len(clear_detections(found)) == len(whole), "each sign once"
        assert (np.diff(found.scores) <= 0).all()


def test_nothing_is_expected_outside_the_picture(detector: AcfDetector, picture: Picture) -> None:
    height, width = picture.shape[:2]
    outside = np.array([[width - 10.0, 50.0, width + 30.0, 90.0], [-900.0, 0.0, -860.0, 40.0]])
    road = np.array([[width / 2, height - 60.0, width / 2 + 40.0, height - 20.0]])
    for places in (outside, road, np.zeros((0, 4))):
        found = detector.revisit(picture, Detections.empty(), places)
        assert len(clear_detections(found)) == 0


@pytest.mark.parametrize("band", [(0.5, 0.5), (0.9, 0.1), (1.0, 1.0)])
def test_a_band_without_rows_holds_no_small_sign(band: tuple[float, float], picture: Picture) -> None:
    settings = [("scan_turns", TURNS), ("far_top", band[0]), ("far_bottom", band[1])]
    detector = load_detector(Params().with_settings(settings))
    for frame in range(TURNS - 1):
        assert len(detector.detect_part(picture, frame)) == 0


@pytest.mark.parametrize("shape", [(1, 1, 3), (20, 20, 3), (30, 400, 3)])
def test_a_picture_of_few_scales_is_scanned_in_bands(shape: tuple[int, int, int], detector: AcfDetector) -> None:
    for frame in range(TURNS):
        assert len(detector.detect_part(np.zeros(shape, np.uint8), frame)) == 0


def test_the_first_frame_of_a_video_is_scanned_whole(detector: AcfDetector, picture: Picture) -> None:
    of_video = VideoDetector(detector)
    for frame, wanted in ((0, detector.detect(picture)), *((n, detector.detect_part(picture, n)) for n in (1, 2, 3))):
        assert np.array_equal(of_video.detect(frame, picture).boxes, wanted.boxes)


def test_only_a_scan_in_bands_needs_expected_boxes(detector: AcfDetector, picture: Picture) -> None:
    found = Detections.empty()
    assert VideoDetector(detector).revisit(picture, found) is not None
    assert VideoDetector(load_detector(Params())).revisit(picture, found) is None
