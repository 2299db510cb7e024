"""Makes the component ``memory``: samples of the models' training data, for refinements.

A refinement sees only a few corrected signs. To keep it from forgetting the others, the models contain samples of the
earlier training: windows of signs and of background as the detector's refine-and-verify stage scores them, and
the second moment of the classifier's features. The component is made from GTSDB and GTSRB for one detector and
classifier, and serves all versions that descend from them.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.detection.acf import AcfDetector, AcfModel
from tsr_engine.detection.patch import cut_patch
from tsr_engine.detection.refine.stage import FEATURES, features_of
from tsr_engine.detection.trees import UNIT
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.gtsrb import CropItem, tracks_of
from tsr_engine.io.models import Component
from tsr_engine.io.pictures import read_picture
from tsr_engine.params.detector import DetectorParams
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.mining import away_from_signs
from tsr_engine.training.public.patches import PATCH, jitter, window_features
from tsr_engine.training.synthetic.classifier_augmentation import jittered_view, load_crop, plain_view

__all__ = [
    "COMPONENT",
    "Samples",
    "build_memory",
    "concatenate_samples",
    "crop_memory",
    "refined_at",
    "samples_at",
]

COMPONENT: Final = "memory"
MAX_SIGNS: Final = 360
MAX_OTHERS: Final = 640
PER_CLASS: Final = 12
"""Remembered crops per class."""


@dataclass(frozen=True, slots=True)
class Samples:
    """Windows in the form that the verifier uses.

    Attributes:
        features: shape (n, FEATURES), uint8, after the first step of the refine-and-verify stage.
        cascade: shape (n,), scores of the cascade at the found windows.
        sign_verifier: shape (n,), scores of the refined boxes.
        edges: shape (n, h), the box refinement's features of the refined boxes.
    """

    features: NDArray[np.uint8]
    cascade: FloatArray
    sign_verifier: FloatArray
    edges: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.features)

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]], name: str) -> Samples:
        """Restore the samples ``signs`` or ``others`` from the component's arrays.

        Raises:
            KeyError: the component is from an earlier version.
        """
        cascade, sign_verifier = (arrays[f"{name}_{score}"].astype(np.float64) for score in ("cascade", "likeness"))
        return cls(
            arrays[name].astype(np.uint8, copy=False),
            cascade,
            sign_verifier,
            arrays[f"{name}_edges"].astype(np.float32),
        )

    @classmethod
    def empty(cls, model: AcfModel) -> Samples:
        """Empty samples for a model."""
        edges = np.zeros((0, model.box_refinement.features.length), np.float32)
        return cls(np.zeros((0, FEATURES), np.uint8), np.zeros(0), np.zeros(0), edges)

    def to_arrays(self, name: str) -> dict[str, NDArray[np.generic]]:
        """Arrays for :meth:`from_arrays`."""
        return {
            name: self.features,
            f"{name}_cascade": self.cascade.astype(np.float32),
            f"{name}_likeness": self.sign_verifier.astype(np.float32),
            f"{name}_edges": self.edges.astype(np.float16),
        }

    def select(self, which: NDArray[np.generic]) -> Samples:
        """Select some samples by index or mask."""
        return Samples(*(getattr(self, f.name)[which] for f in fields(self)))

    def raw(self, model: AcfModel) -> FloatArray:
        """Log-odds of being a sign by a model, shape (n,)."""
        verified = model.refine_stage.verifier.scores(self.features) / UNIT
        return model.calibration.of(verified, self.cascade, self.sign_verifier)


def concatenate_samples(parts: Sequence[Samples]) -> Samples:
    """Concatenate samples."""
    return Samples(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Samples)))


def samples_at(model: AcfModel, picture: Picture, boxes: FloatArray, cascade: FloatArray | None = None) -> Samples:
    """Samples of candidate boxes (n, 4), moved by the first step as in detection."""
    return refined_at(model, picture, boxes, cascade)[0]


def refined_at(
    model: AcfModel, picture: Picture, boxes: FloatArray, cascade: FloatArray | None = None
) -> tuple[Samples, FloatArray]:
    """As ``samples_at``, with the boxes from the refine-and-verify stage, shape (n, 4), px."""
    if cascade is None:  # the cascade's scores of windows exactly on the boxes
        cut = [window_features(cut_patch(picture, box, model.window.sign, PATCH), model.window) for box in boxes]
        cascade = model.cascade.scores(np.stack(cut)) / UNIT
    moved = model.refine_stage.step(0, boxes, features_of(picture, boxes))
    features = features_of(picture, moved)
    refined = model.refine_stage.step(1, moved, features)
    edges = model.box_refinement.features_of(picture, refined)
    return Samples(features, cascade, model.sign_verifier.scores(picture, refined), edges), refined


def build_memory(
    scenes: Sequence[Scene],
    crops: Sequence[CropItem],
    model: AcfModel,
    classifier: SignClassifier,
    seed: int,
    progress: Progress,
) -> Component:
    """Draw the samples.

    Args:
        scenes: annotated scenes; signs are drawn evenly over their classes, and background by the detector's
            highest scores.
        crops: items of GTSRB tracks.
        model: the detector.
        classifier: the classifier.
        seed: seed of all draws.
        progress: called with stage, number done and total.
    """
    rng = np.random.default_rng([seed, 11])
    signs, others = _windows(scenes, model, rng, progress)
    moment, features, classes = crop_memory(crops, classifier, rng, progress)
    arrays: dict[str, NDArray[np.generic]] = {
        **signs.to_arrays("signs"),
        **others.to_arrays("others"),
        "moment": moment.astype(np.float32),
        "crops": features.astype(np.float16),
        "classes": classes.astype(np.int8),
    }
    data = {"scenes": len(scenes), "crops": len(crops), "tracks": len(tracks_of(crops))}
    return Component(COMPONENT, arrays, {"per_class": PER_CLASS}, data, {}, seed)


def _windows(
    scenes: Sequence[Scene], model: AcfModel, rng: np.random.Generator, progress: Progress
) -> tuple[Samples, Samples]:
    frequency = np.maximum(1, np.bincount(np.concatenate([s.class_ids for s in scenes]), minlength=CLASS_COUNT))
    detector = AcfDetector(model, params=DetectorParams(second_core=False))
    signs: list[Samples] = []
    others: list[Samples] = []
    weights: list[float] = []
    for number, scene in enumerate(scenes):
        progress("scenes to remember", number, len(scenes))
        picture = read_picture(scene.path)
        for box, class_id in zip(scene.boxes, scene.class_ids, strict=True):
            signs.append(samples_at(model, picture, jitter(box, rng, 0.08, 0.08)[None]))
            weights.append(float(frequency[class_id]) ** -0.5)
        boxes, scores = detector.candidates(picture)
        clear = np.flatnonzero(away_from_signs(boxes, scene.occupied))[:4]
        if len(clear):
            others.append(samples_at(model, picture, boxes[clear], scores[clear]))
    every, wrong = concatenate_samples(signs), concatenate_samples(others)
    share = np.array(weights) / np.sum(weights)
    return (
        every.select(np.sort(rng.choice(len(every), min(MAX_SIGNS, len(every)), replace=False, p=share))),
        wrong.select(np.sort(rng.permutation(len(wrong))[:MAX_OTHERS])),
    )


def crop_memory(
    crops: Sequence[CropItem],
    classifier: SignClassifier,
    rng: np.random.Generator,
    progress: Progress,
    unseen: Container[int] = (),
) -> tuple[FloatArray, NDArray[np.float32], NDArray[np.int64]]:
    """Mean of ``x x^T`` over views of crops, with equal class weights, ``x`` = features and 1; and remembered features.

    Args:
        crops: items of GTSRB tracks.
        classifier: computes the features.
        rng: source of all draws.
        progress: called with stage, number done and total.
        unseen: classes that no view may show, see ``jittered_view``.
    """
    by_class: dict[int, list[CropItem]] = {}
    for _, items in sorted(tracks_of(crops).items()):
        for item in (items[i] for i in rng.choice(len(items), min(3, len(items)), replace=False)):
            if item.class_id is not None:
                by_class.setdefault(item.class_id, []).append(item)
    length = classifier.features.length + 1
    moment, kept, classes = np.zeros((length, length)), [], []
    for number, (class_id, items) in enumerate(sorted(by_class.items())):
        progress("crops to remember", number, CLASS_COUNT)
        loaded = [load_crop(items[i]) for i in rng.permutation(len(items))[:60]]
        views = [jittered_view(crop, rng, 0.5, unseen) for crop in loaded]
        of_views = _features(classifier, [view for view, _ in views])
        rows = np.concatenate([of_views, np.ones((len(of_views), 1))], axis=1)
        moment += rows.T @ rows / (len(rows) * len(by_class))
        plain = _features(classifier, [plain_view(crop) for crop in loaded[:PER_CLASS]])
        kept.append(plain)
        classes += [class_id] * len(plain)
    return moment, np.concatenate(kept).astype(np.float32), np.array(classes, np.int64)


def _features(classifier: SignClassifier, patches: Sequence[Picture]) -> FloatArray:
    return np.asarray(classifier.features.of_patches(np.stack(patches)), dtype=np.float64)
