"""The experiment on taught labels: its training data, counts and report."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.classifiers import teaching_labels
from benchmarks.classifiers.teaching_labels import FRAMES, HIDDEN, base_classifier, figures_of, taught_crops
from benchmarks.experiment import Result
from benchmarks.experiments.teaching import EXPERIMENT
from tsr_engine.io.gtsrb import CropItem
from tsr_engine.training.public.classifier import ClassifierSettings


@pytest.fixture
def items(tmp_path: Path) -> list[CropItem]:
    """Two tracks of 30 frames for each of three classes, one of them hidden."""
    path = tmp_path / "00000_00000.png"
    cv2.imwrite(str(path), np.random.default_rng(0).integers(0, 256, (24, 24, 3)).astype(np.uint8))
    return [
        CropItem(path, (2, 2, 22, 22), class_id, (class_id, track), frame)
        for class_id in (1, HIDDEN[0], 39)
        for track in range(2)
        for frame in range(30)
    ]


def test_the_number_of_taught_tracks_per_hidden_label(items: list[CropItem]) -> None:
    crops = taught_crops(items, 1, {HIDDEN[0]: 43}, np.random.default_rng(0))
    assert [crop.crop.class_id for crop in crops] == [43] * FRAMES
    assert len({crop.sign for crop in crops}) == 1
    both = taught_crops(items, 5, {HIDDEN[0]: 43}, np.random.default_rng(0))
    assert len({crop.sign for crop in both}) == 2


def test_the_base_learns_from_other_labels_alone(items: list[CropItem], monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []

    def fit(crops, settings, seed, report, stage, unseen):  # type: ignore[no-untyped-def]
        seen.append(({crop.class_id for crop in crops}, unseen))
        raise StopIteration

    monkeypatch.setattr(teaching_labels, "fit_arrays", fit)
    with pytest.raises(StopIteration):
        base_classifier(items, items, 0, ClassifierSettings(steps=1))
    assert seen == [({1, 39}, HIDDEN)]


def test_old_and_new_labels_are_counted_apart() -> None:
    margins = np.array([[5, 0, 0], [0, 4, 0], [0, 0, 5], [5, 0, 0], [0, 5, 0]], np.float32)
    signs, truth = np.array([0, 0, 1, 1, 2]), np.array([0, 2, 1])
    found = figures_of(margins, 1.0, signs, truth, 2)
    assert found["old_single"] == pytest.approx(2 / 3)
    assert found["new_single"] == 0.5
    assert found["old_tracks"] == 1.0, "the surer frame counts more"
    assert found["new_tracks"] == found["worst_label"] == 0.0


def test_a_network_takes_only_probability_of_the_old_labels() -> None:
    votes = np.array([[0.30, 0.25, 0.45], [0.2, 0.2, 0.6], [0.4, 0.15, 0.45], [0.6, 0.2, 0.2], [0.2, 0.1, 0.7]])
    signs, truth = np.arange(5), np.array([2, 2, 0, 0, 0])
    found = figures_of(np.log(votes).astype(np.float32), 1.0, signs, truth, 2)
    assert found["new_tracks"] == 1.0
    assert found["mixed_new"] == 0.5, "a network may give one old label all 0.55 of the first"
    assert (found["mixed_old"], found["mixed_old_half"]) == pytest.approx((2 / 3, 1 / 3))
    before = figures_of(np.log(votes[2:, :2]).astype(np.float32), 1.0, np.arange(3), np.array([0, 0, 2]), 2)
    assert (before["mixed_new"], before["mixed_old"], before["mixed_old_half"]) == (0.0, 1.0, 1.0)


def test_the_report_says_which_targets_are_met() -> None:
    one = {"old_single": 0.99, "new_single": 0.9, "old_tracks": 0.997, "new_tracks": 0.95, "worst_label": 0.8}
    one |= {"mixed_new": 0.93, "mixed_old": 1.0, "mixed_old_half": 0.998}
    figures = {"0": {**one, "new_tracks": 0.0}, "1": one, "5": one, "20": {**one, "old_tracks": 0.99}}
    text = EXPERIMENT.report(Result("teaching", figures=figures))
    assert (
        "- 5 tracks of each new label: 0.950 of the new labels' tracks are classified correctly (bar 0.90: met)" in text
    )
    assert "(bar 0.97: missed)" in text
    assert "at least 0.930 of the new labels' tracks are correct (bar 0.97: missed)" in text
    assert "The other labels lose 0.70 percentage points of tracks (bar 0.2: missed)" in text
    assert text.index("| 5 |") < text.index("| 20 |")
