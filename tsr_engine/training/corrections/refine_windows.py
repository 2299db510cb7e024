"""Cuts training windows out of corrected frames.

The windows, of signs and of background, are those that the refine-and-verify stage sees.

Corrected boxes touch their sign. The detector's training scenes have a margin, which the detector removes in use. So
the margin is added before windows are cut.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsr_engine.detection.acf import AcfDetector, AcfModel
from tsr_engine.detection.refine.box_inset import BoxInset
from tsr_engine.detection.refine.box_refinement import steps_between
from tsr_engine.geometry.boxes import covered_share, iou
from tsr_engine.io.pictures import read_picture
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.memory import Samples, concatenate_samples, refined_at, samples_at
from tsr_engine.training.public.mining import SIGN_OVERLAP, away_from_signs
from tsr_engine.training.public.patches import jitter, surroundings
from tsr_engine.training.public.refine_stage import RefinementPlan, square_about
from tsr_engine.training.synthetic.augment import relight, soften

__all__ = ["Cutting", "TrainingWindows", "cut_windows", "with_margin"]


REJECTED_WEIGHT = 3.0
"""Weight of a rejected box relative to a background candidate: it has passed the whole engine."""
STARTS = RefinementPlan()
"""Displacements of the starting boxes in the training of the regressions."""


@dataclass(frozen=True, slots=True)
class Cutting:
    """Numbers of windows.

    Attributes:
        views: views per corrected box; the first is neither relit nor softened.
        starts: jittered starting boxes per view.
        background: hardest candidates per frame that lie on no annotation.
        tight: whether corrected boxes touch the sign, as people draw them; False: they have GTSDB's margin.
    """

    views: int = 3
    starts: int = 2
    background: int = 6
    tight: bool = True


@dataclass(slots=True)
class TrainingWindows:
    """Windows of all scenes, cut once with the earlier model.

    Attributes:
        signs: n windows of signs.
        sign_weights: shape (n,); the windows of one sign sum to 1.
        sign_of: shape (n,), index of the sign.
        steps: shape (n, 4), targets of the box refinement.
        others: m windows of background and rejected boxes.
        other_weights: shape (m,).
        video_of_other: shape (m,), index of the video.
        floors: cascade scores of frames with signs that the cascade lost.
        rejected: number of rejected boxes.
    """

    signs: Samples
    sign_weights: FloatArray
    sign_of: NDArray[np.int64]
    steps: FloatArray
    others: Samples
    other_weights: FloatArray
    video_of_other: NDArray[np.int64]
    floors: FloatArray
    rejected: int


def with_margin(boxes: FloatArray) -> FloatArray:
    """Tight boxes (n, 4) with the margin of the detector's training scenes, which it removes again."""
    return BoxInset.of(DetectorParams()).undo(boxes)


def cut_windows(
    model: AcfModel,
    scenes: Sequence[CorrectedScene],
    names: Sequence[str],
    settings: Cutting,
    rng: np.random.Generator,
    progress: Progress,
) -> TrainingWindows:
    """Cut windows of signs and of everything else in the form that the refine-and-verify stage uses."""
    number_of = {name: k for k, name in enumerate(names)}
    videos = {name: k for k, name in enumerate(sorted({scene.video for scene in scenes}))}
    frames = Counter(name for scene in scenes for name in scene.signs)
    detector = AcfDetector(model, params=DetectorParams(second_core=False))
    signs, steps, sign_of, weights, floors = [], [], [], [], []
    others = [Samples.empty(model)]
    other_weights: list[float] = []
    video_of_other: list[int] = []

    def add_others(samples: Samples, weight: float, video: str) -> None:
        others.append(samples)
        other_weights.extend([weight] * len(samples))
        video_of_other.extend([videos[video]] * len(samples))

    for done, scene in enumerate(scenes):
        progress("windows of corrected frames", done, len(scenes))
        picture = read_picture(scene.scene.path)
        truth = with_margin(scene.scene.boxes) if settings.tight else scene.scene.boxes
        boxes, scores = detector.candidates(picture)
        for box, name in zip(truth, scene.signs, strict=True):
            found, step = _samples_around(model, picture, box, settings, rng)
            signs.append(found)
            steps.append(step)
            sign_of += [number_of[name]] * len(found)
            weights += [1.0 / (frames[name] * len(found))] * len(found)
            if not (iou(boxes, box[None]) >= 0.4).any():
                floors.append(float(found.cascade.max()))
        others_allowed = _is_background(boxes, scene) & away_from_signs(boxes, scene.rejected)
        clear = np.flatnonzero(others_allowed)[: settings.background]
        if len(clear):
            add_others(samples_at(model, picture, boxes[clear], scores[clear]), 1.0, scene.video)
        if len(scene.rejected):
            fooled = with_margin(scene.rejected) if settings.tight else scene.rejected
            wrong = np.concatenate([fooled, *(jitter(box, rng, 0.08, 0.08)[None] for box in fooled)])
            wrong = wrong[_is_background(wrong, scene)]
            if len(wrong):
                add_others(samples_at(model, picture, wrong), REJECTED_WEIGHT, scene.video)
    return TrainingWindows(
        concatenate_samples(signs),
        np.array(weights),
        np.array(sign_of),
        np.concatenate(steps),
        concatenate_samples(others),
        np.array(other_weights, dtype=np.float64),
        np.array(video_of_other, dtype=np.int64),
        np.array(floors),
        sum(len(scene.rejected) for scene in scenes),
    )


def _is_background(boxes: FloatArray, scene: CorrectedScene) -> NDArray[np.bool_]:
    """Which boxes overlap no sign and no ignored region; a region may be much larger than a box."""
    clear = away_from_signs(boxes, scene.scene.occupied)
    return np.asarray(clear & (covered_share(boxes, scene.scene.ignored) < SIGN_OVERLAP))


def _samples_around(
    model: AcfModel, picture: Picture, box: FloatArray, settings: Cutting, rng: np.random.Generator
) -> tuple[Samples, FloatArray]:
    """Samples around one sign, and the targets of the box refinement."""
    region, target = surroundings(picture, box)
    square = square_about(target)
    found, steps = [], []
    for k in range(settings.views):
        view = region
        if k and rng.random() < 0.5:
            view = relight(view, rng)
        if k and rng.random() < 0.3:
            view = soften(view, rng)
        starts = np.stack([jitter(square, rng, STARTS.shift, STARTS.log_scale) for _ in range(settings.starts)])
        samples, refined = refined_at(model, view, starts)
        found.append(samples)
        steps.append(steps_between(refined, np.repeat(target[None], len(refined), 0)))
    return concatenate_samples(found), np.concatenate(steps)
