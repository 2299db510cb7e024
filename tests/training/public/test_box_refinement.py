"""The box refinement: its geometry, its loss, and its effect after training on drawn signs."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tsr_engine.detection.refine.box_inset import BoxInset
from tsr_engine.detection.refine.box_refinement import BoxRefinement, cut_box, move_edges, steps_between
from tsr_engine.geometry.boxes import iou
from tsr_engine.training.public.box_refinement import BoxRefinementPlan, box_refinement_view, train_box_refinement
from tsr_engine.training.public.classifier_network import NetworkSettings, _huber
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop, surrounded_crop

PLAN = BoxRefinementPlan(
    steps=400, batch=48, network=NetworkSettings(filters=16, hidden=32, drop_hidden=0.2, warm_up=20, loss="huber")
)


def sign(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A red ring on a noisy ground, and its box with subpixel position."""
    picture = rng.integers(90, 120, (120, 140, 3), dtype=np.uint8)
    x, y, half = rng.uniform(50, 80), rng.uniform(45, 70), rng.uniform(12, 24)
    at = (round(x * 16), round(y * 16))
    cv2.circle(picture, at, round(half * 16), (40, 40, 190), -1, cv2.LINE_AA, 4)
    cv2.circle(picture, at, round(0.7 * half * 16), (230, 230, 230), -1, cv2.LINE_AA, 4)
    return picture, np.array([x - half, y - half, x + half, y + half]) + 0.5


def crops(count: int, seed: int, *, bare: bool = False) -> list[LoadedCrop]:
    """Crops with a margin of half a side around each sign, or of a tenth as in GTSRB."""
    out = []
    rng = np.random.default_rng(seed)
    for _ in range(count):
        picture, box = sign(rng)
        if bare:
            around = 0.12 * (box[2] - box[0])
            x1, y1, x2, y2 = np.round(box + np.array([-around, -around, around, around])).astype(int)
            out.append(LoadedCrop(picture[y1:y2, x1:x2].copy(), box - np.array([x1, y1, x1, y1]), 1))
        else:
            out.append(surrounded_crop(picture, box, 1))
    return out


@pytest.fixture(scope="module")
def trained() -> BoxRefinement:
    return train_box_refinement(crops(40, 1, bare=True), crops(40, 2), PLAN, np.random.default_rng(3), lambda *_: None)


def move_randomly(box: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    steps = rng.normal(0, [0.03, 0.03, 0.05, 0.05])
    return move_edges(box[None], steps[None])[0]


def test_refinement_improves_boxes_of_unseen_signs(trained: BoxRefinement) -> None:
    rng = np.random.default_rng(9)
    before, after = [], []
    for _ in range(60):
        picture, box = sign(rng)
        start = move_randomly(box, rng)[None]
        before.append(iou(start, box[None])[0, 0])
        after.append(iou(trained.refine(picture, start), box[None])[0, 0])
    assert 1 - np.mean(after) < 0.65 * (1 - np.mean(before))


def test_a_second_pass_removes_most_of_the_remaining_error(trained: BoxRefinement) -> None:
    rng = np.random.default_rng(10)
    left: list[list[float]] = []
    for _ in range(60):
        picture, box = sign(rng)
        start = move_randomly(box, rng)[None]
        left.append([1 - iou(trained.refine(picture, start, passes), box[None])[0, 0] for passes in (0, 1, 2)])
        np.testing.assert_array_equal(trained.refine(picture, start, 0), start)
        np.testing.assert_array_equal(
            trained.refine(picture, start, 2), trained.refine(picture, trained.refine(picture, start))
        )
    none, one, two = np.mean(left, axis=0)
    assert two < one < none


def test_box_inset_is_inverted_exactly() -> None:
    boxes = np.array([[10.0, 20, 50, 70], [3, 4, 30, 28]])
    tight = BoxInset(0.9, 0.8, 0.1)
    np.testing.assert_allclose(tight.apply(boxes), [[12, 20, 48, 60], [4.35, 4, 28.65, 23.2]])
    np.testing.assert_allclose(tight.undo(tight.apply(boxes)), boxes)


def test_boxes_are_refined_independently(trained: BoxRefinement) -> None:
    rng = np.random.default_rng(4)
    picture, box = sign(rng)
    boxes = np.stack([move_randomly(box, rng) for _ in range(5)])
    together = trained.refine(picture, boxes)
    for one, alone in zip(together, boxes, strict=True):
        np.testing.assert_array_equal(trained.refine(picture, alone[None])[0], one)
    assert trained.refine(picture, boxes[:0]).shape == (0, 4)


def test_boxes_outside_the_picture_are_unchanged(trained: BoxRefinement) -> None:
    picture, box = sign(np.random.default_rng(5))
    over = np.array([[-2.0, 10, 30, 40], [120, 90, 141, 118]])
    moved = trained.refine(picture, np.concatenate([over, box[None] + 2]))
    np.testing.assert_array_equal(moved[:2], over)
    assert not np.array_equal(moved[2], box + 2)


def test_the_mean_correction_follows_the_scenes(trained: BoxRefinement) -> None:
    """Crops whose boxes are all slightly low do not move the boxes of signs in scenes."""
    low = [replace(crop, box=crop.box + np.array([0, 1.5, 0, 1.5])) for crop in crops(40, 1, bare=True)]
    plan = replace(PLAN, scene_signs=0.3)
    box_refinement = train_box_refinement(low, crops(40, 2), plan, np.random.default_rng(3), lambda *_: None)
    rng, shifts = np.random.default_rng(11), []
    for _ in range(60):
        picture, box = sign(rng)
        shifts.append(steps_between(box[None], box_refinement.refine(picture, move_randomly(box, rng)[None]))[0])
    assert abs(np.mean(shifts, axis=0)[1]) < 0.012, "a third of the 1.5 px would be 0.014 of a side"


def test_a_refinement_round_trips_through_arrays(trained: BoxRefinement) -> None:
    picture, box = sign(np.random.default_rng(6))
    again = BoxRefinement.from_arrays(trained.to_arrays())
    np.testing.assert_array_equal(again.refine(picture, box[None]), trained.refine(picture, box[None]))
    arrays = trained.to_arrays()
    del arrays["outline_bias"]
    with pytest.raises(KeyError, match="outline_bias"):
        BoxRefinement.from_arrays(arrays)
    with pytest.raises(ValueError, match="BoxRefinement needs weights"):
        replace(trained, weights=trained.weights[:, :3])


def test_steps_lead_from_one_box_to_another() -> None:
    rng = np.random.default_rng(7)
    boxes = np.concatenate([rng.uniform(0, 50, (30, 2)), rng.uniform(80, 130, (30, 2))], axis=1)
    truth = boxes + rng.uniform(-6, 6, (30, 4))
    np.testing.assert_allclose(move_edges(boxes, steps_between(boxes, truth)), truth)
    far = move_edges(np.array([[0.0, 0, 10, 10]]), np.full((1, 4), 9.0))
    np.testing.assert_allclose(far[0], [3 + 5 - 5 * np.exp(0.3)] * 2 + [3 + 5 + 5 * np.exp(0.3)] * 2)


def test_a_patch_shows_the_box_and_a_tenth_around_it() -> None:
    picture = np.zeros((200, 300, 3), np.uint8)
    picture[60:100, 100:220] = 255  # 120 px wide, 40 high
    patch = cut_box(picture, np.array([100.0, 60, 220, 100]))
    assert patch.shape == (48, 48, 3)
    white = np.argwhere(patch[..., 0] > 127)
    assert white.min(axis=0).tolist() == [4, 4]
    assert white.max(axis=0).tolist() == [43, 43]


def test_crops_are_cut_within_the_border_of_gtsrb() -> None:
    """Otherwise the replicated border would reveal the sign's edge."""
    crop = crops(1, 8, bare=True)[0]
    calm = replace(PLAN, shift=0.0, log_scale=0.0, log_aspect=0.0)
    rng = np.random.default_rng(0)
    patches = {box_refinement_view(crop, rng, calm, 0.0)[0].tobytes() for _ in range(40)}
    assert len(patches) > 20
    whole = {box_refinement_view(crop, rng, calm, 0.0, cut=False)[0].tobytes() for _ in range(40)}
    assert len(whole) == 2, "as it is, and mirrored"


def test_a_mirrored_view_moves_the_other_way() -> None:
    crop = crops(1, 8)[0]
    plan = replace(PLAN, shift=0.03, log_scale=0.0, log_aspect=0.0)
    for seed in range(12):
        patch, steps = box_refinement_view(crop, np.random.default_rng(seed), plan, 0.0, cut=False)
        red = np.argwhere(patch[..., 2].astype(int) - patch[..., 0] > 60)[:, 1]
        seen = ((red.min() + red.max() + 1) / 2 - 24) / 40
        assert seen == pytest.approx(steps[0], abs=0.015)


def test_the_slope_of_huber_is_the_derivative_of_its_loss() -> None:
    rng = np.random.default_rng(1)
    answers, wanted = rng.normal(0, 0.05, (6, 4)).astype(np.float32), np.zeros((6, 4))
    loss, slope = _huber(answers, wanted)
    for i, j in ((0, 0), (2, 3), (5, 1)):
        nudged = answers.copy()
        nudged[i, j] += 1e-4
        assert (_huber(nudged, wanted)[0] - loss) / 1e-4 * 0.03 == pytest.approx(slope[i, j], abs=2e-3)
    with pytest.raises(ValueError, match="needs the loss 'hinge'"):
        NetworkSettings(common=True, loss="huber")


def test_training_without_signs_of_scenes_is_refused() -> None:
    with pytest.raises(ValueError, match="signs of scenes"):
        train_box_refinement(crops(3, 1), [], PLAN, np.random.default_rng(0), lambda *_: None)
