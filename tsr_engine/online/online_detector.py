"""``M_on``, the online detector of one track: learns samples, forgets old ones, scores windows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from tsr_engine.online.features import FEATURES, SIDE, describe_with_neighbours
from tsr_engine.online.incremental_svm import IncrementalSVC
from tsr_engine.online.relocalisation import relocalise
from tsr_engine.params.online import OnlineParams
from tsr_engine.protocols import PixelSource
from tsr_engine.records import FloatArray, Relocalisation, Sample

Origin = Literal["offline", "prediction", "result", "background"]


RING_DISTANCES = (0.5, 0.25)
"""Distance of background windows from a confident result, in window sides."""


def is_describable(box: FloatArray) -> bool:
    """Whether a box is finite and large enough to be described."""
    return bool(np.isfinite(box).all() and box[2] - box[0] >= 4.0 and box[3] - box[1] >= 4.0)


@dataclass(slots=True)
class OnlineDetector:
    """The online detector of one track (Algorithms 1 and 2).

    Attributes:
        params: parameters of the online detector.
        svm: the incremental SVM; its samples have the order of ``samples``.
        samples: the current samples.
    """

    params: OnlineParams
    svm: IncrementalSVC
    samples: list[Sample]

    def learn(self, pixels: PixelSource, box: FloatArray, label: int, frame: int) -> tuple[Sample, ...]:
        """Learn the crop of a prediction (Algorithm 1), and unlearn samples older than ``sample_age`` frames.

        With ``background_negatives``, windows around a positive crop are learned as negative samples. Without
        ``learn_rejected``, a negative crop itself is not learned.

        Args:
            pixels: the frame.
            box: the prediction, shape (4,), px.
            label: +1 for a confident prediction, else -1.
            frame: ordinal of the frame.

        Returns:
            The learned samples, then the unlearned ones.
        """
        samples: list[Sample] = []
        if is_describable(box) and (label > 0 or self.params.learn_rejected):
            samples += self._learn_around(pixels, box, label, frame, "prediction")
        return (*samples, *self._forget(frame))

    def begin(self, pixels: PixelSource, box: FloatArray, frame: int) -> tuple[Sample, ...]:
        """Learn the box of the track's first frame; returns the learned samples."""
        return tuple(self._learn_around(pixels, box, 1, frame, "result")) if is_describable(box) else ()

    def relocalise(self, pixels: PixelSource, box: FloatArray) -> Relocalisation | None:
        """The best window around a prediction (Algorithm 2); None if the box is too small or not finite."""
        return relocalise(pixels, box, self.svm, self.params) if is_describable(box) else None

    def _learn_around(
        self, pixels: PixelSource, box: FloatArray, label: int, frame: int, origin: Origin
    ) -> list[Sample]:
        offsets = ring_offsets(self.params.background_negatives) if label > 0 else []
        vectors, _ = describe_with_neighbours(pixels, box, offsets)
        labels = [label] + [-1] * len(offsets)
        origins: list[Origin] = [origin]
        origins += ["background"] * len(offsets)
        self.svm.partial_fit(vectors, labels)
        learned = [Sample("learned", k, o, frame) for k, o in zip(labels, origins, strict=True)]
        self.samples += learned
        return learned

    def _forget(self, frame: int) -> list[Sample]:
        """Unlearn samples older than T frames; offline samples stay."""
        limit = frame - self.params.sample_age
        old = [k for k, sample in enumerate(self.samples) if sample.frame >= 0 and sample.frame < limit]
        if not old:
            return []
        self.svm.unlearn(old)
        unlearned = [Sample("unlearned", s.label, s.origin, s.frame) for s in (self.samples[k] for k in old)]
        self.samples = [s for k, s in enumerate(self.samples) if k not in set(old)]
        return unlearned


class OnlineDetectorMaker:
    """Makes the online detectors of a run; all start from one solution on the offline samples.

    Args:
        X: offline descriptors, shape (m, 324).
        y: labels -1 or +1, shape (m,).
        params: parameters of the run.

    Raises:
        ValueError: an array has another shape, or a label is neither -1 nor +1.
    """

    def __init__(self, X: ArrayLike, y: ArrayLike, params: OnlineParams) -> None:
        samples = np.asarray(X, dtype=np.float64)
        if samples.ndim != 2 or samples.shape[1] != FEATURES:
            raise ValueError(f"Offline samples must have shape (m, {FEATURES}). Got {samples.shape} instead.")
        self._params = params
        self._svm = IncrementalSVC(C=params.svm_c).partial_fit(samples, np.asarray(y))
        self._samples = [Sample("learned", int(label), "offline", -1) for label in self._svm.y_]

    def __call__(self, pixels: PixelSource, box: FloatArray, frame: int) -> tuple[OnlineDetector, tuple[Sample, ...]]:
        """The detector of a track whose first box is ``box``, and its first samples."""
        detector = OnlineDetector(self._params, self._svm.copy(), list(self._samples))
        return detector, (*self._samples, *detector.begin(pixels, box, frame))


def ring_offsets(count: int) -> list[tuple[int, int]]:
    """Displacements of ``count`` windows on two rings around the middle one, in window px, alternately far and near."""
    offsets = []
    for k in range(count):
        angle = 2.0 * math.pi * (k + 0.5 * (k % 2)) / count
        distance = RING_DISTANCES[k % 2] * SIDE
        offsets.append((round(distance * math.cos(angle)), round(distance * math.sin(angle))))
    return offsets
