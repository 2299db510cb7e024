"""Trains the refine-and-verify stage: two steps of supervised descent, then a verifier on their results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import Ridge

from tsr_engine.detection.boosting import BoostingPlan, boost
from tsr_engine.detection.refine.stage import CELLS, FEATURES, RefineStage, features_of, move, steps_to
from tsr_engine.geometry.boxes import area
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.mining import CascadeScan, PictureChanges, away_from_signs, background_candidates
from tsr_engine.training.public.patches import jitter, surroundings
from tsr_engine.training.synthetic.augment import augment_picture

MOVED_OVERLAP: Final = 0.4
"""As ``SIGN_OVERLAP`` of :mod:`~.mining`, for candidates that the stage has moved."""
MIN_NEGATIVES: Final = 400
"""If a cascade leaves fewer background windows, random boxes are added, because a verifier needs negatives."""


@dataclass(frozen=True, slots=True)
class RefinementPlan:
    """Settings of the refine-and-verify stage's training.

    Attributes:
        views: relit and softened copies of each sign, besides the original; each is also mirrored.
        starts: starting boxes per view.
        shift: largest displacement of a start, as a share of the side. Candidates are means of many windows, so they
            lie close; regressions with a short range answer more exactly.
        log_scale: largest change of a start's scale, natural logarithm.
        ridge: regularisation of the regressions.
        candidates: hardest background candidates per scene.
        relit: share of scenes that are searched again under another light.
        other_cameras: share of copies changed as by another camera, and of second searches that use such a change
            instead.
        shaded: share of copies with a shadow on the sign.
        yellow: share of copies with a yellow ground, of signs with a ground.
        boosting: settings of the verifier.
    """

    views: int = 5
    starts: int = 8
    shift: float = 0.07
    log_scale: float = 0.09
    ridge: float = 3e-3
    candidates: int = 50
    relit: float = 0.6
    other_cameras: float = 0.3
    shaded: float = 0.12
    yellow: float = 0.08
    boosting: BoostingPlan = field(
        default_factory=lambda: BoostingPlan(768, depth=4, feature_share=1 / 16, shrinkage=0.3)
    )


@dataclass(slots=True)
class _View:
    """One view of a sign, with starting boxes around it."""

    picture: Picture
    truth: FloatArray
    boxes: FloatArray
    weight: float


def train_refine_stage(
    scenes: Sequence[Scene],
    scan: CascadeScan,
    plan: RefinementPlan,
    rng: np.random.Generator,
    progress: Progress,
) -> RefineStage:
    """Train regressions and verifier for a cascade.

    The verifier's background is what passes the cascade on the scenes, moved by the first regression as in
    detection.
    """
    views = _views(scenes, plan, rng, progress)
    weights, biases = [], []
    for step in range(2):
        features = np.concatenate([features_of(v.picture, v.boxes) for v in views])
        wanted = np.concatenate([steps_to(v.boxes, np.repeat(v.truth[None], len(v.boxes), 0)) for v in views])
        weight, bias = ridge(features, wanted, plan.ridge)
        # Stored values have half precision, so training continues with those.
        weights.append(weight.astype(np.float16).astype(np.float32))
        biases.append(bias)
        if step == 0:
            start = 0
            answers = features.astype(np.float32) @ weights[0] / np.float32(255.0) + bias
            for view in views:
                stop = start + len(view.boxes)
                view.boxes = move(view.boxes, answers[start:stop].astype(np.float64))
                start = stop
    positives = np.concatenate([features_of(v.picture, v.boxes) for v in views])
    blank = RefineStage(np.stack(weights), np.stack(biases), scan.cascade)
    negatives = _background(scenes, scan, blank, plan, rng, progress)
    if len(negatives) < MIN_NEGATIVES:
        negatives = np.concatenate([negatives, windows_anywhere(scenes, blank, MIN_NEGATIVES, rng)])
    verifier = boost(
        positives,
        negatives,
        plan.boosting,
        rng,
        CELLS,
        np.concatenate([np.full(len(v.boxes), v.weight) for v in views]),
    )
    return RefineStage(np.stack(weights), np.stack(biases), verifier)


def ridge(
    features: NDArray[np.uint8], wanted: FloatArray, strength: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Weights (features, outputs) and biases (outputs,) of a ridge regression on ``features / 255``."""
    x = features.astype(np.float32) / np.float32(255.0)
    fitted = Ridge(strength * len(x), solver="cholesky", copy_X=False).fit(x, wanted.astype(np.float32))
    return fitted.coef_.T.astype(np.float32), fitted.intercept_.astype(np.float32)


def _views(scenes: Sequence[Scene], plan: RefinementPlan, rng: np.random.Generator, progress: Progress) -> list[_View]:
    frequency = np.bincount(np.concatenate([s.class_ids for s in scenes]), minlength=CLASS_COUNT)
    views = []
    for number, scene in enumerate(scenes):
        progress("views of signs", number, len(scenes))
        if not len(scene.boxes):
            continue
        picture = read_picture(scene.path)
        for box, class_id in zip(scene.boxes, scene.class_ids, strict=True):
            region, truth = surroundings(picture, box)
            for k in range(plan.views + 1):
                view = region
                if k:
                    view = augment_picture(
                        view, truth, rng,
                        relit=0.6, softened=0.35, other_cameras=plan.other_cameras, shaded=plan.shaded,
                        yellow=plan.yellow, class_id=int(class_id),
                    )  # fmt: skip
                width = view.shape[1]
                mirrored = np.ascontiguousarray(view[:, ::-1])
                other = np.array([width - truth[2], truth[1], width - truth[0], truth[3]])
                for image, target in ((view, truth), (mirrored, other)):
                    starts = [jitter(square_about(target), rng, plan.shift, plan.log_scale) for _ in range(plan.starts)]
                    views.append(_View(image, target, np.stack(starts), float(frequency[class_id]) ** -0.5))
    return views


def square_about(box: FloatArray) -> FloatArray:
    """The square of the box's area around its centre, in the form of the cascade's answers."""
    half = np.sqrt(area(box)) / 2
    cx, cy = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
    return np.array([cx - half, cy - half, cx + half, cy + half])


def _background(
    scenes: Sequence[Scene],
    scan: CascadeScan,
    stage: RefineStage,
    plan: RefinementPlan,
    rng: np.random.Generator,
    progress: Progress,
) -> NDArray[np.uint8]:
    out = [np.zeros((0, FEATURES), np.uint8)]
    changed = PictureChanges(1.0 - plan.other_cameras, plan.other_cameras)
    for scene, picture, boxes in background_candidates(
        scenes, scan, plan.candidates, plan.relit, changed, rng, progress
    ):
        moved = stage.step(0, boxes, features_of(picture, boxes))
        moved = moved[away_from_signs(moved, scene.occupied, MOVED_OVERLAP)]
        if len(moved):
            out.append(features_of(picture, moved))
    return np.concatenate(out)


def windows_anywhere(
    scenes: Sequence[Scene], stage: RefineStage, count: int, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Features of random boxes away from signs, moved by the first regression like candidates."""
    out = []
    for scene in scenes:
        picture = read_picture(scene.path)
        largest = min(64, *picture.shape[:2])
        side = rng.uniform(min(16, largest), largest, -(-count // len(scenes)))
        x, y = rng.uniform(0, picture.shape[1] - side), rng.uniform(0, picture.shape[0] - side)
        boxes = np.stack([x, y, x + side, y + side], axis=-1)
        boxes = boxes[away_from_signs(boxes, scene.occupied)]
        if len(boxes):
            out.append(features_of(picture, stage.step(0, boxes, features_of(picture, boxes))))
    return np.concatenate(out)
