"""Scenes with drawn signs: their positions, and the background around them."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from tests.training.toy_scenes import write_gtsdb
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.labels.files import shipped_set
from tsr_engine.training.synthetic import drawn_scenes as module
from tsr_engine.training.synthetic.drawn_scenes import COMMON, DrawnScenesPlan, drawn_keys, drawn_scenes

PLAN = DrawnScenesPlan(scenes=6, each=3, smallest=16, largest=40)


def make(tmp_path: Path, seed: int, name: str = "drawn") -> tuple[list[Scene], list[Scene]]:
    grounds = read_gtsdb(write_gtsdb(tmp_path / "gtsdb", 4, 3))
    (tmp_path / name).mkdir()
    return grounds, drawn_scenes(grounds, PLAN, tmp_path / name, np.random.default_rng(seed))


def test_drawn_signs_do_not_overlap_other_signs(tmp_path: Path) -> None:
    _, drawn = make(tmp_path, 1)
    ids = {label.id for label in shipped_set("vienna")}
    assert len(drawn) == PLAN.scenes
    assert sum(len(scene.boxes) for scene in drawn) > PLAN.scenes
    for scene in drawn:
        height, width = cv2.imread(str(scene.path)).shape[:2]
        assert len(scene.class_ids) == len(scene.boxes)
        assert set(scene.class_ids.tolist()) <= ids
        assert (scene.boxes >= 0).all()
        assert (scene.boxes <= [width, height, width, height]).all()
        assert np.triu(iou(scene.occupied, scene.occupied), 1)[: len(scene.boxes)].max(initial=0) == 0


def test_the_seed_decides_every_scene(tmp_path: Path) -> None:
    _, one = make(tmp_path, 1, "one")
    _, same = make(tmp_path, 1, "same")
    _, other = make(tmp_path, 2, "other")
    assert [s.path.read_bytes() for s in one] == [s.path.read_bytes() for s in same]
    assert [s.path.read_bytes() for s in one] != [s.path.read_bytes() for s in other]


def test_the_background_is_visible_around_a_triangle() -> None:
    picture = np.full((200, 200, 3), 120, np.uint8)
    sign = module.turned(module.draw("gtsrb/18", 192), DrawnScenesPlan(turn=0.0, squeeze=0.0), np.random.default_rng(0))
    box = np.array([60.0, 60, 140, 60 + round(80 * sign.shape[0] / sign.shape[1])])
    module.paste(picture, sign, box, np.random.default_rng(3))
    top, bottom = 62, int(box[3]) - 4
    assert (picture[top, [64, 70, 130, 136]] == 120).all(), "beside the upper corner"
    assert (picture[bottom, [75, 100, 125]] != 120).any(axis=1).all(), "on the lower edge"
    assert (picture[:50] == 120).all()


def test_drawn_signs_are_outside_the_classes() -> None:
    keys = drawn_keys()
    labels = {label.key: label for label in shipped_set("vienna")}
    assert set(COMMON) <= set(keys)
    assert not {"stop", "place-name", "time-panel", "distances"} & set(keys)
    assert {labels[key].shape for key in keys} == {"circle", "rectangle"}
    assert min(labels[key].id for key in keys) >= 43
