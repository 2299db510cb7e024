"""Evaluates the classification of single crops: predictions, accuracy, confusions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from tsr_engine.io.gtsrb import CropItem, read_picture
from tsr_engine.protocols import CropClassifier
from tsr_engine.recognition.crops import cut
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import Picture


@dataclass(frozen=True, slots=True)
class Prediction:
    """The classifier's result for one picture."""

    item: CropItem
    class_id: int
    probability: float


def crop_of(item: CropItem, margin: float) -> Picture:
    """The crop for a classifier: the ROI with its margin, or the whole picture without a ROI.

    A picture without a ROI counts as a GTSRB picture, which includes a border of about 10 %.

    Raises:
        InputError: the picture cannot be read.
    """
    picture = read_picture(item)
    return picture if item.roi is None else cut(picture, item.roi, margin)


def predict_items(items: Iterable[CropItem], classifier: CropClassifier, batch: int = 64) -> Iterator[Prediction]:
    """Classify pictures in order, ``batch`` at a time.

    Raises:
        ValueError: ``batch`` is below 1.
        InputError: a picture cannot be read.
    """
    if batch < 1:
        raise ValueError(f"batch must be >= 1. Got {batch} instead.")
    source = iter(items)
    while chunk := list(islice(source, batch)):
        probabilities = classifier.probabilities([crop_of(item, classifier.margin) for item in chunk])
        for item, row in zip(chunk, probabilities, strict=True):
            best = int(row.argmax())
            yield Prediction(item, best, float(row[best]))


@dataclass(frozen=True, slots=True)
class Confusion:
    """Pictures of one class that were classified as another."""

    true: int
    predicted: int
    count: int


@dataclass(frozen=True, slots=True, eq=False)
class ClassificationReport:
    """Figures over pictures of known classes."""

    matrix: NDArray[np.int64]
    """Shape (c, c): pictures by true class (row) and predicted class (column)."""

    @property
    def pictures(self) -> int:
        """Number of pictures."""
        return int(self.matrix.sum())

    @property
    def accuracy(self) -> float:
        """Share of correctly classified pictures, in [0, 1]; 0 without pictures."""
        return float(np.trace(self.matrix) / max(self.pictures, 1))

    @property
    def per_class(self) -> dict[int, float]:
        """Recall of each class with pictures, in [0, 1]."""
        totals = self.matrix.sum(1)
        return {c: float(self.matrix[c, c] / totals[c]) for c in range(len(totals)) if totals[c]}

    def confusions(self, most: int = 10) -> list[Confusion]:
        """The most frequent confusions, most frequent first."""
        off = self.matrix - np.diag(np.diag(self.matrix))
        order = np.argsort(-off, axis=None, kind="stable")[:most]
        pairs = [divmod(int(i), len(off)) for i in order]
        return [Confusion(t, p, int(off[t, p])) for t, p in pairs if off[t, p]]


def evaluate_classification(
    true: Sequence[int], predicted: Sequence[int], classes: int = CLASS_COUNT
) -> ClassificationReport:
    """Compare true and predicted class ids; ``classes`` is the number of classes.

    Raises:
        ValueError: the lengths differ, or an id is outside 0..classes - 1.
    """
    t, p = np.asarray(true, dtype=np.int64), np.asarray(predicted, dtype=np.int64)
    if t.shape != p.shape or t.ndim != 1:
        raise ValueError(f"True and predicted ids must be lists of one length. Got {t.shape} and {p.shape}.")
    for name, ids in (("true", t), ("predicted", p)):
        if ids.size and not (ids.min() >= 0 and ids.max() < classes):
            raise ValueError(f"Class ids must be in 0..{classes - 1}. Got {ids.min()}..{ids.max()} in {name}.")
    matrix = np.zeros((classes, classes), dtype=np.int64)
    np.add.at(matrix, (t, p), 1)
    return ClassificationReport(matrix)
