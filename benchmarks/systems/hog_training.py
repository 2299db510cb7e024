"""Training of the HOG cascade: as for the ACF detector, with other features."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.systems.hog import integral, orientation_cells
from benchmarks.systems.hog_blocks import FEATURES, WINDOW, window_bytes
from benchmarks.systems.hog_cascade import HogCascade, search
from benchmarks.systems.hog_scan import HogLevel, levels, scales_of
from benchmarks.systems.log_odds import fit_log_odds
from benchmarks.systems.sign_patches import SignPatch, crop_patches, scene_patches
from tsr_engine.detection.boosting import BoostingPlan, boost
from tsr_engine.detection.nms import suppress
from tsr_engine.detection.trees import NEVER, UNIT, TreeEnsemble
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.gtsrb import CropItem
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.public.mining import MIN_WIDTH, PictureChanges, away_from_signs, searched_picture

Progress = Callable[[str], None]
_SIZE_SLACK: Final = 0.12
"""Largest difference of the logarithms of a window's and a sign's side for a match."""


@dataclass(frozen=True, slots=True)
class HogPlan:
    """Settings of the training.

    Attributes:
        rounds: number of trees of each round; hard background is collected between rounds.
        mining_share: share of the scenes to search after each round but the last.
        feature_share: share of the features that one tree may use.
        jittered: number of windows around each annotated sign.
        crop_frames: number of windows from each GTSRB track.
        random_per_scene: number of random background windows per scene.
        per_scene: number of hard background windows per scene and round.
        relit: share of the scenes to search with changed light.
        most_negatives: largest number of background windows.
        lost: share of the calibration scenes' weakest signs that early rejection may lose.
        log_odds: number of calibration scenes for the log-odds.
        slack: margin of rejection below the running score of the weakest kept sign, half log-odds.
    """

    rounds: tuple[int, ...] = (32, 128, 512)
    mining_share: tuple[float, ...] = (0.15, 0.4)
    feature_share: float = 1 / 16
    jittered: int = 12
    crop_frames: int = 4
    random_per_scene: int = 250
    per_scene: int = 80
    relit: float = 0.35
    most_negatives: int = 40_000
    lost: float = 0.02
    log_odds: int = 60
    slack: float = 0.5


DEFAULT_PLAN: Final = HogPlan()


def train_hog_cascade(
    train: Sequence[Scene],
    calibrate: Sequence[Scene],
    crops: Sequence[CropItem],
    seed: int,
    progress: Progress,
    plan: HogPlan = DEFAULT_PLAN,
) -> tuple[HogCascade, JsonObject]:
    """Train a cascade.

    Args:
        train: annotated scenes to learn from.
        calibrate: scenes for rejection thresholds and log-odds.
        crops: GTSRB crops as further signs.
        seed: random seed.
        progress: called with each stage.
        plan: settings of the training.

    Returns:
        The model and a record of the training.

    Raises:
        ValueError: the scenes hold no sign.
    """
    if not any(len(scene.boxes) for scene in train) or not any(len(scene.boxes) for scene in calibrate):
        raise ValueError("A cascade is trained and calibrated on scenes with signs. Got none.")
    rng = np.random.default_rng([seed, 31])
    positives, weights = _positives(train, crops, plan, rng)
    negatives = _random_background(train, plan.random_per_scene, rng)
    traces = [windows_on_signs(scene) for scene in calibrate if len(scene.boxes)]
    cascade = None
    for number, trees in enumerate(plan.rounds):
        progress(f"round {number + 1}: {trees} trees, {len(positives)} signs, {len(negatives)} others")
        grown = boost(positives, negatives, BoostingPlan(trees, 2, plan.feature_share), rng, WINDOW.cells, weights)
        cascade = _with_rejection(grown, traces, plan)
        if number == len(plan.rounds) - 1:
            break
        count = max(1, round(len(train) * plan.mining_share[number]))
        chosen = [train[i] for i in rng.permutation(len(train))[:count]]
        hard = np.concatenate([_hard_background(scene, cascade, plan, rng) for scene in chosen])
        room = max(plan.most_negatives - len(hard), plan.most_negatives // 4)
        negatives = np.concatenate([negatives[np.sort(rng.permutation(len(negatives))[:room])], hard])
    assert cascade is not None
    progress("calibration")
    model = HogCascade(cascade, fit_log_odds(_results(cascade, scene) for scene in calibrate[: plan.log_odds]))
    record = {
        "scenes": len(train),
        "signs": sum(len(s.boxes) for s in train),
        "crops": len(crops),
        "positives": len(positives),
        "negatives": len(negatives),
        "plan": asdict(plan),
    }
    return model, record


def _patch_bytes(patch: Picture) -> NDArray[np.uint8]:
    """Features of the window in the middle of a patch, shape (FEATURES,)."""
    grey = np.asarray(cv2.cvtColor(patch, cv2.COLOR_BGR2GRAY), np.uint8)
    planes = integral(orientation_cells(grey, WINDOW.shrink))
    first = np.array([(planes.shape[1] - 1 - WINDOW.cells) // 2])
    features: NDArray[np.uint8] = window_bytes(planes, first, first)[0]
    return features


def _positives(
    train: Sequence[Scene], crops: Sequence[CropItem], plan: HogPlan, rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Windows of signs and their weights: rare classes have a higher weight, crops half the weight of scenes."""

    def seen(patches: list[SignPatch]) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
        if not patches:
            return np.zeros((0, FEATURES), np.uint8), np.zeros(0)
        classes = np.array([patch.class_id for patch in patches])
        share = np.bincount(classes, minlength=43)[classes] ** -0.5
        return np.stack([_patch_bytes(patch.picture) for patch in patches]), share / share.sum()

    windows, weights = seen(list(scene_patches(train, plan.jittered, WINDOW.sign, rng)))
    more, others = seen(list(crop_patches(crops, train, plan.crop_frames, WINDOW.sign, rng)) if crops else [])
    return np.concatenate([windows, more]), np.concatenate([weights, 0.5 * others])


def _levels(picture: Picture) -> list[HogLevel]:
    return list(levels(picture, scales_of(picture.shape[1], picture.shape[0], MIN_WIDTH)))


def _random_background(scenes: Sequence[Scene], per_scene: int, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Windows without a sign from a fifth of the scenes, distributed over the levels by size."""
    out = [np.zeros((0, FEATURES), np.uint8)]
    for i in rng.permutation(len(scenes))[: max(1, len(scenes) // 5)]:
        scene = scenes[i]
        found = _levels(read_picture(scene.path))
        sizes = [max(0, level.windows[0]) * max(0, level.windows[1]) for level in found]
        for level, size in zip(found, sizes, strict=True):
            if not size:
                continue
            count = max(1, round(per_scene * size / sum(sizes)))
            y, x = rng.integers(0, level.windows[0], count), rng.integers(0, level.windows[1], count)
            clear = away_from_signs(level.boxes(y, x), scene.occupied)
            out.append(window_bytes(level.planes, y[clear], x[clear]))
    return np.concatenate(out)


def _hard_background(scene: Scene, cascade: TreeEnsemble, plan: HogPlan, rng: np.random.Generator) -> NDArray[np.uint8]:
    """The windows without a sign that have the highest scores."""
    params = DetectorParams(far_top=0.0, far_bottom=1.0)
    found = search(searched_picture(scene, rng, PictureChanges(plan.relit)), cascade, params, keep=True)
    clear = away_from_signs(found.boxes, scene.occupied)
    places = found.places[clear]
    places = places[suppress(found.boxes[clear], found.scores[clear], 0.6, plan.per_scene)]
    out = [np.zeros((0, FEATURES), np.uint8)]
    for index in np.unique(places[:, 0]):
        here = places[places[:, 0] == index]
        out.append(window_bytes(found.levels[int(index)].planes, here[:, 1], here[:, 2]))
    return np.concatenate(out)


def windows_on_signs(scene: Scene) -> list[NDArray[np.uint8]]:
    """For each sign of a scene the windows of the scan on it, shape (n, FEATURES) each; n may be 0."""
    out: list[list[NDArray[np.uint8]]] = [[] for _ in scene.boxes]
    picture = read_picture(scene.path)
    sides = np.sqrt((scene.boxes[:, 2] - scene.boxes[:, 0]) * (scene.boxes[:, 3] - scene.boxes[:, 1]))
    scales = scales_of(picture.shape[1], picture.shape[0], MIN_WIDTH)
    # A level takes far more time than its windows, so only levels with a sign of the window's size are made. Sides of
    # levels are whole px, so a level's exact scale may differ a little from the nominal one.
    near_size = np.abs(np.log(WINDOW.sign / (scales[:, None] * sides))) < _SIZE_SLACK + 0.05
    for level in levels(picture, scales[near_size.any(axis=1)]):
        for number, (box, side) in enumerate(zip(scene.boxes, sides, strict=True)):
            if abs(np.log(WINDOW.sign / level.scale_x / side)) > _SIZE_SLACK:
                continue
            middle = WINDOW.cells / 2 - WINDOW.pad
            row = int((box[1] + box[3]) / 2 * level.scale_y / WINDOW.shrink - middle)
            column = int((box[0] + box[2]) / 2 * level.scale_x / WINDOW.shrink - middle)
            y, x = (g.ravel() for g in np.mgrid[row - 1 : row + 3, column - 1 : column + 3])
            inside = (y >= 0) & (x >= 0) & (y < level.windows[0]) & (x < level.windows[1])
            y, x = y[inside], x[inside]
            near = iou(level.boxes(y, x), box[None])[:, 0] > 0.65 if len(y) else np.zeros(0, bool)
            if near.any():
                out[number].append(window_bytes(level.planes, y[near], x[near]))
    return [np.concatenate(parts) for parts in out if parts]


def _with_rejection(ensemble: TreeEnsemble, traces: list[list[NDArray[np.uint8]]], plan: HogPlan) -> TreeEnsemble:
    """Set thresholds below the running scores of the best window on each sign of scenes without training.

    The weakest signs, which would not be found anyway, do not count (direct backward pruning, Zhang & Viola 2007).
    """
    best = []
    for windows in (windows for scene in traces for windows in scene):
        sums = ensemble.partial_sums(windows)
        best.append(sums[np.argmax(sums[:, -1])])
    if not best:
        return ensemble.with_rejection(np.full(len(ensemble), NEVER, np.int32))
    table = np.stack(best)
    kept = np.argsort(-table[:, -1])[: max(1, round(len(table) * (1 - plan.lost)))]
    return ensemble.with_rejection((table[kept].min(axis=0) - round(plan.slack * UNIT)).astype(np.int32))


def _results(cascade: TreeEnsemble, scene: Scene) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Boxes and scores of the survivors of a scene, and the boxes of its signs."""
    found = search(read_picture(scene.path), cascade, DetectorParams())
    kept = suppress(found.boxes, found.scores, DetectorParams().final_overlap, 200)
    return found.boxes[kept], found.scores[kept], scene.boxes
