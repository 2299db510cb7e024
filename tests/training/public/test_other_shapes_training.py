"""A small complete training of the detector of other shapes on drawn scenes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.training.public.test_offline import PLAN as SMALL
from tests.training.public.test_offline import check_progress
from tests.training.toy_scenes import make_scene, write_gtsdb
from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.other_shapes import OtherShapes
from tsr_engine.errors import InputError
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.io.models import Component, load_component, save_component
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import Detections
from tsr_engine.training.public.other_shapes import OtherShapesPlan, fit_other_shapes, train_other_shapes
from tsr_engine.training.synthetic.drawn_scenes import DrawnScenesPlan

PLAN = OtherShapesPlan(
    DrawnScenesPlan(scenes=4, each=2, smallest=18, largest=40),
    replace(SMALL, sign_verifier=replace(SMALL.sign_verifier, drawn=0.0, scene_signs=0.5, background=0.5)),
)


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Component:
    scenes = read_gtsdb(write_gtsdb(tmp_path_factory.mktemp("scenes"), 16, 1))
    models = tmp_path_factory.mktemp("models")
    save_component(train_other_shapes(scenes, load_component("detector"), 3, check_progress, PLAN), models)
    return load_component("other_shapes", models)


@pytest.fixture(scope="module")
def beside() -> AcfModel:
    detector = load_component("detector")
    return AcfModel.from_arrays(detector.arrays, detector.params)


def test_figures_cover_every_scene_without_box_refinement(trained: Component) -> None:
    assert trained.figures["pictures"] == 16
    assert trained.data["scenes"] == {"source": "GTSDB", "scenes": 16, "signs": 18}
    assert trained.figures["signs"] == 17, "one has fewer than 20 px"
    assert 0.5 < trained.figures["recall_at_1"] <= 1
    assert not [name for name in trained.arrays if name.startswith("outline_")]


def test_the_detector_finds_unseen_signs_but_no_known_ones(trained: Component, beside: AcfModel) -> None:
    params = DetectorParams(keep_score=-6.0, far_share=0.0, second_core=False)
    others = OtherShapes.from_component(trained, beside, params)
    rng = np.random.default_rng(99)
    found = signs = 0
    for _ in range(8):
        picture, rows = make_scene(rng)
        truth = np.array(rows)[:, :4]
        seen = others.detect(picture, Detections.empty())
        assert (np.diff(seen.scores) <= 0).all()
        hit = iou(truth, seen.boxes).max(axis=1, initial=0) >= 0.5
        found, signs = found + int(hit.sum()), signs + len(truth)
        sure = Detections(truth, *(np.full(len(truth), value) for value in (0.5, 0.5, 0.5)))
        rest = others.detect(picture, sure)
        assert iou(truth, rest.boxes).max(initial=0) <= 0.35
        assert len(rest) < len(seen) or not hit.any()
        weak = replace(sure, raw_scores=np.full(len(truth), -50.0))
        assert len(others.detect(picture, weak)) == len(seen), "a better box stays"
    assert found > 0.7 * signs


def test_scenes_without_a_sign_are_refused(beside: AcfModel) -> None:
    with pytest.raises(InputError, match="scenes with annotated signs"):
        fit_other_shapes([], beside, PLAN, 0, check_progress)


def test_a_missing_array_is_named(trained: Component, beside: AcfModel) -> None:
    arrays = {name: array for name, array in trained.arrays.items() if name != "cascade_leaves"}
    with pytest.raises(ValueError, match="'cascade_leaves'"):
        OtherShapes.from_component(replace(trained, arrays=arrays), beside, DetectorParams())
