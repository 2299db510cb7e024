"""Trains the box refinement: boxes are displaced from their sign, and it learns the steps back.

A GTSRB picture ends about a tenth of the sign's side beyond the sign. A border replicated from there would reveal the
edge of the sign, so pictures are cut again at random within that border. Signs of scenes have all of their
surroundings; they are cut only half of the time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tsr_engine.detection.refine.box_refinement import BoxRefinement, cut_box, move_edges, steps_between
from tsr_engine.recognition.descriptor import MARGIN, describe_patches
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.classifier import descend, shown_views
from tsr_engine.training.public.classifier_network import Network, NetworkSettings
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop, disturbed

__all__ = ["BoxRefinementPlan", "box_refinement_view", "train_box_refinement"]


_ROOMY = 0.2
"""Least margin on every side of a crop from a scene, in sides of the sign."""


@dataclass(frozen=True, slots=True)
class BoxRefinementPlan:
    """The settings of the training.

    Attributes:
        steps: gradient steps.
        batch: views per step.
        showings: average number of times that a view is shown.
        scene_signs: share of views with signs of the scenes; the others are GTSRB crops.
        shift: standard deviation of a box's displacement, in sides.
        log_scale: standard deviation of a box's scale, natural logarithm.
        log_aspect: standard deviation of the factor by which its width grows and its height shrinks, natural logarithm.
        strength: how often distance, blur and compression are applied, in [0, 1].
        centring: views per scene sign with which the median answer is corrected at the end.
        network: size and regularisation.
    """

    steps: int = 16000
    batch: int = 128
    showings: int = 2
    scene_signs: float = 0.2
    shift: float = 0.05
    log_scale: float = 0.08
    log_aspect: float = 0.04
    strength: float = 0.6
    centring: int = 8
    network: NetworkSettings = field(
        default_factory=lambda: NetworkSettings(filters=64, hidden=128, drop_hidden=0.2, decay=0.05, loss="huber")
    )


def train_box_refinement(
    crops: Sequence[LoadedCrop],
    scene_signs: Sequence[LoadedCrop],
    plan: BoxRefinementPlan,
    rng: np.random.Generator,
    progress: Progress,
) -> BoxRefinement:
    """Train the regression.

    GTSRB's annotators drew their boxes slightly differently from those of the scenes, so the median answer is finally
    corrected on the scenes' signs alone.

    Args:
        crops: GTSRB crops; may be empty.
        scene_signs: signs of the scenes with their surroundings (``surrounded_crop``).
        plan: see :class:`BoxRefinementPlan`.
        rng: source of weights and views.
        progress: called as the work proceeds.

    Raises:
        ValueError: there are no scene signs.
    """
    if not scene_signs:
        raise ValueError(
            "The box refinement is trained on signs of scenes, and on crops besides. Got none of the first."
        )
    classes = np.array([crop.class_id for crop in scene_signs])
    chance = np.maximum(1, np.bincount(classes, minlength=CLASS_COUNT))[classes] ** -0.5
    chance *= (plan.scene_signs if crops else 1.0) / chance.sum()
    if crops:
        chance = np.concatenate([chance, np.full(len(crops), (1.0 - plan.scene_signs) / len(crops))])

    def view(crop: LoadedCrop, generator: np.random.Generator, strength: float) -> tuple[Picture, FloatArray]:
        return box_refinement_view(crop, generator, plan, strength)

    views = shown_views(
        [*scene_signs, *crops], chance, plan.batch, plan.showings, rng, lambda made: plan.strength, view
    )
    network = Network(plan.network, int(rng.integers(2**31)))
    arrays = descend(network, views, plan.steps, progress, "box refinement")
    box_refinement = BoxRefinement.from_arrays({f"outline_{name}": array for name, array in arrays.items()})
    return _centred(box_refinement, scene_signs, plan, rng)


def _centred(
    box_refinement: BoxRefinement, scene_signs: Sequence[LoadedCrop], plan: BoxRefinementPlan, rng: np.random.Generator
) -> BoxRefinement:
    """The box refinement with a bias that makes its median answer on scene signs correct."""
    wrong = []
    for crop in scene_signs:
        shown = [box_refinement_view(crop, rng, plan, 0.0, cut=False) for _ in range(plan.centring)]
        answers = box_refinement.steps_of(
            box_refinement.features(describe_patches(np.stack([patch for patch, _ in shown])))
        )
        wrong.append(np.stack([steps for _, steps in shown]) - answers)
    bias = box_refinement.bias + np.median(np.concatenate(wrong), axis=0).astype(np.float32)
    return replace(box_refinement, bias=bias)


def box_refinement_view(
    crop: LoadedCrop, rng: np.random.Generator, plan: BoxRefinementPlan, strength: float, *, cut: bool = True
) -> tuple[Picture, FloatArray]:
    """A patch around a box that is slightly displaced from its sign, and the steps back.

    Args:
        crop: a sign with its surroundings.
        rng: source of the view.
        plan: sizes of the displacements.
        strength: how often distance, blur and compression are applied, in [0, 1]; 0: the picture is not changed.
        cut: whether to cut the picture again within GTSRB's border.

    Returns:
        Patch, BGR uint8, shape (48, 48, 3), and steps, shape (4,), as for
        :func:`~tsr_engine.detection.refine.box_refinement.move_edges`.
    """
    pixels, box = crop.pixels, crop.box
    if cut:
        pixels, box = _cut_within(pixels, box, rng)
    dx, dy, scale, aspect = (
        rng.standard_normal(4) * [plan.shift, plan.shift, plan.log_scale, plan.log_aspect]
    ).tolist()
    start = move_edges(box[None], np.array([[dx, dy, scale + aspect, scale - aspect]]))
    patch, steps = cut_box(pixels, start[0]), steps_between(start, box[None])[0]
    if strength > 0:
        patch = disturbed(patch, rng, strength)
    if rng.random() < 0.5:
        patch, steps = np.ascontiguousarray(patch[:, ::-1]), steps * [-1.0, 1.0, 1.0, 1.0]
    return patch, steps


def _cut_within(pixels: Picture, box: FloatArray, rng: np.random.Generator) -> tuple[Picture, FloatArray]:
    """The crop with less border around its sign, and the box in it; see the module."""
    height, width = pixels.shape[:2]
    side = max(box[2] - box[0], box[3] - box[1])
    room = np.maximum(0.0, [box[0], box[1], width - box[2], height - box[3]])
    if (room >= _ROOMY * side).all() and rng.random() < 0.5:
        return pixels, box
    left, top, right, bottom = np.minimum(room, 1.4 * MARGIN * side) * rng.random(4)
    x1, y1 = max(0, math.floor(box[0] - left)), max(0, math.floor(box[1] - top))
    x2, y2 = min(width, math.ceil(box[2] + right)), min(height, math.ceil(box[3] + bottom))
    return pixels[y1:y2, x1:x2], box - np.array([x1, y1, x1, y1])
