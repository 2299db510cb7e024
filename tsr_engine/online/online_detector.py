"""``M_on``, the online detector of one track: learns samples, forgets old ones, scores windows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from tsr_engine.online.features import FEATURES, SIDE, describe, describe_around
from tsr_engine.online.incremental_svm import IncrementalSVC
from tsr_engine.online.relocalisation import relocalise
from tsr_engine.params.online import OnlineParams
from tsr_engine.protocols import PixelSource
from tsr_engine.records import FloatArray, Relocalisation, Sample

__all__ = ["OnlineDetector", "OnlineDetectorMaker", "usable"]

Origin = Literal["offline", "prediction", "result", "background"]


RINGS = (0.5, 0.25)
"""Distance of background windows from a confident result, in window sides."""


def usable(box: FloatArray) -> bool:
    """Whether a box is finite and large enough to be described."""
    return bool(np.isfinite(box).all() and box[2] - box[0] >= 4.0 and box[3] - box[1] >= 4.0)


@dataclass(slots=True)
class OnlineDetector:
    """The online detector of one track (Algorithms 1 and 2).

    Attributes:
        params: parameters.
        svm: the incremental SVM; its samples are, in order, those of ``samples``.
        samples: what the model consists of at present.
    """

    params: OnlineParams
    svm: IncrementalSVC
    samples: list[Sample]

    def describe(self, pixels: PixelSource, box: FloatArray) -> FloatArray:
        """The descriptor of a box, shape (324,)."""
        return describe(pixels, box)

    def learn(self, pixels: PixelSource, box: FloatArray, label: int, frame: int) -> tuple[Sample, ...]:
        """Learn the crop of a prediction (Algorithm 1) and unlearn what is older than ``sample_age`` frames.

        With ``background_negatives``, windows around a positive crop are learned as negative ones; without
        ``learn_rejected`` a negative crop itself is not learned.

        Returns:
            What was learned and unlearned, in this order.
        """
        done: list[Sample] = []
        if usable(box) and (label > 0 or self.params.learn_rejected):
            done += self._learn_around(pixels, box, label, frame, "prediction")
        return (*done, *self._forget(frame))

    def begin(self, pixels: PixelSource, box: FloatArray, frame: int) -> tuple[Sample, ...]:
        """Learn the box that the track was born with."""
        return tuple(self._learn_around(pixels, box, 1, frame, "result")) if usable(box) else ()

    def relocalise(self, pixels: PixelSource, box: FloatArray, frame: int) -> Relocalisation | None:
        """The best window around a prediction (Algorithm 2); None where the box cannot be searched.

        ``frame`` is accepted for symmetry with :meth:`learn`; the search depends on the samples alone.
        """
        del frame
        return relocalise(pixels, box, self.svm, self.params) if usable(box) else None

    def _learn_around(
        self, pixels: PixelSource, box: FloatArray, label: int, frame: int, origin: Origin
    ) -> list[Sample]:
        offsets = ring_offsets(self.params.background_negatives) if label > 0 else []
        vectors, _ = describe_around(pixels, box, offsets)
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
        gone = [Sample("unlearned", s.label, s.origin, s.frame) for s in (self.samples[k] for k in old)]
        self.samples = [s for k, s in enumerate(self.samples) if k not in set(old)]
        return gone


class OnlineDetectorMaker:
    """Makes the online detectors of a run from the offline samples; they are solved once.

    Args:
        X: offline descriptors, shape (m, 324).
        y: labels -1 or +1, shape (m,).
        params: parameters of the run.

    Raises:
        ValueError: arrays of another shape, or labels other than -1 and +1.
    """

    def __init__(self, X: ArrayLike, y: ArrayLike, params: OnlineParams) -> None:
        samples = np.asarray(X, dtype=np.float64)
        if samples.ndim != 2 or samples.shape[1] != FEATURES:
            raise ValueError(f"Offline samples must have shape (m, {FEATURES}). Got {samples.shape} instead.")
        self._params = params
        self._svm = IncrementalSVC(C=params.svm_c).partial_fit(samples, np.asarray(y))
        self._samples = [Sample("learned", int(label), "offline", -1) for label in self._svm.y_]

    def __call__(self, pixels: PixelSource, box: FloatArray, frame: int) -> tuple[OnlineDetector, tuple[Sample, ...]]:
        """The detector of a track born in ``box``, and the samples that it starts from."""
        detector = OnlineDetector(self._params, self._svm.copy(), list(self._samples))
        return detector, (*self._samples, *detector.begin(pixels, box, frame))


def ring_offsets(count: int) -> list[tuple[int, int]]:
    """Displacements of ``count`` windows on two rings around the middle one, in window px, in turn near and far."""
    offsets = []
    for k in range(count):
        angle = 2.0 * math.pi * (k + 0.5 * (k % 2)) / count
        distance = RINGS[k % 2] * SIDE
        offsets.append((round(distance * math.cos(angle)), round(distance * math.sin(angle))))
    return offsets
