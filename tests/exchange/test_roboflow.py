"""Data sets with pictures that Roboflow has changed."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.exchange.image_datasets import picture_by_frame, read_onto_drive, write_dataset
from tsr_engine.errors import ImportFormatError

NOTES = """
signs - v1 2025-03-24
==============================

This dataset was exported via roboflow.com on March 24, 2025

The following pre-processing was applied to each image:
* Auto-orientation of pixel data (with EXIF-orientation stripping)
* {}

"""
NAME = f"drive_mp4-0010_jpg.rf.{'0a1b2c3d' * 4}"


@pytest.mark.parametrize("format", ["yolo", "coco", "voc"])
@pytest.mark.parametrize(
    "step",
    [
        "Resize to 640x640 (Fit (black edges))",
        "Resize to 640x640 (Fill (with center crop))",
        "50% probability of horizontal flip",
        "Random rotation of between -15 and +15 degrees",
        "Equal probability of one of the following 90-degree rotations: none, clockwise",
        "Random shear of between -10\u00b0 to +10\u00b0 horizontally",
        "Randomly crop between 0 and 20 percent of the image",
    ],
)
def test_boxes_of_augmented_pictures_are_refused(tmp_path: Path, format: str, step: str) -> None:
    path = write_dataset(tmp_path, format, [NAME])
    (path / "README.roboflow.txt").write_text(NOTES.format(step), encoding="utf-8")
    with pytest.raises(
        ImportFormatError, match=r"README\.roboflow\.txt, line 9: says of the pictures: .*Export a version"
    ):
        read_onto_drive(path, format)


@pytest.mark.parametrize(
    "step",
    [
        "Resize to 640x640 (Stretch)",
        "Resize to 640x640 (Fit within)",
        "Resize to 1280x720 (Fit (black edges))",
        "Random brigthness adjustment of between -25 and +25 percent",
        "Salt and pepper noise was applied to 5 percent of pixels",
    ],
)
def test_changes_that_keep_boxes_in_place_are_accepted(tmp_path: Path, step: str) -> None:
    path = write_dataset(tmp_path, "yolo", [NAME])
    (path / "README.roboflow.txt").write_text(NOTES.format(step))
    assert picture_by_frame(read_onto_drive(path)) == {10: 0}
