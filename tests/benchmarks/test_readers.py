"""The experiment on readers: counts by crop and by sign, and the report."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.experiment import Data, Result, Skip
from benchmarks.experiments import readers
from benchmarks.experiments.readers import EXPERIMENT, Crop, figures_of
from tests.training.toy_scenes import write_gtsdb
from tsr_engine.records import Picture


class ScriptedReader:
    """A reader whose class and certainty are the first two values of a crop."""

    margin = 0.1

    def probabilities(self, crops: list[Picture]) -> np.ndarray:
        rows = np.full((len(crops), 43), 0.0, np.float32)
        for row, crop in zip(rows, crops, strict=True):
            sure = min(int(crop[0, 0, 1]), 100) / 100
            row[:] = (1 - sure) / 42
            row[crop[0, 0, 0] % 43] = sure
        return rows


def crop(sign: str, class_id: int, read: int, percent: int, side: float = 40.0) -> Crop:
    return Crop(sign, class_id, side, np.full((8, 8, 3), (read, percent, 0), np.uint8))


def test_single_crops_and_signs_are_counted_apart() -> None:
    crops = [crop("a", 3, 3, 90), crop("a", 3, 5, 60), crop("b", 7, 7, 50), crop("b", 7, 8, 99)]
    found = figures_of(crops, ScriptedReader())
    assert (found["crops"], found["right"], found["signs"], found["signs_right"]) == (4, 2, 2, 1)
    assert found["misread"] == [{"sign": "b", "class": 7, "read": 8}]
    own = np.array([0.9, 0.4 / 42, 0.5, 0.01 / 42])
    assert found["likelihood"] == pytest.approx(-np.log(own).mean(), rel=1e-5)


def test_far_views_count_less() -> None:
    near, far = crop("a", 3, 3, 60, side=48.0), crop("a", 3, 5, 90, side=16.0)
    assert figures_of([far, near], ScriptedReader())["signs_right"] == 1


def test_all_readers_read_pictures_and_scenes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stills = tmp_path / "abroad" / "stills"
    stills.mkdir(parents=True)
    cv2.imwrite(str(stills / "a.png"), np.full((90, 90, 3), (14, 90, 0), np.uint8))
    one = {"file": "a.png", "box": [10, 10, 40, 40], "kind": "upright", "ignore": False, "gtsrb": 14, "name": "stop"}
    (stills / "boxes.json").write_text(json.dumps([one, {**one, "gtsrb": -1}, {**one, "ignore": True}]))
    monkeypatch.setattr(readers, "load_reader", lambda reader: ScriptedReader())
    monkeypatch.setattr(readers, "base_clip", lambda folder, frames: folder)
    monkeypatch.setattr(readers, "engine_times", lambda video: (dict.fromkeys(readers.READERS, 20.0), 0.5))
    data = Data(
        gtsdb=write_gtsdb(tmp_path / "scenes", 8, 2), gtsrb=None, clips=None, looming=None, scratch=tmp_path,
        foreign=tmp_path / "abroad",
    )  # fmt: skip
    result = EXPERIMENT.run(data)
    found = result.figures["sets"]
    assert list(found) == ["stills", "gtsdb, scenes of the report"]
    assert {reader: one["right"] for reader, one in found["stills"].items()} == dict.fromkeys(readers.READERS, 1)
    assert found["stills"]["both"]["crops"] == 1
    assert set(result.figures["crop_ms"]) == set(readers.READERS)
    text = EXPERIMENT.report(Result("readers", figures=result.figures))
    assert "| stills | network | 1 of 1 | 1 of 1 | 0.1054 |" in text
    assert "20.0 ms (both)" in text


def test_without_any_data_it_is_skipped(tmp_path: Path) -> None:
    with pytest.raises(Skip, match="none of the folders"):
        EXPERIMENT.run(Data(gtsdb=None, gtsrb=None, clips=None, looming=None, scratch=tmp_path))
