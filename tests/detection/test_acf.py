"""The shipped detector on the sample drive gives the same result however its work is split."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from sample_videos import SHIPPED
from tests.detection.random_inputs import INVALID_PICTURES
from tsr_engine.channels.pyramid import Level
from tsr_engine.detection.window import Window
from tsr_engine.io.video import open_video
from tsr_engine.params import Params
from tsr_engine.pipeline import load_detector
from tsr_engine.records import Detections, Picture


@pytest.fixture(scope="module")
def pictures() -> list[Picture]:
    """Frames with signs, one of them cropped so that other levels reuse the memory."""
    with open_video(SHIPPED[0].video) as video:
        found = [video.read(k).picture for k in (20, 60, 100)]
    return [*found, found[1][:-40, :-60].copy()]


def are_equal(a: Detections, b: Detections) -> bool:
    return np.array_equal(a.boxes, b.boxes) and np.array_equal(a.raw_scores, b.raw_scores)


def test_two_cores_give_the_same_result(pictures: list[Picture]) -> None:
    one = load_detector(Params().with_settings([("second_core", False)]))
    two = load_detector(Params().with_settings([("second_core", True)]))
    found = [one.detect(picture) for picture in pictures]
    assert sum(len(f.boxes) for f in found) > 3
    assert all(are_equal(a, two.detect(picture)) for a, picture in zip(found, pictures, strict=True))


def test_several_threads_may_detect_at_once(pictures: list[Picture]) -> None:
    detector = load_detector(Params())
    alone = [detector.detect(picture) for picture in pictures]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(detector.detect, pictures * 5))
    assert all(are_equal(a, b) for a, b in zip(alone * 5, together, strict=True))


@pytest.mark.parametrize("wrong", INVALID_PICTURES)
def test_invalid_pictures_are_refused_with_their_shape(wrong: str) -> None:
    with pytest.raises(ValueError, match="A picture must") as refused:
        load_detector(Params()).detect(INVALID_PICTURES[wrong])
    assert str(INVALID_PICTURES[wrong].shape) in str(refused.value)


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 50, 3), (20, 20, 3)])
def test_a_picture_smaller_than_a_sign_has_no_detection(shape: tuple[int, int, int]) -> None:
    assert len(load_detector(Params()).detect(np.zeros(shape, np.uint8))) == 0


@pytest.mark.parametrize("edge", [0, 1, 2, 3])
def test_a_sign_cut_by_the_edge_is_found(edge: int) -> None:
    with open_video(SHIPPED[0].video) as video:
        whole = video.read(60).picture
    detector = load_detector(Params())
    x1, y1, x2, y2 = detector.detect(whole).boxes[0]
    off = 0.22 * (x2 - x1)
    left, top, right, bottom = (round(v) for v in (x1 + off, y1 + off, x2 - off, y2 - off))
    cut = np.ascontiguousarray((whole[:, left:], whole[top:], whole[:, :right], whole[:bottom])[edge])
    limit = (0, 0, cut.shape[1], cut.shape[0])[edge]
    assert len(found := detector.detect(cut))
    assert found.raw_scores[0] > 2
    assert found.boxes[0, edge] == limit, "the box goes up to the picture's edge"
    inside = load_detector(Params().with_settings([("beyond_edge", 0.0)])).detect(cut)
    at_edge = inside.boxes[:, edge] == limit
    assert (inside.raw_scores[at_edge] < found.raw_scores[0] - 2).all(), "what lies inside is less like a sign"


def test_the_scan_extends_beyond_the_edge_by_the_cut_part_of_a_sign() -> None:
    window = Window(cells=14, shrink=2, sign=24.0)
    assert [window.reaching(share).pad for share in (0.0, 1 / 12, 0.25, 0.26, 0.5)] == [1, 2, 4, 5, 7]
    cells = np.zeros((10, 30, 30), np.uint8)
    level = Level(0, cells, scale_x=1.0, scale_y=1.0, top=0.0, computed=True, gains=np.ones(10))
    # The first window begins a quarter of a sign outside.
    assert window.reaching(0.25).to_boxes([0], [0], level)[0].tolist() == [-6.0, -6.0, 18.0, 18.0]
