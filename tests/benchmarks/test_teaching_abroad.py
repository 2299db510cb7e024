"""The experiment on another country's signs: taught and read labels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.experiment import Data, Result, Skip
from benchmarks.experiments import teaching_abroad
from benchmarks.experiments.other_shapes import CLASSES, OTHERS
from benchmarks.experiments.teaching_abroad import EXPERIMENT, SignView, leave_one_out
from tsr_engine.labels.classes import default_keys
from tsr_engine.pipeline import load_reader
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop


def test_codes_map_to_known_or_new_labels() -> None:
    assert set(CLASSES.values()) <= set(default_keys())
    assert not set(OTHERS.values()) & set(default_keys())


def test_each_picture_is_read_by_a_model_taught_on_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    taught = []

    def refine(grown: Any, crops: Any, *_: Any) -> Any:
        taught.append([(grown.labels or default_keys())[crop.crop.class_id] for crop in crops])
        bias = np.zeros(len(grown.bias), np.float32)
        bias[-1] = 1  # the last label is read everywhere
        return np.zeros_like(grown.weights), bias

    monkeypatch.setattr(teaching_abroad, "refine_classifier", refine)
    view = np.full((48, 48, 3), 90, np.uint8)
    shown = [("a", "parking"), ("a", "stop"), ("b", "parking"), ("c", "one-way"), ("c", "give-way")]
    signs = [SignView(picture, key, LoadedCrop(view, np.array([4.0, 4, 44, 44]), 0), view) for picture, key in shown]
    classifier = load_reader(reader="classifier")
    assert isinstance(classifier, SignClassifier)
    found = leave_one_out(signs, classifier, np.eye(385), 9)
    assert taught == [
        ["parking", "one-way", "give-way"],
        ["parking", "stop", "one-way", "give-way"],
        ["parking", "stop", "parking"],
    ]
    assert (found["old"], found["old_after"]) == (2, 0)
    assert (found["new"], found["new_after"]) == (2, 0), "of the two labels taught, the last one is read"
    assert found["only_once"] == 1
    text = EXPERIMENT.report(Result("teaching_abroad", figures=found))
    assert "| of new labels, seen in another scene | 2 | 0 | 0 |" in text
    assert "cannot be taught: 1 sign." in text


def test_without_the_pictures_it_is_skipped(tmp_path: Path) -> None:
    with pytest.raises(Skip, match="dfg_half"):
        EXPERIMENT.run(Data(None, None, None, None, tmp_path, foreign=tmp_path))
