"""A small complete training of detector and prior on drawn scenes."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.training.toy_scenes import make_scene, write_gtsdb
from tsr_engine.detection.acf import AcfDetector, AcfModel
from tsr_engine.detection.boosting import BoostingPlan
from tsr_engine.errors import InputError
from tsr_engine.evaluation.detection import score_detections
from tsr_engine.geometry.boxes import non_overlap
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.io.models import Component, load_component, save_component
from tsr_engine.params.detector import DetectorParams, PriorParams
from tsr_engine.protocols import OfflineDetector
from tsr_engine.training.public import refine_stage
from tsr_engine.training.public.box_refinement import BoxRefinementPlan
from tsr_engine.training.public.classifier_network import NetworkSettings
from tsr_engine.training.public.detector import DetectorPlan, fit_detector
from tsr_engine.training.public.detector_components import split_scenes, train_detector, train_prior
from tsr_engine.training.public.refine_stage import RefinementPlan
from tsr_engine.training.public.sign_verifier import SignVerifierPlan

PLAN = DetectorPlan(
    rounds=(24, 48),
    mining_share=(1.0,),
    feature_share=1 / 4,
    jittered=4,
    per_scene=30,
    sign_verifier=SignVerifierPlan(
        steps=40, batch=32, drawn_crops=2, rings=2, network=NetworkSettings(filters=8, hidden=24, warm_up=10)
    ),
    box_refinement=BoxRefinementPlan(
        steps=40, batch=32, network=NetworkSettings(filters=8, hidden=16, warm_up=10, loss="huber")
    ),
    refinement=RefinementPlan(views=1, starts=4, candidates=20, boosting=BoostingPlan(32, 3, 1 / 8, 0.5)),
)

BRIEF = replace(
    PLAN,
    rounds=(4, 8),
    jittered=2,
    per_scene=10,
    sign_verifier=replace(PLAN.sign_verifier, steps=10, batch=16),
    box_refinement=replace(PLAN.box_refinement, steps=10, batch=16),
    refinement=replace(PLAN.refinement, boosting=BoostingPlan(8, 3, 1 / 8, 0.5)),
)
"""Every part of a training, in less time."""


def check_progress(stage: str, done: int, total: int) -> None:
    assert stage
    assert 0 <= done <= total


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_gtsdb(tmp_path_factory.mktemp("scenes"), 24, 1)


@pytest.fixture(scope="module")
def trained(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Component, Component]:
    models = tmp_path_factory.mktemp("models")
    save_component(train_detector(read_gtsdb(folder), None, 3, check_progress, PLAN), models)
    detector = load_component("detector", models)
    save_component(train_prior(read_gtsdb(folder), detector, 3, check_progress), models)
    return detector, load_component("prior", models)


@pytest.fixture(scope="module")
def unseen() -> list[tuple[np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(99)
    scenes = [make_scene(rng) for _ in range(12)]
    return [(picture, np.array(rows)[:, :4]) for picture, rows in scenes]


def test_scenes_too_few_for_a_detector_are_refused_before_its_training(tmp_path: Path) -> None:
    three = read_gtsdb(write_gtsdb(tmp_path / "three", 3, 1))
    with pytest.raises(InputError, match=r"got 3 scenes with \d signs\. Name more annotated scenes\."):
        train_detector(three, None, 3, check_progress, BRIEF)
    without = [replace(s, boxes=s.boxes[:0], class_ids=s.class_ids[:0]) for s in three] * 4
    with pytest.raises(InputError, match="got 12 scenes with 0 signs"):
        train_detector(without, None, 3, check_progress, BRIEF)
    with pytest.raises(InputError, match="scenes with signs to train a detector on, got none"):
        fit_detector(without, [], BRIEF, 3, check_progress)


def test_a_prior_of_other_scenes_than_those_of_the_detector_is_refused(trained, folder: Path, tmp_path: Path) -> None:
    detector, _ = trained
    with pytest.raises(InputError, match="learned from other scenes, or with another seed than 4"):
        train_prior(read_gtsdb(folder), detector, 4, check_progress)
    with pytest.raises(InputError, match="Name its scenes and seed"):
        train_prior(read_gtsdb(write_gtsdb(tmp_path, 24, 2)), detector, 3, check_progress)


def test_a_prior_has_no_weight_if_all_detections_for_calibration_are_alike(trained, folder: Path) -> None:
    detector, _ = trained
    none = {name: values[:0] for name, values in detector.arrays.items() if name.startswith("heldout_")}
    empty = replace(detector, arrays={**detector.arrays, **none})
    assert train_prior(read_gtsdb(folder), empty, 3, check_progress).params["lambda"] == 0


def test_small_pictures_among_the_scenes_are_no_obstacle(trained, tmp_path: Path) -> None:
    detector, _ = trained
    cv2.imwrite(str(tmp_path / "small.png"), np.zeros((9, 12, 3), np.uint8))
    stage = AcfModel.from_arrays(detector.arrays, detector.params).refine_stage
    small = Scene("small.png", tmp_path / "small.png", np.zeros((0, 4)), np.zeros(0, np.int64))
    assert len(refine_stage.windows_anywhere([small], stage, 5, np.random.default_rng(0))) == 5


def make(trained: tuple[Component, Component], **params: object) -> AcfDetector:
    return AcfDetector.from_components(*trained, DetectorParams(**params), PriorParams())


def test_the_detector_finds_unseen_signs(trained, unseen) -> None:
    detector = make(trained, keep_score=-6.0, far_share=0.0)
    assert isinstance(detector, OfflineDetector)
    results, errors = [], []
    for picture, truth in unseen:
        found = detector.detect(picture)
        assert (np.diff(found.scores) <= 0).all()
        results.append((found.boxes, found.scores, truth))
        errors += non_overlap(found.boxes, truth).min(axis=0).tolist() if len(found) else [1.0] * len(truth)
    score = score_detections(results)
    assert score.average_precision > 0.9
    assert np.mean(errors) < 0.2


def test_one_core_and_two_give_the_same_detections(trained, unseen) -> None:
    one, two = make(trained, second_core=False), make(trained, second_core=True)
    for picture, _ in unseen[:4]:
        a, b = one.detect(picture), two.detect(picture)
        assert np.array_equal(a.boxes, b.boxes)
        assert np.array_equal(a.raw_scores, b.raw_scores)


def test_scores_with_prior_are_equation_2(trained, unseen) -> None:
    detector = AcfDetector.from_components(
        *trained, DetectorParams(keep_score=-6.0, far_share=0.0), PriorParams(prior_lambda=2.0)
    )
    found = detector.detect(unseen[0][0])
    np.testing.assert_allclose(found.scores, found.raw_scores + (found.prior - 0.5) * 2.0)
    off = AcfDetector.from_components(*trained, DetectorParams(), PriorParams(use_prior=False)).detect(unseen[0][0])
    assert np.array_equal(off.scores, off.raw_scores)


def test_the_prior_knows_the_side_of_the_road(trained) -> None:
    table = trained[1].arrays["table"]
    half = table.shape[1] // 2
    assert table[:, half:].sum() > 20 * table[:, : half - 16].sum()
    assert trained[1].params["lambda"] >= 0
    assert trained[1].figures["with_prior"]["signs"] == trained[1].figures["raw"]["signs"] > 0


def test_figures_of_the_component(trained) -> None:
    detector, _ = trained
    assert detector.seed == 3
    assert detector.data["scenes"]["scenes"] == 24
    assert detector.data["figures_from"]["trained_on"] + detector.data["figures_from"]["calibrated_on"] < 24
    assert 0 <= detector.figures["ap50"] <= 1
    assert detector.figures["pictures"] == detector.data["figures_from"]["reported_on"]


@pytest.mark.slow
def test_the_seed_decides_every_byte(tmp_path: Path) -> None:
    scenes = read_gtsdb(write_gtsdb(tmp_path / "scenes", 12, 1))
    first, again = (train_detector(scenes, None, 3, check_progress, BRIEF) for _ in range(2))
    assert first.arrays.keys() == again.arrays.keys()
    for name, array in first.arrays.items():
        assert np.array_equal(array, again.arrays[name]), name


def test_scenes_are_never_in_two_parts(folder: Path) -> None:
    parts = split_scenes(read_gtsdb(folder), 5)
    names = [scene.name for part in parts for scene in part]
    assert len(names) == len(set(names)) == 24


def test_a_picture_too_small_for_any_window_is_empty(trained) -> None:
    assert len(make(trained).detect(np.zeros((12, 12, 3), np.uint8))) == 0


def test_a_component_of_another_kind_is_refused(trained) -> None:
    with pytest.raises(ValueError, match="lacks"):
        AcfDetector.from_components(trained[1], None, DetectorParams(), PriorParams())
