"""Trains the detector of other shapes, for signs that the 43 classes lack, on annotated scenes and drawn signs.

It is an ACF model like the detector of the 43 classes and uses the same pyramid, which is computed once per picture.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np

from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.boosting import BoostingPlan
from tsr_engine.detection.log_odds import UNFITTED
from tsr_engine.detection.other_shapes import COMPONENT, MAX_NESTED_RATIO
from tsr_engine.errors import InputError
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.models import Component
from tsr_engine.labels.files import VIENNA, shipped_set
from tsr_engine.labels.model import Label
from tsr_engine.records import FloatArray
from tsr_engine.training.progress import Progress, named
from tsr_engine.training.public.candidates import Candidates, candidates_of, log_odds_of, score_candidates
from tsr_engine.training.public.classifier_network import NetworkSettings
from tsr_engine.training.public.detector import DetectorPlan, fit_cascade, sign_positives
from tsr_engine.training.public.mining import CascadeScan
from tsr_engine.training.public.refine_stage import RefinementPlan, train_refine_stage
from tsr_engine.training.public.sign_verifier import (
    SignVerifierPlan,
    background_crops,
    surrounded_signs,
    train_sign_verifier,
)
from tsr_engine.training.synthetic.drawn_scenes import DrawnScenesPlan, drawn_keys, drawn_scenes

__all__ = ["OtherShapesPlan", "fit_other_shapes", "train_other_shapes"]

FOLDS: Final = 2
"""Number of parts of the scenes; each is evaluated by a model that was trained on the others."""
FALSE_PER_PICTURE: Final = 0.2
"""Rate of false detections at which recall is reported."""
MIN_SIGN_PX: Final = 20.0
"""Smallest longer side of a counted sign, px."""


@dataclass(frozen=True, slots=True)
class OtherShapesPlan:
    """Settings of the training of the detector of other shapes.

    Attributes:
        drawn: settings of the drawn signs.
        detector: settings of cascade, refine-and-verify stage and sign verifier.
    """

    drawn: DrawnScenesPlan = field(default_factory=DrawnScenesPlan)
    detector: DetectorPlan = field(
        default_factory=lambda: DetectorPlan(
            rounds=(32, 128, 512), mining_share=(0.3, 0.6), jittered=8, crop_frames=0, per_scene=60,
            random_per_scene=100, most_negatives=40_000, other_cameras=0.0, shaded=0.0,
            refinement=RefinementPlan(
                views=1, starts=3, candidates=25, relit=0.2, other_cameras=0.0, shaded=0.0,
                boosting=BoostingPlan(384, 4, 1 / 16, 0.3),
            ),
            sign_verifier=SignVerifierPlan(
                steps=4000, drawn=0.0, scene_signs=0.5, background=0.5, candidates=25, relit=0.2, other_cameras=0.0,
                shaded=0.0, network=NetworkSettings(filters=48, hidden=96, common=True),
            ),
        )
    )  # fmt: skip


def fit_other_shapes(
    scenes: Sequence[Scene], base: AcfModel, plan: OtherShapesPlan, seed: int, progress: Progress
) -> AcfModel:
    """Train a detector on the signs of the scenes and on drawn signs.

    Args:
        scenes: scenes with the annotated signs as signs, see :func:`~.gtsdb_signs.other_signs`.
        base: the detector that it extends, which supplies window, pyramid and box refinement.
        plan: the settings.
        seed: seed of all randomness.
        progress: progress.

    Raises:
        InputError: a picture cannot be decoded, or no scene has a sign.
    """
    if not any(len(scene.boxes) for scene in scenes):
        raise InputError("Expected scenes with annotated signs to train a detector on, got none. Name such scenes.")
    own = plan.detector
    finer = replace(base.plan, computed_per_octave=own.computed_in_training)
    with tempfile.TemporaryDirectory(prefix="tsr-drawn-") as name:
        rng = np.random.default_rng([seed, 41])
        drawn = drawn_scenes(scenes, plan.drawn, Path(name), rng)
        # Drawings are weighted by group and annotated signs by label, so that neither outweigh the others.
        every = [*scenes, *(replace(scene, class_ids=_FIRST + _groups_of(scene)) for scene in drawn)]
        positives, weights = sign_positives(every, [], base.window, finer, own, rng, progress)
        cascade, _ = fit_cascade(positives, weights, every, base.window, finer, own, rng, progress)
        scan = CascadeScan(cascade, base.window, base.plan)
        rng = np.random.default_rng([seed, 43])
        stage = train_refine_stage(every, scan, own.refinement, rng, progress)
        rng = np.random.default_rng([seed, 47])
        background = background_crops(every, scan, stage, own.sign_verifier, rng, progress)
        grouped = [replace(scene, class_ids=_groups_of(scene)) for scene in (*scenes, *drawn)]
        verifier = train_sign_verifier([], surrounded_signs(grouped), background, own.sign_verifier, rng, progress)
    return replace(base, cascade=cascade, refine_stage=stage, sign_verifier=verifier, calibration=UNFITTED)


def train_other_shapes(
    scenes: Sequence[Scene], detector: Component, seed: int, progress: Progress, plan: OtherShapesPlan | None = None
) -> Component:
    """Train the component ``other_shapes`` and evaluate it by cross-validation over scenes.

    Each part of the scenes is evaluated by a model of the other parts, calibrated on candidates of their models.
    The returned model is trained on all scenes and calibrated on the candidates of all parts.

    Args:
        scenes: see :func:`fit_other_shapes`.
        detector: component of the detector that it extends.
        seed: seed of the parts and all randomness.
        progress: called with stage, number done and total.
        plan: unset: :class:`OtherShapesPlan`'s defaults.

    Raises:
        InputError: a picture cannot be decoded.
        ValueError: no scene has a sign.
    """
    plan = plan or OtherShapesPlan()
    base = AcfModel.from_arrays(detector.arrays, detector.params)
    part_of = np.random.default_rng([seed, 53]).permutation(len(scenes)) % FOLDS
    final = fit_other_shapes(scenes, base, plan, seed, named("final model", progress))
    parts: list[list[Candidates]] = []
    for part in range(FOLDS):
        of_part = named(f"part {part + 1} of {FOLDS}", progress)
        learned = [scene for scene, own in zip(scenes, part_of, strict=True) if own != part]
        held = [scene for scene, own in zip(scenes, part_of, strict=True) if own == part]
        parts.append(
            candidates_of(fit_other_shapes(learned, base, plan, seed, of_part), held, of_part, nested=MAX_NESTED_RATIO)
        )
    raw: list[FloatArray] = []
    for part, own in enumerate(parts):
        calibration = log_odds_of([one for other in range(FOLDS) if other != part for one in parts[other]])
        raw += [one.raw(calibration) for one in own]
    every = [one for own in parts for one in own]
    score = score_candidates(every, raw, MIN_SIGN_PX)
    figures = {
        "ap50": round(score.average_precision, 4),
        f"recall_at_{FALSE_PER_PICTURE}": round(score.recall_at(FALSE_PER_PICTURE), 4),
        "recall_at_1": round(score.recall_at(1.0), 4),
        "signs": score.signs,
        "pictures": score.pictures,
    }
    arrays, settings = replace(final, calibration=log_odds_of(every)).to_arrays()
    shared = base.box_refinement.to_arrays()
    data = {
        "scenes": {"source": "GTSDB", "scenes": len(scenes), "signs": sum(len(scene.boxes) for scene in scenes)},
        "drawn_labels": len(drawn_keys()),
        "figures_from": {
            "parts": FOLDS,
            "beside": detector.sha256,
            "least_px": MIN_SIGN_PX,
            "score": round(score.threshold_at(FALSE_PER_PICTURE), 4),
        },
        "plan": asdict(plan),
    }
    arrays = {name: array for name, array in arrays.items() if name not in shared}
    return Component(COMPONENT, arrays, settings, data, figures, seed)


_FIRST: Final = 1000
"""First class id of the groups of drawn signs, above the ids of all labels."""


def _groups_of(scene: Scene) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Groups of the scene's signs, in place of their labels."""
    labels = {label.id: label for label in shipped_set(VIENNA)}
    return np.array([_group(labels[int(i)]) for i in scene.class_ids], np.int64)


def _group(label: Label) -> int:
    """Group of labels with a similar appearance; the sign verifier has one machine per group."""
    for number, words in enumerate(_GROUP_WORDS):
        if any(word in label.key for word in words):
            return number
    if label.shape == "circle" and label.category == "mandatory":
        return len(_GROUP_WORDS) + len(_SHAPES) + 1
    return len(_GROUP_WORDS) + (_SHAPES.index(label.shape) if label.shape in _SHAPES else len(_SHAPES))


_GROUP_WORDS: Final = (
    ("no-stopping", "no-parking"),
    ("zone",),
    ("parking",),
    ("crossing", "pedestrian-bridge", "residential"),
    ("one-way", "through-road"),
    ("bus-stop", "tram-stop", "transport-stop"),
    ("motorway", "motor-vehicles"),
)
"""Words in the keys of a group's labels; the first match counts."""
_SHAPES: Final = ("rectangle", "circle", "triangle")
"""Shapes that form a group of labels without a matching word."""
