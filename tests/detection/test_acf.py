"""The shipped detector on the sample drive: how its work is shared out changes nothing."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from sample_videos import SHIPPED
from tsr_engine.io.video import open_video
from tsr_engine.params import Params
from tsr_engine.pipeline import load_detector
from tsr_engine.records import Detections, Picture


@pytest.fixture(scope="module")
def pictures() -> list[Picture]:
    """Frames that hold signs, one of them cropped: other levels use the same memory."""
    with open_video(SHIPPED[0].video) as video:
        found = [video.read(k).picture for k in (20, 60, 100)]
    return [*found, found[1][:-40, :-60].copy()]


def same(a: Detections, b: Detections) -> bool:
    return np.array_equal(a.boxes, b.boxes) and np.array_equal(a.raw_scores, b.raw_scores)


def test_a_second_core_finds_the_same(pictures: list[Picture]) -> None:
    one = load_detector(Params().with_settings([("second_core", False)]))
    two = load_detector(Params().with_settings([("second_core", True)]))
    found = [one.detect(picture) for picture in pictures]
    assert sum(len(f.boxes) for f in found) > 3
    assert all(same(a, two.detect(picture)) for a, picture in zip(found, pictures, strict=True))


def test_several_threads_may_ask_at_a_time(pictures: list[Picture]) -> None:
    detector = load_detector(Params())
    alone = [detector.detect(picture) for picture in pictures]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(detector.detect, pictures * 5))
    assert all(same(a, b) for a, b in zip(alone * 5, together, strict=True))
