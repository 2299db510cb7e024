"""Scenes as other cameras would have taken them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.corruptions.cameras import VERSIONS, by_version, version
from tests.training.toy_scenes import write_gtsdb
from tsr_engine.detection.acf import AcfDetector
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.io.pictures import read_picture
from tsr_engine.params import Params
from tsr_engine.pipeline import load_detector


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    folder = write_gtsdb(tmp_path_factory.mktemp("scenes"), 2, 1)
    return next(scene for scene in read_gtsdb(folder) if len(scene.boxes))


@pytest.mark.parametrize("name", VERSIONS)
def test_a_version_is_reproducible_and_keeps_the_signs(name: str, scene: Scene) -> None:
    taken = read_picture(scene.path)
    seen, boxes = version(name, taken, scene, 0)
    again, _ = version(name, taken, scene, 0)
    np.testing.assert_array_equal(seen, again)
    assert np.array_equal(seen, taken) == (name == "as taken")
    factor = seen.shape[1] / taken.shape[1]
    np.testing.assert_allclose(boxes, scene.boxes * [factor, 1, factor, 1])
    assert seen.shape[0] == taken.shape[0]


def test_every_sign_is_counted_once_per_version(scene: Scene) -> None:
    detector = load_detector(Params().with_settings([("second_core", False)]))
    assert isinstance(detector, AcfDetector)
    found = by_version(detector, [scene], 0, lambda *_: None)
    assert set(found) == set(VERSIONS)
    for row in found.values():
        assert (row["pictures"], row["signs"]) == (1, len(scene.boxes))
        assert row["found"] <= row["signs"]
        assert row["candidates"] <= row["signs"]


def test_found_signs_and_false_detections_are_counted(scene: Scene, tmp_path: Path) -> None:
    class Knows(AcfDetector):
        def __init__(self) -> None:
            pass

        def candidates(self, picture):  # type: ignore[no-untyped-def]
            return scene.boxes, np.ones(len(scene.boxes))

        def detect(self, picture):  # type: ignore[no-untyped-def]
            from tsr_engine.records import Detections

            boxes = np.concatenate([scene.boxes, [[0.0, 0.0, 12.0, 12.0]]])
            scores = np.ones(len(boxes))
            return Detections(boxes, scores, scores, scores)

    row = by_version(Knows(), [scene], 0, lambda *_: None)["as taken"]
    assert (row["candidates"], row["found"], row["nothing"]) == (len(scene.boxes), len(scene.boxes), 1)
