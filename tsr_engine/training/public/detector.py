"""Trains the offline detector: cascade in rounds with hard negatives, refine-and-verify stage.

It also trains the sign verifier and the box refinement.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.compute import CHANNELS
from tsr_engine.channels.pyramid import PyramidPlan
from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.boosting import BoostingPlan, boost
from tsr_engine.detection.log_odds import UNFITTED
from tsr_engine.detection.trees import NEVER, UNIT, TreeEnsemble
from tsr_engine.detection.window import Window
from tsr_engine.errors import InputError
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.gtsrb import CropItem
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonObject
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.box_refinement import BoxRefinementPlan, train_box_refinement
from tsr_engine.training.public.classifier import load_all
from tsr_engine.training.public.crop_windows import crop_windows
from tsr_engine.training.public.mining import (
    CascadeScan,
    PictureChanges,
    aligned_windows,
    background_windows,
    hard_windows,
)
from tsr_engine.training.public.parallel import map_on_cores
from tsr_engine.training.public.patches import sign_windows
from tsr_engine.training.public.power_law import measure_lambdas
from tsr_engine.training.public.refine_stage import RefinementPlan, train_refine_stage
from tsr_engine.training.public.sign_verifier import (
    SignVerifierPlan,
    background_crops,
    surrounded_signs,
    train_sign_verifier,
)


@dataclass(frozen=True, slots=True)
class DetectorPlan:
    """All settings that decide the result, besides data and seed.

    Attributes:
        rounds: trees of each round; between rounds hard negatives are collected.
        mining_share: share of scenes that are searched for hard negatives after each round but the last.
        per_octave: pyramid levels per octave.
        computed_per_octave: levels per octave that the detector computes from a picture. The others are resampled,
            which is faster and lost no sign of the calibration scenes.
        computed_in_training: the same while the cascade is trained. It learns better from the sharper windows of more
            computed levels, also for resampled levels.
        log_scale: largest scale change of a training window, natural logarithm: half a step between levels, because
            signs lie between them.
        aspect: stretch of training windows, see :func:`~tsr_engine.training.public.patches.sign_windows`.
        turn: rotation of training windows, degrees.
        depth: depth of the cascade's trees.
        shrinkage: factor on every leaf of the cascade. Without it, late trees overfit the training scenes and reject
            signs of others that are rotated or tilted more.
        feature_share: share of features available to one tree.
        jittered: training windows cut around each annotated sign.
        crop_frames: windows per GTSRB track; 0: none.
        per_scene: hard negatives per scene and round.
        random_per_scene: random negatives per scene.
        relit: share of scenes that are searched under another light.
        other_cameras: share of the other scenes that are searched as if taken by another camera, and of the training
            windows that are changed so.
        shaded: share of the training windows with a shadow on their sign.
        yellow: share of training windows with a yellow ground, of signs with a ground.
        most_negatives: largest number of negatives; more are thinned at random.
        floors: pairs of a number of trees and a score (units of half log-odds): after that many trees, windows with a
            lower running score are dropped. Chosen on calibration scenes; thresholds from the training signs' own
            scores would drop new signs. They are low, because the later stages separate signs far better than the
            cascade, and see few windows.
        refinement: the refine-and-verify stage.
        sign_verifier: the machines that separate signs from objects with a sign's outline.
        box_refinement: the regression onto a sign's edges.
    """

    rounds: tuple[int, ...] = (32, 128, 384, 1024)
    mining_share: tuple[float, ...] = (0.3, 0.7, 1.0)
    per_octave: int = 4
    computed_per_octave: int = 1
    computed_in_training: int = 2
    log_scale: float = 0.085
    aspect: float = 0.06
    turn: float = 4.0
    depth: int = 3
    shrinkage: float = 0.5
    feature_share: float = 1 / 16
    jittered: int = 16
    crop_frames: int = 5
    per_scene: int = 100
    random_per_scene: int = 150
    relit: float = 0.35
    other_cameras: float = 0.3
    shaded: float = 0.12
    yellow: float = 0.08
    most_negatives: int = 70_000
    floors: tuple[tuple[int, float], ...] = ((24, -0.7), (128, -2.0), (384, -1.5))
    refinement: RefinementPlan = field(default_factory=RefinementPlan)
    sign_verifier: SignVerifierPlan = field(default_factory=SignVerifierPlan)
    box_refinement: BoxRefinementPlan = field(default_factory=BoxRefinementPlan)


def fit_detector(
    scenes: Sequence[Scene], crops: Sequence[CropItem], plan: DetectorPlan, seed: int, progress: Progress
) -> tuple[AcfModel, JsonObject]:
    """Train a detector.

    Args:
        scenes: annotated scenes.
        crops: GTSRB crops as further signs; may be empty.
        plan: the settings.
        seed: seed of all randomness.
        progress: progress.

    Returns:
        The model and a record of the training.

    Raises:
        InputError: a picture cannot be decoded, or no scene has a sign.
    """
    signs = sum(len(s.boxes) for s in scenes)
    if not signs:
        raise InputError("Expected scenes with signs to train a detector on, got none. Name annotated scenes.")
    rng = np.random.default_rng(seed)
    window = Window()
    lambdas = measure_lambdas(read_picture(s.path) for s in scenes[:: max(1, len(scenes) // 40)])
    pyramid = PyramidPlan(window.shrink, plan.per_octave, plan.computed_per_octave, lambdas)
    finer = replace(pyramid, computed_per_octave=plan.computed_in_training)
    positives, weights = sign_positives(scenes, crops, window, finer, plan, rng, progress)
    cascade, negatives = fit_cascade(positives, weights, scenes, window, finer, plan, rng, progress)
    scan = CascadeScan(cascade, window, pyramid)
    # Later stages use a separate generator, so that other stages can be trained for the same cascade.
    rng = np.random.default_rng([seed, 29])
    refine_stage = train_refine_stage(scenes, scan, plan.refinement, rng, progress)
    rng = np.random.default_rng([seed, 31])
    background = background_crops(scenes, scan, refine_stage, plan.sign_verifier, rng, progress)
    read = load_all([item for item in crops if item.class_id is not None], progress, "crops")
    signs_of_scenes = surrounded_signs(scenes)
    sign_verifier = train_sign_verifier(read, signs_of_scenes, background, plan.sign_verifier, rng, progress)
    rng = np.random.default_rng([seed, 37])
    box_refinement = train_box_refinement(read, signs_of_scenes, plan.box_refinement, rng, progress)
    model = AcfModel(window, pyramid, cascade, refine_stage, sign_verifier, box_refinement, UNFITTED)
    record = {
        "scenes": len(scenes),
        "signs": signs,
        "crops": len(crops),
        "positives": len(positives),
        "negatives": negatives,
        "background_crops": len(background),
        "plan": asdict(plan),
    }
    return model, record


def fit_cascade(
    positives: NDArray[np.uint8],
    weights: NDArray[np.float64],
    scenes: Sequence[Scene],
    window: Window,
    pyramid: PyramidPlan,
    plan: DetectorPlan,
    rng: np.random.Generator,
    progress: Progress,
) -> tuple[TreeEnsemble, int]:
    """Train the cascade in rounds, with hard negatives from the scenes in between.

    Args:
        positives: features of signs, shape (n, features), uint8.
        weights: weights of the signs, shape (n,).
        scenes: source of background: everything but signs and ignored regions.
        window: the detector's window.
        pyramid: the pyramid of the training.
        plan: see :class:`DetectorPlan`.
        rng: source of all randomness.
        progress: progress.

    Returns:
        The cascade with its floors, and the number of negatives in the last round.
    """
    few = [scenes[i] for i in rng.permutation(len(scenes))[: max(1, len(scenes) // 3)]]
    negatives = background_windows(few, window, pyramid, 3 * plan.random_per_scene, rng, progress)
    cascade, changed = None, PictureChanges(plan.relit, (1 - plan.relit) * plan.other_cameras)
    for number, trees in enumerate(plan.rounds):
        progress(f"round {number + 1}: {trees} trees, {len(positives)} signs, {len(negatives)} others", 0, 1)
        boosting = BoostingPlan(trees, plan.depth, plan.feature_share, plan.shrinkage)
        cascade = with_floors(boost(positives, negatives, boosting, rng, window.cells, weights), plan.floors)
        if number == len(plan.rounds) - 1:
            break
        count = max(1, round(len(scenes) * plan.mining_share[number]))
        searched = [scenes[i] for i in rng.permutation(len(scenes))[:count]]
        hard = hard_windows(searched, CascadeScan(cascade, window, pyramid), plan.per_scene, rng, changed, progress)
        negatives = _thinned(negatives, hard, plan.most_negatives, rng)
    assert cascade is not None
    return cascade, len(negatives)


def with_floors(ensemble: TreeEnsemble, floors: Sequence[tuple[int, float]]) -> TreeEnsemble:
    """Turn an ensemble into a soft cascade; no window is dropped before the first floor's number of trees."""
    rejection = np.full(len(ensemble), NEVER, np.int32)
    for trees, floor in floors:
        rejection[min(trees, len(ensemble)) - 1 :] = round(floor * UNIT)
    return ensemble.with_rejection(rejection)


def sign_positives(
    scenes: Sequence[Scene],
    crops: Sequence[CropItem],
    window: Window,
    pyramid: PyramidPlan,
    plan: DetectorPlan,
    rng: np.random.Generator,
    progress: Progress,
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Windows of signs and their weights: rare classes weigh more, and crops half as much as scenes."""
    frequency = np.bincount(np.concatenate([s.class_ids for s in scenes]), minlength=CLASS_COUNT)
    windows, weights = [], []

    def of_scene(numbered: tuple[int, Scene], own: np.random.Generator) -> list[tuple[NDArray[np.uint8], float]]:
        number, scene = numbered
        if not len(scene.boxes):
            return []
        picture = read_picture(scene.path)
        made = []
        for box, class_id in zip(scene.boxes, scene.class_ids, strict=True):
            cut = sign_windows(
                picture, box, window, plan.jittered, own, log_scale=plan.log_scale, aspect=plan.aspect, turn=plan.turn,
                other_cameras=plan.other_cameras, shaded=plan.shaded, yellow=plan.yellow, class_id=int(class_id),
            )  # fmt: skip
            made.append((cut, float(frequency[class_id] ** -0.5)))
        if number % 2 == 0:
            aligned = aligned_windows(scene, window, pyramid)
            if len(aligned):
                made.append((aligned, float(frequency[scene.class_ids].min() ** -0.5 * len(scene.boxes))))
        return made

    for made in map_on_cores(of_scene, list(enumerate(scenes)), rng, progress, "signs"):
        for cut, weight in made:
            windows.append(cut)
            weights.append(np.full(len(cut), weight / len(cut)))
    scene_weight = sum(float(w.sum()) for w in weights)
    if crops and plan.crop_frames:
        cut, classes = crop_windows(crops, scenes, window, plan.crop_frames, rng, progress, plan.yellow)
        of_class = np.bincount(classes, minlength=CLASS_COUNT)
        share = of_class[classes] ** -0.5
        windows.append(cut)
        weights.append(share * (0.5 * scene_weight / share.sum()))
    features = np.concatenate(windows)
    assert features.shape[1] == CHANNELS * window.cells**2
    return features, np.concatenate(weights)


def _thinned(old: NDArray[np.uint8], new: NDArray[np.uint8], most: int, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Join both sets; the older one is thinned at random to fit."""
    room = max(most - len(new), most // 4)
    if len(old) > room:
        old = old[np.sort(rng.permutation(len(old))[:room])]
    return np.concatenate([old, new])[: max(most, room)]
