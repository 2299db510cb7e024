"""Refinements learn corrections and keep earlier abilities."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.training.corrected_tracks import draw_corrected_scenes
from tests.training.toy_scenes import draw_sign
from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.boosting import BoostingPlan, boost_further
from tsr_engine.detection.prior import parzen
from tsr_engine.detection.refine.box_inset import BoxInset
from tsr_engine.geometry.boxes import to_cxcywh, to_xyxy
from tsr_engine.io.models import SHIPPED, Component, load_component
from tsr_engine.io.pictures import read_picture
from tsr_engine.params.detector import DetectorParams
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene
from tsr_engine.training.corrections.refine_classifier import (
    ClassifierRefinement,
    refine_classifier,
    sign_crops,
    with_labels,
)
from tsr_engine.training.corrections.refine_detector import DetectorRefinement, refine_detector
from tsr_engine.training.corrections.refine_online import refine_online
from tsr_engine.training.corrections.refine_prior import blended_table, refined_lambda
from tsr_engine.training.corrections.refine_windows import Cutting, cut_windows, with_margin
from tsr_engine.training.public.memory import Samples, samples_at


def check_progress(stage: str, done: int, total: int) -> None:
    assert stage
    assert 0 <= done <= total


@pytest.fixture(scope="module")
def model() -> AcfModel:
    component = load_component("detector")
    return AcfModel.from_arrays(component.arrays, component.params)


@pytest.fixture(scope="module")
def memory() -> Component:
    return load_component("memory", SHIPPED)


@pytest.fixture(scope="module")
def remembered(memory: Component) -> tuple[Samples, Samples]:
    a = memory.arrays
    return Samples.from_arrays(a, "signs"), Samples.from_arrays(a, "others")


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> list[CorrectedScene]:
    return draw_corrected_scenes(tmp_path_factory.mktemp("scenes"), range(10))


class TestBoosting:
    plan = BoostingPlan(8, 2, 1.0, 0.5, 1.0)

    def data(self) -> tuple[np.ndarray, np.ndarray]:
        rng = np.random.default_rng(0)
        samples = rng.integers(0, 255, (200, 12), dtype=np.uint8)
        return samples, samples[:, 3] > 127

    def test_samples_at_their_target_are_unchanged(self) -> None:
        samples, _ = self.data()
        start = np.random.default_rng(1).normal(0, 2, 200)
        target = 1 / (1 + np.exp(-2 * start))
        trees = boost_further(samples, target, np.ones(200), start, self.plan, np.random.default_rng(2), 14, 1.0)
        assert np.abs(trees.scores(samples)).max() <= 8  # of 256: rounding

    def test_inertia_reduces_the_correction(self) -> None:
        samples, truth = self.data()
        moved = {}
        for inertia in (1.0, 50.0):
            trees = boost_further(
                samples,
                truth.astype(float),
                np.ones(200),
                np.zeros(200),
                self.plan,
                np.random.default_rng(2),
                14,
                inertia,
            )
            scores = trees.scores(samples)
            moved[inertia] = scores[truth].mean() - scores[~truth].mean()
        assert moved[1.0] > 2 * moved[50.0] > 0


def test_loosening_inverts_the_box_inset() -> None:
    boxes = np.array([[10.0, 20, 50, 70], [3, 4, 30, 28]])
    np.testing.assert_allclose(BoxInset.of(DetectorParams()).apply(with_margin(boxes)), boxes)


def _raw(model: AcfModel, scenes: list[CorrectedScene]) -> np.ndarray:
    return np.concatenate(
        [samples_at(model, read_picture(s.scene.path), with_margin(s.scene.boxes)).raw(model) for s in scenes]
    )


def test_a_detector_learns_a_new_look_without_more_false_alarms(
    model: AcfModel, remembered: tuple[Samples, Samples], scenes: list[CorrectedScene]
) -> None:
    settings = DetectorRefinement(trees=24, trees_a_sign=4, feature_share=1 / 8, inertia=2.0)
    refined, notes = refine_detector(model, scenes[:7], remembered, settings, 0, check_progress)
    before, after = _raw(model, scenes[7:]), _raw(refined, scenes[7:])
    assert (after > before).all()
    assert after.mean() > before.mean() + 0.5
    level = [np.quantile(remembered[1].raw(m), 0.97) for m in (model, refined)]
    assert level[1] < level[0] + 0.5
    assert (notes["signs"], notes["windows"], notes["rejected"]) == (7, 7 * 6, 0)
    assert len(refined.refine_stage.verifier) == len(model.refine_stage.verifier) + 24
    assert refined.cascade.features is model.cascade.features


def test_the_seed_decides_and_a_stored_model_is_the_same(
    model: AcfModel, remembered: tuple[Samples, Samples], scenes: list[CorrectedScene]
) -> None:
    settings = DetectorRefinement(cutting=Cutting(views=1, starts=1, background=2))
    one, again, other = (
        refine_detector(model, scenes[:2], remembered, settings, s, check_progress)[0] for s in (1, 1, 2)
    )
    first, second = one.to_arrays(), again.to_arrays()
    assert first[1] == second[1]
    for name, array in first[0].items():
        np.testing.assert_array_equal(array, second[0][name])
    assert not np.array_equal(one.box_refinement.weights, other.box_refinement.weights)
    stored = AcfModel.from_arrays(*first)
    np.testing.assert_array_equal(_raw(stored, scenes[:2]), _raw(one, scenes[:2]))


def test_a_region_to_ignore_gives_no_background(model: AcfModel, tmp_path: Path) -> None:
    (scene,) = draw_corrected_scenes(tmp_path, range(1))
    picture = read_picture(scene.scene.path).copy()
    draw_sign(picture, 30.0, 30.0, 30.0, 0)
    cv2.imwrite(str(scene.scene.path), picture)

    def others(ignored: list[list[float]]) -> int:
        marked = replace(scene, scene=replace(scene.scene, ignored=np.array(ignored).reshape(-1, 4)))
        rng = np.random.default_rng(0)
        return len(cut_windows(model, [marked], list(scene.signs), Cutting(), rng, check_progress).others)

    assert others([]) > 0
    assert others([[0.0, 0.0, 260.0, 200.0]]) == 0, "a region is much larger than a window in it"


def test_the_box_refinement_follows_corrected_boxes(
    model: AcfModel, remembered: tuple[Samples, Samples], scenes: list[CorrectedScene]
) -> None:
    def larger(scene: CorrectedScene) -> CorrectedScene:
        boxes = to_cxcywh(scene.scene.boxes)
        boxes[:, 2:] *= 1.12
        return replace(scene, scene=replace(scene.scene, boxes=to_xyxy(boxes)))

    def width(model: AcfModel, scene: CorrectedScene) -> float:
        boxes = model.box_refinement.refine(read_picture(scene.scene.path), with_margin(scene.scene.boxes))
        return float(to_cxcywh(boxes)[:, 2].mean())

    as_drawn = refine_detector(model, scenes[:7], remembered, DetectorRefinement(), 0, check_progress)[0]
    drawn_larger = refine_detector(
        model, [larger(s) for s in scenes[:7]], remembered, DetectorRefinement(), 0, check_progress
    )[0]
    grown = [width(drawn_larger, s) / width(as_drawn, s) for s in scenes[7:]]
    assert min(grown) > 1.01


def test_rejected_boxes_are_background(
    model: AcfModel, remembered: tuple[Samples, Samples], scenes: list[CorrectedScene]
) -> None:
    wrong = replace(scenes[3], signs=(), rejected=scenes[3].scene.boxes, scene=replace(scenes[3].scene, boxes=np.zeros((0, 4)), class_ids=np.zeros(0, np.int64)))  # fmt: skip  # noqa: E501
    _, notes = refine_detector(model, [scenes[0], wrong], remembered, DetectorRefinement(), 0, check_progress)
    assert notes["rejected"] == 1


def test_nothing_to_learn_from_is_refused(model: AcfModel, scenes: list[CorrectedScene]) -> None:
    with pytest.raises(ValueError, match="1 signs or more. Got 0"):
        refine_detector(
            model, [scenes[0].without(frozenset(scenes[0].signs))], None, DetectorRefinement(), 0, check_progress
        )


def test_a_classifier_learns_a_new_look_and_keeps_known_ones(memory: Component, scenes: list[CorrectedScene]) -> None:
    classifier = SignClassifier.from_component(load_component("classifier"))
    crops = sign_crops(scenes, check_progress)
    assert [item.crop.class_id for item in crops] == [14] * 10
    weights, bias = refine_classifier(
        classifier,
        crops[:7],
        memory.arrays["moment"].astype(np.float64),
        int(memory.data["tracks"]),
        ClassifierRefinement(views=4),
        0,
        check_progress,
    )
    refined = replace(classifier, weights=weights, bias=bias)
    views = [item.crop.pixels[10:-10, 10:-10] for item in crops[7:]]
    before, after = classifier.margins(views)[:, 14], refined.margins(views)[:, 14]
    assert (after > before + 0.1).all()
    known, classes = memory.arrays["crops"].astype(np.float32), memory.arrays["classes"]
    right = [((known @ c.weights + c.bias).argmax(1) == classes).mean() for c in (classifier, refined)]
    assert right[1] > right[0] - 0.01


def test_a_classifier_learns_a_new_label_and_keeps_known_ones(memory: Component, scenes: list[CorrectedScene]) -> None:
    classifier = SignClassifier.from_component(load_component("classifier"))
    crops = [replace(item, crop=replace(item.crop, class_id=43)) for item in sign_crops(scenes, check_progress)]
    grown = with_labels(classifier, ("bus-stop",))
    assert grown.labels[43] == "bus-stop"
    assert with_labels(classifier, ()) is classifier
    views = [item.crop.pixels[10:-10, 10:-10] for item in crops[7:]]
    assert (grown.margins(views)[:, 43] == -1).all(), "an untaught machine refuses everything"
    moment, tracks = memory.arrays["moment"].astype(np.float64), int(memory.data["tracks"])
    weights, bias = refine_classifier(
        grown, crops[:7], moment, tracks, ClassifierRefinement(views=4), 0, check_progress
    )
    refined = replace(grown, weights=weights, bias=bias)
    assert (refined.margins(views).argmax(axis=1) == 43).all()
    known, classes = memory.arrays["crops"].astype(np.float32), memory.arrays["classes"]
    right = [((known @ c.weights + c.bias).argmax(1) == classes).mean() for c in (classifier, refined)]
    assert right[1] >= right[0] - 0.002


def test_priors_are_weighted_by_their_numbers_of_signs(scenes: list[CorrectedScene]) -> None:
    old = parzen([[0.2, 0.2]], 0.05)
    sizes = [(260, 200)] * len(scenes)
    heavy, count = blended_table(old, 10_000, scenes, sizes)
    assert count == 10_010
    assert np.abs(heavy - old).max() < 0.01
    light, _ = blended_table(old, 1, scenes, sizes)
    new = parzen([[s.scene.boxes[0, [0, 2]].mean() / 260, s.scene.boxes[0, [1, 3]].mean() / 200] for s in scenes], 0.05)
    assert np.corrcoef(light.ravel(), new.ravel())[0, 1] > 0.95
    assert light.max() == 1
    assert blended_table(old, 5, [], [])[1] == 5


def test_lambda_is_high_if_the_prior_separates_signs() -> None:
    table = parzen([[0.75, 0.5]], 0.08)
    rng = np.random.default_rng(0)
    inside, outside = np.tile([0.75, 0.5], (40, 1)), rng.uniform(0, 0.4, (40, 2))
    raw = rng.normal(0, 1, 80) + np.repeat([0.5, -0.5], 40)
    labels = np.repeat([1.0, -1.0], 40)
    reported = refined_lambda(table, {}, (1, 1), (np.concatenate([inside, outside]), raw, labels))
    blind = refined_lambda(table, {}, (1, 1), (rng.uniform(0, 1, (80, 2)), raw, labels))
    assert reported is not None
    assert blind is not None
    assert reported > blind + 1
    assert refined_lambda(table, {}, (1, 1), (inside, raw[:40], labels[:40])) is None


def test_the_online_detector_keeps_its_number_of_samples(scenes: list[CorrectedScene], tmp_path: Path) -> None:
    parent = load_component("online")
    one, again = (refine_online(parent, scenes[:4], 3) for _ in range(2))
    assert one.arrays["X"].shape == parent.arrays["X"].shape
    assert one.arrays["y"].sum() == parent.arrays["y"].sum() == 0
    assert one.arrays["X"].tobytes() == again.arrays["X"].tobytes()
    known = {row.tobytes() for row in parent.arrays["X"]}
    new = [row for row in one.arrays["X"] if row.tobytes() not in known]
    assert len(new) == one.data["of_corrections"] == 2 * 3 * 4
