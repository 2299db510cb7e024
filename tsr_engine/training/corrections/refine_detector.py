"""Refines a detector with corrections in minutes; a whole training takes an hour.

The cascade's trees stay. The verifier of the refine-and-verify stage gets further trees: boosting continues from the
detector's log-odds on corrected signs, on background of the reviewed videos, on rejected tracks, and on samples of the
earlier training (the component ``memory``), so that other signs keep their scores. The box refinement's outputs are
pulled towards the corrected boxes and, on remembered windows, towards the earlier answers. The log-odds are calibrated
again, so that background which the new trees did not see keeps its level. The cascade's last floor is lowered if it
loses corrected signs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import Ridge

from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.boosting import BoostingPlan, boost_further
from tsr_engine.detection.log_odds import LogOdds
from tsr_engine.detection.refine.box_refinement import BoxRefinement
from tsr_engine.detection.refine.stage import CELLS
from tsr_engine.detection.trees import NEVER, UNIT, TreeEnsemble
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import FloatArray
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene
from tsr_engine.training.corrections.refine_windows import Cutting, TrainingWindows, cut_windows
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.memory import Samples, concatenate_samples

__all__ = ["DetectorRefinement", "refine_detector"]


_BACKGROUND_QUANTILES: Final = (0.5, 0.97)
"""Quantiles of the background whose log-odds a refinement keeps."""
_MIN_SLOPE: Final = 1e-3
"""Least weight of the verifier in the calibration; below it there is nothing to refine."""


@dataclass(frozen=True, slots=True)
class DetectorRefinement:
    """Settings of a detector's refinement.

    The defaults were chosen by leaving out each of three clips in turn, which are not used for figures.

    Attributes:
        trees: largest number of trees added to the verifier.
        trees_a_sign: trees per corrected sign, up to ``trees``: few signs do not show the variety of signs.
        shrinkage: factor on the new leaves.
        feature_share: share of features available to one tree.
        cutting: numbers of windows.
        sign: total weight of a corrected sign.
        other: weight of a background candidate; a rejected box weighs three times as much.
        remembered: weight of a remembered sample.
        inertia: resistance of a leaf to change, in the same units.
        box_ridge: resistance of the box refinement's outputs to change.
        box_memory: weight of a remembered window there, relative to a corrected one.
        lowest_floor: the cascade's last floor is not lowered below this, in half log-odds.
        least_signs: with fewer corrected signs the detector is not refined.
    """

    trees: int = 64
    trees_a_sign: float = 1.0
    shrinkage: float = 0.3
    feature_share: float = 1 / 16
    cutting: Cutting = field(default_factory=Cutting)
    sign: float = 10.0
    other: float = 1.0
    remembered: float = 1.0
    inertia: float = 8.0
    box_ridge: float = 3.0
    box_memory: float = 0.5
    lowest_floor: float = -3.0
    least_signs: int = 1


def refine_detector(
    model: AcfModel,
    scenes: Sequence[CorrectedScene],
    remembered: tuple[Samples, Samples] | None,
    settings: DetectorRefinement,
    seed: int,
    progress: Progress,
) -> tuple[AcfModel, JsonObject]:
    """Refine a detector.

    Args:
        model: the earlier detector.
        scenes: corrected frames.
        remembered: signs and background of the earlier training; unset: corrections alone, which forgets more.
        settings: the settings.
        seed: seed of all draws.
        progress: called with stage, number done and total; may raise to stop.

    Returns:
        The new detector, and facts about its data for the lineage: numbers of signs, windows, background candidates,
        rejected boxes and remembered samples, the cascade's last floor, and the calibration.

    Raises:
        ValueError: fewer corrected signs than ``settings.least_signs``, or a calibration that ignores the verifier.
        InputError: a picture cannot be decoded.
    """
    names = sorted({sign for scene in scenes for sign in scene.signs})
    if len(names) < settings.least_signs or not names:
        raise ValueError(f"A detector is refined with {settings.least_signs} signs or more. Got {len(names)} instead.")
    if model.calibration.verifier < _MIN_SLOPE:
        raise ValueError("This detector's calibration ignores its verifier, so it cannot be refined.")
    rng = np.random.default_rng([seed, 21])
    windows = cut_windows(model, scenes, names, settings.cutting, rng, progress)
    progress("boxes", 0, 1)
    box_refinement = _refit_box_refinement(model.box_refinement, windows, remembered, settings)
    calibration = _recalibrate(model, windows, remembered, settings, seed, progress)
    progress("more trees", 0, 1)
    added = _boost_verifier(model, windows, remembered, settings, seed, np.ones(len(windows.others), bool))
    stage = replace(model.refine_stage, verifier=_concatenate_trees(model.refine_stage.verifier, added))
    floor, cascade = _lower_floor(model.cascade, windows.floors, settings.lowest_floor)
    refined = replace(
        model, cascade=cascade, refine_stage=stage, box_refinement=box_refinement, calibration=calibration
    )
    notes = {
        "signs": len(names),
        "windows": len(windows.signs),
        "background": len(windows.others),
        "rejected": windows.rejected,
        "remembered": 0 if remembered is None else sum(map(len, remembered)),
        "floor": floor,
        "calibration": calibration.to_list(),
    }
    return refined, notes


def _boost_verifier(
    model: AcfModel,
    windows: TrainingWindows,
    remembered: tuple[Samples, Samples] | None,
    settings: DetectorRefinement,
    seed: int,
    others_used: NDArray[np.bool_],
) -> TreeEnsemble:
    """New trees of the verifier on its own scale: boosted in log-odds, divided by the calibration's slope."""
    others = windows.others.select(others_used)
    parts = [windows.signs, others]
    targets = [np.ones(len(windows.signs)), np.zeros(len(others))]
    weights = [settings.sign * windows.sign_weights, settings.other * windows.other_weights[others_used]]
    for part in remembered or ():
        parts.append(part)
        targets.append(_probability(part.raw(model)))
        weights.append(np.full(len(part), settings.remembered))
    samples = concatenate_samples(parts)
    signs = int(windows.sign_of.max()) + 1
    count = max(1, min(settings.trees, round(settings.trees_a_sign * signs)))
    plan = BoostingPlan(count, model.refine_stage.verifier.depth, settings.feature_share, settings.shrinkage, 1.0)
    grown = boost_further(
        samples.features,
        np.concatenate(targets),
        np.concatenate(weights),
        samples.raw(model) / 2,
        plan,
        np.random.default_rng([seed, 22]),
        CELLS,
        settings.inertia,
    )
    scaled = np.round(grown.leaves * (2.0 / model.calibration.verifier)).clip(-32000, 32000)
    return TreeEnsemble(grown.features, grown.thresholds, scaled.astype(np.int16), grown.rejection, CELLS)


def _probability(raw: FloatArray) -> FloatArray:
    return np.asarray(1.0 / (1.0 + np.exp(np.clip(-raw, -60.0, 60.0))))


def _concatenate_trees(first: TreeEnsemble, second: TreeEnsemble) -> TreeEnsemble:
    return TreeEnsemble(
        np.concatenate([first.features, second.features]),
        np.concatenate([first.thresholds, second.thresholds]),
        np.concatenate([first.leaves, second.leaves]),
        np.concatenate([first.rejection, second.rejection]),
        first.window,
    )


def _refit_box_refinement(
    box_refinement: BoxRefinement,
    windows: TrainingWindows,
    remembered: tuple[Samples, Samples] | None,
    settings: DetectorRefinement,
) -> BoxRefinement:
    """The box refinement with its answers moved to the corrected boxes by the smallest change.

    Minimises ``sum_new |x (W + D) - y|^2 + m sum_remembered |x D|^2 + r |D|^2`` over D, where x are the map's features
    and 1 for the bias.
    """
    scale = np.sqrt(windows.sign_weights / windows.sign_weights.mean())[:, None]
    rows = [_with_one(windows.signs.edges) * scale]
    answers = [(windows.steps - box_refinement.steps_of(windows.signs.edges)) * scale]
    if remembered is not None:
        old = _with_one(remembered[0].edges)
        rows.append(old * np.sqrt(settings.box_memory))
        answers.append(np.zeros((len(old), 4)))
    x, y = np.concatenate(rows), np.concatenate(answers)
    resistance = settings.box_ridge * float((x * x).sum()) / len(x)
    change = Ridge(resistance, fit_intercept=False, solver="cholesky").fit(x, y).coef_.T
    weights = (box_refinement.weights + change[:-1]).astype(np.float16).astype(np.float32)
    return replace(box_refinement, weights=weights, bias=(box_refinement.bias + change[-1]).astype(np.float32))


def _with_one(features: NDArray[np.float32]) -> FloatArray:
    return np.column_stack([features.astype(np.float64), np.ones(len(features))])


def _recalibrate(
    model: AcfModel,
    windows: TrainingWindows,
    remembered: tuple[Samples, Samples] | None,
    settings: DetectorRefinement,
    seed: int,
    progress: Progress,
) -> LogOdds:
    """Calibrate so that background keeps its log-odds, and thresholds keep their false detections.

    The new trees' answers on background come from trees that did not see it: two halves, each scored by the other's
    trees. Its median and an upper quantile are mapped to their earlier values.
    """
    rng = np.random.default_rng([seed, 23])
    half_of_new = _halves(windows.video_of_other, rng)
    half_of_old = np.zeros(0, bool) if remembered is None else rng.random(len(remembered[1])) < 0.5
    before, after = [], []
    for half in (False, True):
        progress("calibration", int(half), 2)
        is_trained_on, held_parts = half_of_new != half, [windows.others.select(half_of_new == half)]
        memory = remembered
        if remembered is not None:
            memory = remembered[0], remembered[1].select(half_of_old != half)
            held_parts.append(remembered[1].select(half_of_old == half))
        trees = _boost_verifier(model, windows, memory, settings, seed, is_trained_on)
        held = concatenate_samples(held_parts)
        raw = held.raw(model)
        before.append(raw)
        after.append(raw + model.calibration.verifier * trees.scores(held.features) / UNIT)
    levels = [
        np.quantile(np.concatenate(part), _BACKGROUND_QUANTILES) for part in (before, after) if sum(map(len, part))
    ]
    if len(levels) < 2:
        return model.calibration
    (low, high), (new_low, new_high) = levels
    factor = float(np.clip((high - low) / max(new_high - new_low, 1e-6), 0.3, 1.5))
    return model.calibration.scaled(factor, float(high - factor * new_high))


def _halves(videos: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.bool_]:
    """Split background into halves, by video if there are several, else at random."""
    names = np.unique(videos)
    if len(names) > 1:
        return np.isin(videos, rng.permutation(names)[: len(names) // 2])
    return np.asarray(rng.random(len(videos)) < 0.5)


def _lower_floor(cascade: TreeEnsemble, missed: FloatArray, lowest: float) -> tuple[float, TreeEnsemble]:
    """Lower the cascade's last floor so that lost corrected signs pass; return the floor, in half log-odds, and it."""
    floor = cascade.rejection[-1] / UNIT
    recoverable = missed[(missed >= lowest) & (missed < floor)] if len(missed) else missed
    if cascade.rejection[-1] <= NEVER or not len(recoverable):
        return float(max(floor, -1e6)), cascade
    new_floor = max(lowest, float(recoverable.min()) - 0.05)
    rejection = cascade.rejection.copy()
    rejection[rejection == rejection[-1]] = round(new_floor * UNIT)
    return new_floor, cascade.with_rejection(rejection)
