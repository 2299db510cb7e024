"""Window rescoring on the sample drive finds the detections of the scan again, and nothing else."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from sample_videos import SHIPPED
from tsr_engine.detection.acf import AcfDetector
from tsr_engine.detection.refine.box_refinement import move_edges
from tsr_engine.detection.refine.window_rescoring import WindowRescoring
from tsr_engine.evidence.regions import FramePixels, StoredPixels
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.video import open_video
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components
from tsr_engine.records import FloatArray, Picture


@pytest.fixture(scope="module")
def detector() -> AcfDetector:
    found = load_components(Params()).detector
    assert isinstance(found, AcfDetector)
    return found


@pytest.fixture(scope="module")
def rescoring(detector: AcfDetector) -> WindowRescoring:
    return WindowRescoring(detector.model, detector.box_inset, detector.params.refine_passes)


@pytest.fixture(scope="module")
def seen(detector: AcfDetector) -> list[tuple[Picture, FloatArray, float]]:
    """Pictures of the sample drive, a confident detection in each, and its raw score."""

    def sure() -> Iterator[tuple[Picture, FloatArray, float]]:
        with open_video(SHIPPED[0].video) as video:
            for frame in video.frames():
                if frame.ordinal % 6 == 0:
                    found = detector.detect(frame.picture)
                    height, width = frame.picture.shape[:2]
                    for box, score in zip(found.boxes, found.raw_scores, strict=True):
                        if score > 4 and (box[:2] > 2).all() and (box[2:] < [width - 2, height - 2]).all():
                            yield frame.picture, box, float(score)
                            break

    return list(sure())


def test_a_shifted_box_finds_the_detection_again(
    seen: list[tuple[Picture, FloatArray, float]], rescoring: WindowRescoring
) -> None:
    rng = np.random.default_rng(1)
    assert len(seen) >= 10
    before, after = [], []
    for picture, box, _ in seen:
        start = move_edges(box[None], rng.normal(0, [[0.05, 0.05, 0.08, 0.08]]))[0]
        found = rescoring(FramePixels(picture), start)
        assert found is not None
        assert found.score > 0
        before.append(1 - iou(start, box)[0, 0])
        after.append(1 - iou(found.box, box)[0, 0])
    assert np.mean(after) < 0.4 * np.mean(before)


def test_background_gives_no_detection(
    seen: list[tuple[Picture, FloatArray, float]], rescoring: WindowRescoring
) -> None:
    scores = []
    for picture, box, _ in seen:
        side = box[2] - box[0]
        away = box + np.array([1.0, 0, 1, 0]) * (2 * side if box[0] < picture.shape[1] / 2 else -2 * side)
        found = rescoring(FramePixels(picture), away)
        scores += [] if found is None else [found.score]
    assert len(scores) > len(seen) / 2
    assert np.mean(np.array(scores) < 0) > 0.9


def test_stored_regions_suffice_for_rescoring(
    seen: list[tuple[Picture, FloatArray, float]], rescoring: WindowRescoring
) -> None:
    for picture, box, _ in seen:
        live = FramePixels(picture)
        found = rescoring(live, box)
        stored = StoredPixels(live.width, live.height, live.regions())
        again = rescoring(stored, box)
        assert found is not None
        assert again is not None
        np.testing.assert_array_equal(again.box, found.box)
        assert again.score == found.score
        assert stored.missing == 0


def test_windows_beyond_the_picture_are_not_scored(rescoring: WindowRescoring) -> None:
    pixels = FramePixels(np.zeros((120, 150, 3), np.uint8))
    for box in ([-1.0, 20, 30, 50], [120, 95, 150, 119], [40, 40, 40.5, 60], [np.nan, 20, 30, 50]):
        assert rescoring(pixels, np.array(box)) is None
