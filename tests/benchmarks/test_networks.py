"""Networks trained without some crops, and the report on them."""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.classifiers import networks
from benchmarks.experiment import Data, Result, Skip
from benchmarks.experiments.network import EXPERIMENT
from tests.recognition.test_network import component
from tsr_engine.io.gtsrb import CropItem
from tsr_engine.recognition.classifier import SignClassifier


@pytest.fixture
def items(tmp_path: Path) -> list[CropItem]:
    path = tmp_path / "00000_00000.png"
    cv2.imwrite(str(path), np.random.default_rng(0).integers(0, 256, (24, 24, 3)).astype(np.uint8))
    return [CropItem(path, (2, 2, 22, 22), class_id, (class_id, 0), 0) for class_id in (1, 4, 39)]


def test_a_network_is_trained_once_per_folder(
    items: list[CropItem], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def trained(items: list[CropItem], seed: int) -> SignClassifier:
        seen.append([item.class_id for item in items])
        return SignClassifier.from_component(component())

    monkeypatch.setattr(networks, "_trained", trained)
    data = Data(None, None, None, None, tmp_path)
    made = [networks.trained_on(items, items, data, "base") for _ in range(2)]
    assert seen == [[1, 4, 39]]
    assert made[0].temperature == made[1].temperature != 0.3


def test_without_pytorch_the_experiment_says_what_is_missing(
    items: list[CropItem], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(Skip, match=r"no PyTorch to train a network with: pip install 'tsr\[network\]'"):
        networks.trained_on(items, items, Data(None, None, None, None, tmp_path), "base")


def test_the_report_has_each_part_and_the_total() -> None:
    one = {"accuracy": 0.997, "accuracy_shaken_boxes": 0.994, "negative_log_likelihood": 0.01, "tracks": 333}
    all_of_it = {**one, "accuracy": 0.9968, "tracks": 1307, "frames": 30, "fused": 1 - 1 / 1307, "crop_ms": 0.66}
    text = EXPERIMENT.report(Result("network", figures={**all_of_it, "crops": 39209, "each": [one, one]}))
    assert "0.9968 of the single crops are correct with the annotated boxes, 0.9940 with boxes off" in text
    assert "1 of the 1307 signs is classified wrongly" in text
    assert "| 1 | 333 | 0.9970 |" in text
    assert text.index("| 1 | 333") < text.index("| all | 1307 |")
