"""Training of [20]: colours from annotated boxes, SVMs from signs and from proposals without signs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from sklearn.svm import LinearSVC

from benchmarks.systems.colour_model import ColourModel, fit_colours
from benchmarks.systems.colour_mser import ColourMser
from benchmarks.systems.hog_svm import FAMILIES, LENGTH, MARGIN, SIDE, HogSvm, describe_boxes
from benchmarks.systems.log_odds import fit_log_odds
from benchmarks.systems.proposals import ProposalPlan, propose
from benchmarks.systems.sign_patches import SignPatch, crop_patches, scene_patches
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.gtsrb import CropItem
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import FloatArray
from tsr_engine.training.public.mining import PictureChanges, searched_picture
from tsr_engine.training.public.patches import PATCH

Progress = Callable[[str], None]
_SILENT: Final = -100.0
_BYTES: Final = 800.0
"""Bytes per unit of a descriptor's value."""


@dataclass(frozen=True, slots=True)
class SvmPlan:
    """Settings of the training.

    Attributes:
        cost: C of the linear SVMs.
        jittered: number of patches around each annotated sign.
        crop_frames: number of patches from each GTSRB track.
        searched: share of the scenes whose proposals are used.
        first: number of random background proposals from each scene for the first round.
        hard: number of background proposals with the highest scores of the first round, from each scene.
        own: number of proposals on signs from each scene.
        relit: share of the scenes with changed light.
        log_odds: number of calibration scenes for the log-odds.
    """

    cost: float = 0.05
    jittered: int = 6
    crop_frames: int = 3
    searched: float = 0.4
    first: int = 30
    hard: int = 40
    own: int = 8
    relit: float = 0.35
    log_odds: int = 60


@dataclass(frozen=True, slots=True)
class _Samples:
    """Descriptors and the class of each; -1 is background.

    All background of all scenes is in memory, so descriptors, which lie in [0, 0.3], are stored as bytes.
    """

    bytes: NDArray[np.uint8]
    classes: NDArray[np.int64]

    @classmethod
    def of(cls, descriptors: NDArray[np.float32], classes: object) -> _Samples:
        whole = np.clip(np.round(descriptors * _BYTES), 0, 255)
        return cls(whole.astype(np.uint8).reshape(-1, LENGTH), np.asarray(classes, np.int64))

    @property
    def descriptors(self) -> NDArray[np.float32]:
        """Shape (n, LENGTH), float32."""
        return self.bytes.astype(np.float32) / np.float32(_BYTES)

    def at(self, rows: NDArray[np.int64]) -> _Samples:
        """The samples of some rows."""
        return _Samples(self.bytes[rows], self.classes[rows])


DEFAULT_PLAN: Final = SvmPlan()


def train_colour_mser(
    train: Sequence[Scene],
    calibrate: Sequence[Scene],
    crops: Sequence[CropItem],
    seed: int,
    progress: Progress,
    plan: SvmPlan = DEFAULT_PLAN,
) -> tuple[ColourMser, JsonObject]:
    """Train the system.

    Args:
        train: annotated scenes to learn from.
        calibrate: scenes for the log-odds.
        crops: GTSRB crops as further signs.
        seed: random seed.
        progress: called with each stage.
        plan: settings of the training.

    Returns:
        The model and a record of the training.

    Raises:
        ValueError: the scenes hold no sign of a colour.
    """
    proposals = ProposalPlan()
    rng = np.random.default_rng([seed, 37])
    progress("colours")
    colours = fit_colours(train, rng)
    progress("signs")
    signs = _signs(train, crops, colours, plan, rng)
    progress("proposals")
    order = rng.permutation(len(train))[: max(1, round(len(train) * plan.searched))]
    seen = [_proposed(train[i], colours, proposals, plan, rng) for i in order]
    samples = _joined([signs, *(mine for mine, _ in seen), *(_random(off, plan.first, rng) for _, off in seen)])
    progress(f"first machines: {len(samples.classes)} samples")
    svm = _fit(samples, plan.cost, seed)
    samples = _joined([samples, *(_hardest(off, plan.hard, svm) for _, off in seen)])
    progress(f"machines: {len(samples.classes)} samples")
    svm = _fit(samples, plan.cost, seed)
    progress("calibration")
    calibration, recall = _log_odds(calibrate[: plan.log_odds], colours, proposals, svm)
    record = {
        "scenes": len(train),
        "signs": sum(len(s.boxes) for s in train),
        "crops": len(crops),
        "positives": int((samples.classes >= 0).sum()),
        "negatives": int((samples.classes < 0).sum()),
        "calibration_proposal_recall": recall,
        "plan": asdict(plan),
    }
    return ColourMser(colours, proposals, svm, calibration), record


def proposal_recall(boxes: FloatArray, truth: FloatArray) -> int:
    """Number of true boxes (m, 4) that a proposal (n, 4) covers with an IoU of at least 0.5."""
    return int((iou(truth, boxes).max(axis=1, initial=0.0) >= 0.5).sum())


def _signs(
    train: Sequence[Scene], crops: Sequence[CropItem], colours: ColourModel, plan: SvmPlan, rng: np.random.Generator
) -> _Samples:
    """Descriptors of jittered signs of scenes and of crops."""
    sign = SIDE / (1 + 2 * MARGIN)
    low = (PATCH - sign) / 2
    box = np.array([[low, low, PATCH - low, PATCH - low]])

    def seen(patch: SignPatch) -> NDArray[np.float32]:
        described: NDArray[np.float32] = describe_boxes(patch.picture, colours.maps(patch.picture), box)[0]
        return described

    patches = [*scene_patches(train, plan.jittered, sign, rng)]
    if crops:
        patches += crop_patches(crops, train, plan.crop_frames, sign, rng)
    return _Samples.of(np.stack([seen(p) for p in patches]), [p.class_id for p in patches])


def _proposed(
    scene: Scene, colours: ColourModel, proposals: ProposalPlan, plan: SvmPlan, rng: np.random.Generator
) -> tuple[_Samples, _Samples]:
    """A scene's proposals on signs, and those on no sign."""
    picture = searched_picture(scene, rng, PictureChanges(plan.relit))
    found = propose(picture, colours, proposals, DetectorParams(far_top=0.0, far_bottom=1.0))
    overlap = iou(found.boxes, scene.boxes)
    on = np.flatnonzero(overlap.max(axis=1, initial=0.0) >= 0.65)
    on = on[rng.permutation(len(on))[: plan.own]]
    labels = scene.class_ids[overlap[on].argmax(axis=1)] if len(on) else np.zeros(0, np.int64)
    off = np.flatnonzero(iou(found.boxes, scene.occupied).max(axis=1, initial=0.0) < 0.3)
    return (
        _Samples.of(describe_boxes(picture, found.maps, found.boxes[on]), labels),
        _Samples.of(describe_boxes(picture, found.maps, found.boxes[off]), np.full(len(off), -1)),
    )


def _joined(parts: Sequence[_Samples]) -> _Samples:
    return _Samples(np.concatenate([p.bytes for p in parts]), np.concatenate([p.classes for p in parts]))


def _random(samples: _Samples, count: int, rng: np.random.Generator) -> _Samples:
    return samples.at(rng.permutation(len(samples.classes))[:count])


def _hardest(samples: _Samples, count: int, svm: HogSvm) -> _Samples:
    return samples.at(np.argsort(-svm.scores(samples.descriptors), kind="stable")[:count])


def _fit(samples: _Samples, cost: float, seed: int) -> HogSvm:
    """Train one machine for each family, against all background."""
    weights, offsets = [], []
    background = samples.classes < 0
    descriptors = samples.descriptors
    for classes in FAMILIES.values():
        mine = np.isin(samples.classes, list(classes))
        rows = mine | background
        if not mine.any():  # a family without samples never wins
            weights.append(np.zeros(LENGTH))
            offsets.append(_SILENT)
            continue
        machine = LinearSVC(C=cost, class_weight="balanced", dual=True, max_iter=2000, tol=1e-3, random_state=seed)
        machine.fit(descriptors[rows], mine[rows])
        weights.append(machine.coef_[0])
        offsets.append(machine.intercept_[0])
    return HogSvm(np.array(weights, np.float32), np.array(offsets, np.float32))


def _log_odds(
    scenes: Sequence[Scene], colours: ColourModel, proposals: ProposalPlan, svm: HogSvm
) -> tuple[tuple[float, float], float]:
    """``c0, c1`` of ``log-odds = c0 * value + c1``, fitted on scenes without training, and the proposals' recall."""
    results = []
    for scene in scenes:
        picture = read_picture(scene.path)
        found = propose(picture, colours, proposals, DetectorParams())
        values = svm.scores(describe_boxes(picture, found.maps, found.boxes))
        results.append((found.boxes, values, scene.boxes))
    covered = sum(proposal_recall(boxes, signs) for boxes, _, signs in results)
    return fit_log_odds(results), covered / max(1, sum(len(signs) for _, _, signs in results))
