"""Trains the sign verifier: crops of signs against background that passes the cascade.

Signs are GTSRB crops, signs of the scenes, and signs drawn in the style of other countries (``synthetic.drawn_signs``):
a machine that has seen only one drawing of a class rejects the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tsr_engine.detection.refine.sign_verifier import SignVerifier
from tsr_engine.detection.refine.stage import RefineStage
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.classifier import descend, shown_views
from tsr_engine.training.public.classifier_network import Network, NetworkSettings
from tsr_engine.training.public.mining import CascadeScan, PictureChanges, away_from_signs, background_candidates
from tsr_engine.training.public.refine_stage import MOVED_OVERLAP
from tsr_engine.training.synthetic.augment import other_camera, shade
from tsr_engine.training.synthetic.classifier_augmentation import BACKGROUND, LoadedCrop, jittered_view, surrounded_crop
from tsr_engine.training.synthetic.drawn_signs import EMPTY, PRINTED, drawn_crop, drawn_crops
from tsr_engine.training.synthetic.yellow_grounds import sometimes_yellow


@dataclass(frozen=True, slots=True)
class SignVerifierPlan:
    """Settings of the sign verifier's training.

    Attributes:
        steps: gradient steps.
        batch: views per step.
        showings: average number of times that a view is shown.
        scene_signs: share of views with signs of the scenes; the other signs are GTSRB crops.
        background: share of views without a sign.
        drawn: share of views with drawn signs.
        drawn_crops: drawn crops of each class with a drawing.
        rings: drawn crops of *no vehicles*, whose only drawing is the ring.
        candidates: largest number of background candidates per scene.
        relit: share of scenes that are searched again under another light.
        other_cameras: share of these searches that use another camera's picture instead, and of all views that are
            changed so.
        shaded: share of views with a shadow.
        yellow: share of views with a yellow ground, of signs with a ground.
        balance: exponent of class sizes in the draw of signs: 1: proportional, 0: all classes equally often.
        strength: strength of the views, in [0, 1], see ``jittered_view``.
        network: size and regularisation.
    """

    steps: int = 25_000
    batch: int = 128
    showings: int = 2
    scene_signs: float = 0.15
    background: float = 0.45
    drawn: float = 0.08
    drawn_crops: int = 80
    rings: int = 80
    candidates: int = 80
    relit: float = 0.6
    other_cameras: float = 0.3
    shaded: float = 0.12
    yellow: float = 0.08
    balance: float = 0.5
    strength: float = 0.8
    network: NetworkSettings = field(default_factory=lambda: NetworkSettings(filters=64, hidden=128, common=True))


def train_sign_verifier(
    crops: Sequence[LoadedCrop],
    scene_signs: Sequence[LoadedCrop],
    background: Sequence[LoadedCrop],
    plan: SignVerifierPlan,
    rng: np.random.Generator,
    progress: Progress,
) -> SignVerifier:
    """Train the machines.

    Args:
        crops: GTSRB crops; may be empty.
        scene_signs: signs of the scenes; may be empty when there are crops.
        background: windows of the scenes that passed the cascade, class ``BACKGROUND``.
        plan: see :class:`SignVerifierPlan`.
        rng: source of weights and views.
        progress: called as the work proceeds.
    """
    drawn = drawn_crops(plan.drawn_crops, rng, PRINTED) if plan.drawn > 0 else []
    if plan.drawn > 0:
        drawn += [drawn_crop(EMPTY, rng) for _ in range(plan.rings)]
    parts: list[LoadedCrop] = []
    chances = []
    for part, share in (
        (drawn, plan.drawn),
        (crops, 1.0 - plan.drawn - plan.scene_signs - plan.background),
        (scene_signs, plan.scene_signs),
        (background, plan.background),
    ):
        if len(part):
            classes = np.array([crop.class_id for crop in part])
            counts = np.bincount(classes + 1, minlength=CLASS_COUNT + 1).astype(np.float64)
            chance = counts[classes + 1] ** (plan.balance - 1)
            parts += part
            chances.append(share * chance / chance.sum())
    chance = np.concatenate(chances)

    def view(crop: LoadedCrop, generator: np.random.Generator, strength: float) -> tuple[Picture, int]:
        return jittered_view(_by_another_camera(crop, plan, generator), generator, strength)

    chance /= chance.sum()
    views = shown_views(parts, chance, plan.batch, plan.showings, rng, lambda made: plan.strength, view)
    network = Network(plan.network, int(rng.integers(2**31)))
    arrays = descend(network, views, plan.steps, progress, "sign verifier")
    return SignVerifier.from_arrays({f"likeness_{name}": array for name, array in arrays.items()})


def _by_another_camera(crop: LoadedCrop, plan: SignVerifierPlan, rng: np.random.Generator) -> LoadedCrop:
    """The crop unchanged, with a yellow ground, with a shadow, or as taken by another camera."""
    crop = replace(crop, pixels=sometimes_yellow(crop.pixels, crop.box, crop.class_id, plan.yellow, rng))
    if rng.random() < plan.shaded:
        crop = replace(crop, pixels=shade(crop.pixels, crop.box, rng))
    if rng.random() < plan.other_cameras:
        crop = replace(crop, pixels=other_camera(crop.pixels, rng))
    return crop


def surrounded_signs(scenes: Sequence[Scene]) -> list[LoadedCrop]:
    """The annotated signs of scenes with their surroundings.

    Raises:
        InputError: a picture cannot be decoded.
    """
    out = []
    for scene in scenes:
        if len(scene.boxes):
            picture = read_picture(scene.path)
            pairs = zip(scene.boxes, scene.class_ids, strict=True)
            out += [surrounded_crop(picture, box, int(class_id)) for box, class_id in pairs]
    return out


def background_crops(
    scenes: Sequence[Scene],
    scan: CascadeScan,
    stage: RefineStage,
    plan: SignVerifierPlan,
    rng: np.random.Generator,
    progress: Progress,
) -> list[LoadedCrop]:
    """Windows that pass the cascade and are not signs, as moved by the refine-and-verify stage.

    Raises:
        InputError: a picture cannot be decoded.
    """
    out: list[LoadedCrop] = []
    changed = PictureChanges(1.0 - plan.other_cameras, plan.other_cameras)
    for scene, picture, boxes in background_candidates(
        scenes, scan, plan.candidates, plan.relit, changed, rng, progress
    ):
        refined, _ = stage.refine_and_verify(picture, boxes)
        refined = refined[_within(refined, picture) & away_from_signs(refined, scene.occupied, MOVED_OVERLAP)]
        out += [surrounded_crop(picture, box, BACKGROUND) for box in refined]
    return out


def _within(boxes: FloatArray, picture: Picture) -> NDArray[np.bool_]:
    """Which boxes have their centre in the picture and are large enough to be useful; shape (n,)."""
    middle, size = (boxes[:, :2] + boxes[:, 2:]) / 2, boxes[:, 2:] - boxes[:, :2]
    height, width = picture.shape[:2]
    return np.asarray(((middle >= 0) & (middle < [width, height]) & (size >= 6)).all(axis=1))
