"""Rows of YOLO label files with more numbers than a box: outlines, keypoints, confidences and track ids."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.image_datasets import assert_refused, read_onto_drive, yolo_folder
from tests.exchange.small_datasets import tracks_of

SIX = {
    "whole numbers above 1": (("0 0.5 0.5 0.1 0.1 0.9 7", "0 0.2 0.2 0.1 0.1 0.8 1"), "boxes", "above 1"),
    "a fraction": (("1 0.5 0.5 0.6 0.5 0.5 0.75", "1 0.1 0.2 0.3 0.4 0.2 1"), "triangles", "fraction"),
    "other polygons": (("0 0.1 0.2 0.3 0.4 0.2 1", "1 0.1 0.1 0.3 0.1 0.3 0.3 0.1 0.3"), "triangles", "polygons"),
    "the same twice": (("0 0.1 0.2 0.3 0.4 0.2 1", "0 0.5 0.6 0.7 0.8 0.6 1"), "triangles", "twice"),
    "nothing else": (("0 0.3 0.3 0.1 0.1 0.9 0", "0 0.6 0.6 0.1 0.1 0.8 1"), "boxes", "0 or 1"),
}


@pytest.mark.parametrize(
    ("case", "apart"), [*((case, False) for case in SIX), *((case, True) for case in SIX if case != "the same twice")]
)
def test_yolo_reads_six_numbers_alike_in_all_files(tmp_path: Path, case: str, apart: bool) -> None:
    """A triangle whose last corner touches the picture's edge ends in 0 or 1, as do the rows of two tracks."""
    lines, kind, why = SIX[case]
    if apart:
        yolo_folder(tmp_path, f"{lines[1]}\n", frame=3)
        lines = lines[:1]
    back = read_onto_drive(yolo_folder(tmp_path, "\n".join(lines) + "\n", frame=10), "yolo")
    (reported,) = [sentence for sentence in back.repaired if "six numbers" in sentence]
    assert reported.startswith("labels/train/frame_0000")
    assert kind in reported
    assert why in reported
    scores = np.concatenate([track.score for track in tracks_of(back).values()])
    assert len(scores) == 2
    assert np.isnan(scores).all() == (kind == "triangles")
    if case == "the same twice":
        boxes = sorted(tuple(np.round(track.boxes[0], 6)) for track in tracks_of(back).values())
        assert boxes == [(64.0, 72.0, 192.0, 360.0), (320.0, 216.0, 448.0, 360.0)]


def test_yolo_with_six_ambiguous_numbers_is_refused(tmp_path: Path) -> None:
    yolo_folder(tmp_path, "0 0.5 0.5 0.1 0.1 0.9 7\n", frame=3)
    yolo_folder(tmp_path, "0 0.5 0.5 0.6 0.5 0.5 0.75\n", frame=10)
    words = ("line 1", "three corners", "Got 7 at the end here, 0.75 in labels/train/frame_000010.txt, line 1")
    assert_refused(tmp_path, "yolo", "labels/train/frame_000003.txt", *words)


_CORNERS = "0.5 0.5 0.6 0.5 0.6 0.6 0.5 0.6"


@pytest.mark.parametrize(
    ("rows", "score", "tracks"),
    [
        ((f"{_CORNERS} 0.75", f"{_CORNERS} 0.5"), 0.75, ["box1"]),
        ((f"{_CORNERS} 3", f"{_CORNERS} 3"), None, ["track3"]),
        ((f"{_CORNERS} 0.75 1", f"{_CORNERS} 0.5 1"), 0.75, ["track1"]),
        ((f"{_CORNERS} 0.75 57", f"{_CORNERS} 0.5 57"), 0.75, ["track57"]),
        ((f"{_CORNERS} 0.55 0.65 0.75 1", f"{_CORNERS} 0.5 1"), 0.75, ["track1"]),
    ],
    ids=["confidence", "track id", "both", "a large track id", "both after an outline"],
)
def test_columns_behind_corners(tmp_path: Path, rows: Sequence[str], score: float | None, tracks: list[str]) -> None:
    """``save_txt`` of Ultralytics 8 writes them behind outlines and oriented boxes (``Results.save_txt``)."""
    for frame, row in enumerate(rows, start=10):
        yolo_folder(tmp_path, f"0 {row}\n", frame=frame)
    found = tracks_of(read_onto_drive(tmp_path, "yolo"))
    assert list(found) == tracks
    (track,) = found.values()
    assert np.allclose(track.boxes[1], [320, 180, 384, 216])
    assert np.isnan(track.score[0]) if score is None else track.score[0] == score


_QUAD = "0.68 0.38 0.72 0.38 0.72 0.42 0.68 0.42"
_MARKED = "0.68 0.38 0.9 0.72 0.38 0.8 0 0 0.1 0.68 0.42 0.7"


@pytest.mark.parametrize(
    ("points", "shape"),
    [
        (_QUAD, "[4, 2]"),
        (f"{_QUAD} 0.9", "[4, 2]"),
        (f"{_QUAD} 0.9 7", "[4, 2]"),
        (_MARKED, "[4, 3]"),
        (f"{_MARKED} 0.9", "[4, 3]"),
        (f"{_MARKED} 0.9 1", "[4, 3]"),
    ],
)
def test_keypoints_without_their_shape_are_refused(tmp_path: Path, points: str, shape: str) -> None:
    """``save_txt`` of Ultralytics writes no ``data.yaml``. What the message proposes lets the file in."""
    for frame in (10, 11):
        yolo_folder(tmp_path, f"0 0.7 0.4 0.05 0.05 {points}\n", frame=frame)
    (tmp_path / "data.yaml").unlink()
    assert_refused(
        tmp_path, "yolo", "frame_000010.txt, line 1", f"Write their shape into data.yaml, as 'kpt_shape: {shape}'"
    )
    (tmp_path / "data.yaml").write_text(f"kpt_shape: {shape}\n")
    (track,) = tracks_of(read_onto_drive(tmp_path, "yolo")).values()
    assert np.allclose(track.boxes, [[432, 135, 464, 153]] * 2)
    assert np.isnan(track.score).all() == (points in (_QUAD, _MARKED))


@pytest.mark.parametrize("corners", [4, 5, 6, 8, 12])
def test_outlines_are_not_taken_for_keypoints(tmp_path: Path, corners: int) -> None:
    random = np.random.default_rng(corners)
    for frame in range(30):
        angles = random.uniform(0, 2 * np.pi) + np.arange(corners) * 2 * np.pi / corners
        centre, radius = random.uniform(0.1, 0.9, 2), random.uniform(0.01, 0.1)
        points = centre + radius * np.stack([np.cos(angles) * random.uniform(0.3, 1), np.sin(angles)], axis=1)
        yolo_folder(tmp_path, f"0 {' '.join(f'{value:.6f}' for value in points.ravel())}\n", frame=frame)
    back = read_onto_drive(tmp_path, "yolo")
    assert any("Polygons were replaced by the upright boxes around them: 30" in sentence for sentence in back.repaired)


def test_a_polygon_of_an_odd_number_of_values_is_refused(tmp_path: Path) -> None:
    for frame in (10, 11):
        yolo_folder(tmp_path, f"0 {_CORNERS} 0.55 0.65 0.9\n", frame=frame)
    assert_refused(
        tmp_path, "yolo", "a polygon must have pairs of x and y after the class. Got 11 numbers. Correct it."
    )


@pytest.mark.parametrize(
    ("shape", "points"),
    [
        ("[4, 2]", "0.1 0.1 0.9 0.1 0.9 0.9 0.1 0.9"),
        ("[4, 3]", "0 0 0 0.9 0.1 1 0.9 0.9 2 0.1 0.9 1"),
        ("[1, 2]", "0 1"),
    ],
)
def test_keypoints_of_yolo_are_not_corners(tmp_path: Path, shape: str, points: str) -> None:
    """Pose data sets of Ultralytics and CVAT have keypoints after the box (docs.ultralytics.com, datasets/pose)."""
    path = yolo_folder(tmp_path, f"0 0.5 0.5 0.1 0.1 {points}\n")
    (path / "data.yaml").write_text(f"kpt_shape: {shape}\nnames: [stop]\n")
    back = read_onto_drive(path, "yolo")
    (track,) = tracks_of(back).values()
    assert np.allclose(track.boxes, [[288, 162, 352, 198]])
    assert any("Keypoints were left out; their boxes were taken: 1" in sentence for sentence in back.repaired)
    (path / "data.yaml").write_text("names: [stop]\nkpt_shape: 4\n")
    assert_refused(path, "yolo", "data.yaml, line 2", "kpt_shape must be the number of points and 2 or 3")
