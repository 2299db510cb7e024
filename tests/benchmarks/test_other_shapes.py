"""The experiment on signs outside the 43 classes: counts and report."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.experiment import Result, Skip
from benchmarks.experiments.other_shapes import (
    EXPERIMENT,
    OTHERS,
    Sign,
    counts,
    read_boxes,
    read_signs,
    read_unannotated,
)
from tsr_engine.labels.files import shipped_set
from tsr_engine.records import Detections, Picture

SIGN, OTHER, BOARD = (np.array([x, 10.0, x + 30, 40.0]) for x in (10.0, 110.0, 210.0))


def test_found_signs_and_false_detections_are_counted() -> None:
    signs = [Sign(SIGN, "43", "II-1"), Sign(OTHER, "other", "III-6"), Sign(BOARD, "", "IV-5")]
    nowhere, within = np.array([400.0, 10, 430, 40]), np.array([212.0, 12, 222, 22])
    found = counts(
        [
            (signs, np.array([OTHER, BOARD, within, nowhere]), np.array([4.0, 3, 2, 1])),
            ([], np.zeros((0, 4)), np.zeros(0)),
        ]
    )
    assert found == {
        "43": 1, "43_found": 0, "43_at_rate": 0, "other": 1, "other_found": 1, "other_at_rate": 1,
        "false": 1, "pictures": 2,
    }  # fmt: skip
    surer = (signs, np.array([OTHER, nowhere]), np.array([4.0, 5]))
    assert counts([surer])["other_at_rate"] == 0
    assert counts([surer, *[([], np.zeros((0, 4)), np.zeros(0))] * 4])["other_at_rate"] == 1


def test_boxes_by_code_and_by_name_are_read(tmp_path: Path) -> None:
    for name in ("a.jpg", "b.jpg"):
        cv2.imwrite(str(tmp_path / name), np.zeros((8, 8, 3), np.uint8))
    place = {"file": "a.jpg", "ignore": False}
    named = {**place, "box": [1.0, 2, 31, 42], "shape": "circle", "kind": "upright"}
    rows = [
        {**place, "bbox": [1, 2, 30, 40], "code": "II-34"},
        {**place, "bbox": [1, 2, 30, 40], "code": "II-47"},
        {**place, "bbox": [1, 2, 30, 40], "code": "IV-5"},
        {**place, "bbox": [1, 2, 12, 19], "code": "II-34"},
        {**place, "bbox": [1, 2, 30, 40], "code": "II-34", "ignore": True},
        {**named, "gtsrb": 14, "name": "stop"},
        {**named, "gtsrb": -1, "name": "parking"},
        {**named, "gtsrb": -1, "name": "board", "kind": "board"},
    ]
    (tmp_path / "boxes.json").write_text(json.dumps(rows))
    read = read_boxes(tmp_path)
    assert [sign.kind for sign in read["a.jpg"]] == ["other", "43", "", "", "", "43", "other", ""]
    assert {tuple(sign.box) for sign in read["a.jpg"]} == {(1, 2, 31, 42), (1, 2, 13, 21)}
    assert read["b.jpg"] == []


def test_boxes_of_another_form_are_named(tmp_path: Path) -> None:
    with pytest.raises(Skip, match=r"boxes\.json cannot be read"):
        read_boxes(tmp_path)
    (tmp_path / "boxes.json").write_text('[{"file": "a.jpg", "bbox": [1, 2, 3, 4]}]')
    with pytest.raises(Skip, match=r"boxes\.json cannot be read"):
        read_boxes(tmp_path)


def test_unannotated_signs_are_neither_found_nor_false() -> None:
    extra = read_unannotated("dfg_half")
    seen = next(iter(extra.values()))
    found = np.array([sign.box for sign in seen])
    scores = np.ones(len(seen))
    assert counts([([], found, scores)])["false"] == len(seen)
    known = counts([(seen, found, scores)])
    assert known["false"] == known["43_found"] == known["other_found"] == 0
    assert read_unannotated("elsewhere") == {}


class _TwoBoxDetector:
    """Finds two places in every picture, and reads each sign as class 14."""

    name = "finder"
    margin = 0.1

    def detect(self, picture: Picture) -> Detections:
        boxes = np.array([[1.0, 2, 31, 42], [50, 2, 62, 14]])
        return Detections(boxes, np.array([2.0, 1]), np.full(2, 0.5), np.array([2.0, 1]))

    def probabilities(self, crops: list[Picture]) -> NDArray[np.float32]:
        return np.eye(43, dtype=np.float32)[[14] * len(crops)]


def test_signs_are_found_and_read_by_size(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((60, 90, 3), np.uint8))
    sign = {"file": "a.png", "ignore": False, "shape": "circle", "kind": "upright", "name": "sign"}
    rows = [
        {**sign, "box": [1, 2, 31, 42], "gtsrb": 14},
        {**sign, "box": [50, 2, 62, 14], "gtsrb": 13},
        {**sign, "box": [60, 40, 85, 59], "gtsrb": 14},
        {**sign, "box": [1, 2, 31, 42], "gtsrb": 14, "ignore": True},
        {**sign, "box": [50, 20, 62, 34], "gtsrb": -1},
    ]
    (tmp_path / "boxes.json").write_text(json.dumps(rows))
    assert read_signs(_TwoBoxDetector(), _TwoBoxDetector(), tmp_path) == {
        "large": {"signs": 2, "found": 1, "right": 1},
        "any": {"signs": 3, "found": 2, "right": 1},
    }


def test_codes_of_other_signs_are_labels_of_the_set() -> None:
    labels = {label.key: label for label in shipped_set("vienna")}
    assert all(labels[key].id >= 43 for key in OTHERS.values())


def test_the_report_has_every_figure() -> None:
    cv = {"recall_at_0.2": 0.812, "score": -1.5, "recall_at_1": 0.9, "ap50": 0.7, "signs": 99, "pictures": 600}
    one = {"43": 15, "43_found": 13, "other": 13, "other_found": 4, "other_at_rate": 3, "false": 6}
    one |= {"pictures": 24}
    both = {**one, "looked_at": {**one, "other_at_rate": 4, "false": 3}}
    read = {"large": {"signs": 31, "found": 30, "right": 29}, "any": {"signs": 33, "found": 32, "right": 28}}
    result = Result(
        "other_shapes",
        figures={
            "cross_validation": cv,
            "foreign": {"dfg": {"without": both, "with": {**both, "other_found": 11}, "read": read}},
            "price": {"without": 39.1, "with": 87.4, "ratio": 2.23},
            "model_bytes": 512_345,
        },
    )
    text = EXPERIMENT.report(result)
    for words in (
        "0.812",
        "-1.50",
        "4 of 13",
        "11 of 13",
        "3 of 13",
        "13 of 15",
        "0.25",
        "0.12",
        "39.1 ms",
        "87.4 ms",
        "2.23",
        "0.5 MB",
        "| dfg | 31 | 30 | 29 | 33 | 32 | 28 |",
    ):
        assert words in text
    assert EXPERIMENT.headline is not None
    assert EXPERIMENT.headline(result) == "39.1 ms without, 87.4 ms with"
