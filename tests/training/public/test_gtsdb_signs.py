"""Annotations of other signs: their effect on scenes, and errors about damaged ones."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.training.toy_scenes import write_gtsdb
from tsr_engine.channels.pyramid import PyramidPlan
from tsr_engine.detection.window import Window
from tsr_engine.errors import InputError
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.labels.files import shipped_set
from tsr_engine.training.public.gtsdb_signs import ignoring, other_signs, read_signs
from tsr_engine.training.public.mining import background_windows

PARKING = {"id": 1, "scene": "00000", "box": [10.0, 20.0, 40.0, 50.0], "label": "parking"}
SIGN = {**PARKING, "kind": "sign", "ignore": False, "reason": ""}
PLATE = {**SIGN, "id": 2, "box": [10.0, 52.0, 40.0, 64.0], "label": "time-panel", "kind": "plate"}
BOARD = {**SIGN, "id": 3, "scene": "00001", "label": None, "kind": "board", "ignore": True, "reason": "board"}


def write(path: Path, *signs: dict[str, Any], label_set: str = "vienna") -> Path:
    path.write_text(json.dumps({"about": "", "label_set": label_set, "figures": {}, "signs": signs}))
    return path


def scenes(*names: str) -> list[Scene]:
    one = np.array([[100.0, 100, 130, 130]])
    return [Scene(f"{name}.jpg", Path(f"{name}.jpg"), one, np.array([12])) for name in names]


def test_every_annotated_place_is_ignored_beside_the_signs_of_the_scene(tmp_path: Path) -> None:
    found = ignoring(scenes("00000", "00001", "00002"), read_signs(write(tmp_path / "a.json", SIGN, PLATE, BOARD)))
    assert [scene.ignored.tolist() for scene in found] == [[SIGN["box"], PLATE["box"]], [BOARD["box"]], []]
    assert [scene.boxes.tolist() for scene in found] == [[[100, 100, 130, 130]]] * 3
    assert [scene.class_ids.tolist() for scene in found] == [[12]] * 3


def test_other_signs_are_signs_and_everything_else_is_ignored(tmp_path: Path) -> None:
    first, second = other_signs(scenes("00000", "00001"), read_signs(write(tmp_path / "a.json", SIGN, PLATE, BOARD)))
    labels = {label.key: label.id for label in shipped_set("vienna")}
    assert first.boxes.tolist() == [SIGN["box"]]
    assert first.class_ids.tolist() == [labels["parking"]]
    assert first.ignored.tolist() == [[100, 100, 130, 130], PLATE["box"]]
    assert second.boxes.shape == (0, 4)
    assert second.ignored.tolist() == [[100, 100, 130, 130], BOARD["box"]]


def test_an_annotated_sign_is_not_background(tmp_path: Path) -> None:
    plain = read_gtsdb(write_gtsdb(tmp_path / "gtsdb", 1, 4))
    whole = {**BOARD, "scene": "00000", "box": [-200.0, -200.0, 500.0, 500.0]}
    left = read_signs(write(tmp_path / "a.json", {**BOARD, "scene": "00000", "box": [0.0, 0.0, 130.0, 200.0]}))
    window, plan = Window(), PyramidPlan(2, 4, 1)

    def count(some: list[Scene]) -> int:
        rng = np.random.default_rng(0)
        return len(background_windows(some, window, plan, 300, rng, lambda stage, done, total: None))

    assert count(ignoring(plain, left)) < count(plain)
    assert count(ignoring(plain, read_signs(write(tmp_path / "b.json", whole)))) > 0  # small windows are not the place


@pytest.mark.parametrize(
    ("sign", "words"),
    [
        ({**SIGN, "label": "parkin"}, ["sign 1", "'parkin'", "vienna"]),
        ({**SIGN, "label": None}, ["sign 1", "needs a label"]),
        ({**SIGN, "box": [40.0, 20.0, 10.0, 50.0]}, ["sign 1", "no area"]),
        ({**SIGN, "box": [10.0, 20.0, 40.0]}, ["signs.0.box"]),
        ({**SIGN, "scene": "0"}, ["signs.0.scene"]),
        ({**SIGN, "colour": "blue"}, ["signs.0.colour"]),
    ],
)
def test_a_damaged_annotation_is_named(tmp_path: Path, sign: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        read_signs(write(tmp_path / "a.json", sign))
    assert all(word in str(caught.value) for word in [str(tmp_path / "a.json"), *words])


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="Cannot read the annotations"):
        read_signs(tmp_path / "nowhere.json")
    (tmp_path / "text.json").write_text("signs")
    with pytest.raises(InputError, match="whole file"):
        read_signs(tmp_path / "text.json")
    with pytest.raises(InputError, match="'vienna'"):
        read_signs(write(tmp_path / "a.json", SIGN, label_set="gtsrb-43"))


def test_annotations_of_other_scenes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="None of the annotated signs"):
        ignoring(scenes("00007"), read_signs(write(tmp_path / "a.json", SIGN)))
