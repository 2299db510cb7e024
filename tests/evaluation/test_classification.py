from pathlib import Path

import cv2
import numpy as np
import pytest

from tsr_engine.evaluation.classification import crop_of, evaluate_classification, predict_items
from tsr_engine.evaluation.plots import plot_confusion
from tsr_engine.io.gtsrb import CropItem


class ByBrightness:
    """A classifier with class = mean brightness / 4 and probability 0.75."""

    margin = 0.1

    def __init__(self) -> None:
        self.batches: list[int] = []

    def probabilities(self, crops: list[np.ndarray]) -> np.ndarray:
        self.batches.append(len(crops))
        p = np.full((len(crops), 43), 0.25 / 42, np.float32)
        for row, crop in zip(p, crops, strict=True):
            row[int(crop.mean()) // 4] = 0.75
        return p


def items(folder: Path, count: int) -> list[CropItem]:
    made = []
    for i in range(count):
        path = folder / f"{i:05d}.png"
        picture = np.full((40, 30, 3), 255, np.uint8)
        picture[6:34, 5:25] = 4 * i + 2
        cv2.imwrite(str(path), picture)
        made.append(CropItem(path, (8, 10, 22, 30), i))
    return made


def test_pictures_are_classified_in_order_and_in_batches(tmp_path: Path) -> None:
    classifier = ByBrightness()
    answers = list(predict_items(items(tmp_path, 7), classifier, batch=3))
    assert [(a.item.filename, a.class_id, a.probability) for a in answers] == [
        (f"{i:05d}.png", i, 0.75) for i in range(7)
    ]
    assert classifier.batches == [3, 3, 1]


def test_the_roi_is_used_when_given(tmp_path: Path) -> None:
    (item,) = items(tmp_path, 1)
    assert crop_of(item, 0.1).shape == (24, 16, 3)
    assert crop_of(CropItem(item.path), 0.1).shape == (40, 30, 3)


def test_a_batch_below_one_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="batch"):
        next(predict_items(items(tmp_path, 1), ByBrightness(), 0))


def test_figures_by_hand(tmp_path: Path) -> None:
    report = evaluate_classification([1, 1, 1, 2, 2, 5], [1, 2, 2, 2, 1, 5])
    assert report.pictures == 6
    assert report.accuracy == pytest.approx(3 / 6)
    assert report.per_class == pytest.approx({1: 1 / 3, 2: 1 / 2, 5: 1.0})
    assert [(c.true, c.predicted, c.count) for c in report.confusions()] == [(1, 2, 2), (2, 1, 1)]
    assert len(report.confusions(1)) == 1
    plot_confusion(report, tmp_path / "matrix.png")
    assert cv2.imread(str(tmp_path / "matrix.png")).shape[1] > 800


def test_no_pictures_at_all() -> None:
    report = evaluate_classification([], [])
    assert (report.accuracy, report.per_class, report.confusions()) == (0.0, {}, [])


@pytest.mark.parametrize(("true", "predicted"), [([1, 2], [1]), ([43], [0]), ([0], [-1])])
def test_lists_of_different_lengths_are_refused(true: list[int], predicted: list[int]) -> None:
    with pytest.raises(ValueError, match=r"ids must be"):
        evaluate_classification(true, predicted)
