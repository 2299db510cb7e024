"""Trains the box refinement on boxes a little off their sign, and the steps that lead back.

A GTSRB picture ends about a tenth of the sign's side beyond the sign. A border that is replicated from there would
reveal the edge of the sign, so pictures are cut a second time, at random within that border. Signs of scenes have all
of their surroundings; they are cut only half of the time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tsr_engine.detection.refine.box_refinement import BoxRefinement, cut_box, move_edges, steps_between
from tsr_engine.recognition.catalogue import CLASS_COUNT
from tsr_engine.recognition.descriptor import MARGIN, describe_patches
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.classifier import descend, shown_views
from tsr_engine.training.classifier_jitter import LoadedCrop, disturbed
from tsr_engine.training.classifier_network import Network, NetworkSettings

__all__ = ["BoxRefinementPlan", "box_refinement_view", "train_box_refinement"]

Progress = Callable[[str, int, int], None]

_ROOMY = 0.2
"""A crop with so much around its sign on every side, in sides, comes from a scene."""


@dataclass(frozen=True, slots=True)
class BoxRefinementPlan:
    """The settings of the training.

    Attributes:
        steps: gradient steps.
        batch: views a step.
        showings: how often a view is shown on average.
        scene_signs: share of the views that show signs of the scenes; the others are GTSRB crops.
        shift: standard deviation of a box's displacement, in sides.
        log_scale: that of its scale, natural logarithm.
        log_aspect: that of what its width has more and its height less besides, natural logarithm.
        strength: how often distance, blur and compression strike, in [0, 1].
        centring: views of each scene sign from which the mean answer is set right at the end.
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

    GTSRB's annotators drew their boxes a little otherwise than those of the scenes: the mean answer is set right on the
    scenes' signs alone at the end.

    Args:
        crops: GTSRB crops; may be empty.
        scene_signs: signs of the scenes with their surroundings (:func:`~.classifier_jitter.surrounded_crop`).
        plan: see :class:`BoxRefinementPlan`.
        rng: of weights and views.
        progress: called as the work proceeds.

    Raises:
        ValueError: no signs of scenes.
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

    def look(crop: LoadedCrop, generator: np.random.Generator, strength: float) -> tuple[Picture, FloatArray]:
        return box_refinement_view(crop, generator, plan, strength)

    views = shown_views(
        [*scene_signs, *crops], chance, plan.batch, plan.showings, rng, lambda made: plan.strength, look
    )
    network = Network(plan.network, int(rng.integers(2**31)))
    arrays = descend(network, views, plan.steps, progress, "outline")
    box_refinement = BoxRefinement.from_arrays({f"outline_{name}": array for name, array in arrays.items()})
    return _centred(box_refinement, scene_signs, plan, rng)


def _centred(
    box_refinement: BoxRefinement, scene_signs: Sequence[LoadedCrop], plan: BoxRefinementPlan, rng: np.random.Generator
) -> BoxRefinement:
    """The box refinement with the bias under which its answers on scenes' signs are right in the median."""
    wrong = []
    for crop in scene_signs:
        shown = [box_refinement_view(crop, rng, plan, 0.0, cut=False) for _ in range(plan.centring)]
        answers = box_refinement.answers(
            box_refinement.features(describe_patches(np.stack([patch for patch, _ in shown])))
        )
        wrong.append(np.stack([steps for _, steps in shown]) - answers)
    bias = box_refinement.bias + np.median(np.concatenate(wrong), axis=0).astype(np.float32)
    return replace(box_refinement, bias=bias)


def box_refinement_view(
    crop: LoadedCrop, rng: np.random.Generator, plan: BoxRefinementPlan, strength: float, *, cut: bool = True
) -> tuple[Picture, FloatArray]:
    """A patch about a box that is a little off its sign, and the steps from there onto it.

    Args:
        crop: a sign and what is around it.
        rng: of the draw.
        plan: how far boxes are off.
        strength: how often distance, blur and compression strike, in [0, 1]; 0: nothing changes the picture.
        cut: cut the picture anew within the border that GTSRB leaves.

    Returns:
        BGR uint8, shape (48, 48, 3), and shape (4,), as :func:`~tsr_engine.detection.refine.box_refinement.move_edges`
        takes them.
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
    """The crop with less around its sign, and the box there; see the module."""
    height, width = pixels.shape[:2]
    side = max(box[2] - box[0], box[3] - box[1])
    room = np.maximum(0.0, [box[0], box[1], width - box[2], height - box[3]])
    if (room >= _ROOMY * side).all() and rng.random() < 0.5:
        return pixels, box
    left, top, right, bottom = np.minimum(room, 1.4 * MARGIN * side) * rng.random(4)
    x1, y1 = max(0, math.floor(box[0] - left)), max(0, math.floor(box[1] - top))
    x2, y2 = min(width, math.ceil(box[2] + right)), min(height, math.ceil(box[3] + bottom))
    return pixels[y1:y2, x1:x2], box - np.array([x1, y1, x1, y1])
