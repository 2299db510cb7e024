"""The GTSDB reader, and its errors about damaged folders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tsr_engine.errors import InputError
from tsr_engine.io.gtsdb import read_gtsdb


def make_folder(folder: Path, truth: str | None, names: tuple[str, ...] = ("00000.jpg", "00001.jpg")) -> Path:
    for name in names:
        (folder / name).write_bytes(b"")
    if truth is not None:
        (folder / "gt.txt").write_text(truth)
    return folder


def test_reads_inclusive_pixel_indices_as_edges(tmp_path: Path) -> None:
    scenes = read_gtsdb(make_folder(tmp_path, "00001.jpg;10;20;29;40;11\n\n00001.jpg;1;2;3;4;0\n"))
    assert [s.name for s in scenes] == ["00000.jpg", "00001.jpg"]
    assert scenes[0].boxes.shape == (0, 4)
    assert scenes[0].class_ids.shape == (0,)
    np.testing.assert_array_equal(scenes[1].boxes, [[10, 20, 30, 41], [1, 2, 4, 5]])
    assert scenes[1].boxes.dtype == np.float64
    np.testing.assert_array_equal(scenes[1].class_ids, [11, 0])
    assert scenes[1].path == tmp_path / "00001.jpg"


def test_a_byte_order_mark_before_the_rows_is_not_read(tmp_path: Path) -> None:
    assert read_gtsdb(make_folder(tmp_path, "\ufeff00000.jpg;1;2;3;4;5\n"))[0].class_ids.tolist() == [5]


def test_rows_that_name_ppm_files_fit_converted_pictures(tmp_path: Path) -> None:
    scenes = read_gtsdb(make_folder(tmp_path, "00000.ppm;1;2;3;4;42\n"))
    assert scenes[0].class_ids.tolist() == [42]


@pytest.mark.parametrize(
    ("truth", "words"),
    [
        ("00000.jpg;1;2;3;4;5\n00000.jpg;1;2;3;4\n", ["line 2", "whole numbers"]),
        ("00000.jpg;1;2;x;4;5\n", ["line 1", "whole numbers"]),
        ("00000.jpg;1;2;nan;4;5\n", ["line 1", "whole numbers"]),
        ("00000.jpg;9;2;3;4;5\n", ["line 1", "left <= right"]),
        ("00000.jpg;-1;2;3;4;5\n", ["line 1", "0 <= left"]),
        ("00000.jpg;1;2;3;4;43\n", ["line 1", "0..42", "43"]),
        ("\n00007.jpg;1;2;3;4;5\n", ["line 2", "00007.jpg", "not in"]),
        ("00000.jpg;1;2;3;4;5\n00001.jpg;1;2;3;4;7\n00000.jpg;1;2;3;4;6\n", ["line 3", "line 1", "class 6", "5"]),
    ],
)
def test_bad_rows_are_named_by_line(tmp_path: Path, truth: str, words: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        read_gtsdb(make_folder(tmp_path, truth))
    assert all(word in str(caught.value) for word in words)


def test_a_box_outside_its_picture_is_refused(tmp_path: Path) -> None:
    Image.new("RGB", (40, 30)).save(tmp_path / "upright.png")
    exif = Image.Exif()
    exif[0x0112] = 6  # shown turned by 90 degrees: 30 px wide and 40 px high
    Image.new("RGB", (40, 30)).save(tmp_path / "turned.jpg", exif=exif)
    (tmp_path / "gt.txt").write_text("upright.png;1;2;39;29;5\nturned.jpg;1;2;29;39;5\n")
    assert [scene.boxes.tolist() for scene in read_gtsdb(tmp_path)] == [[[1, 2, 30, 40]], [[1, 2, 40, 30]]]
    for row, size in (("upright.png;1;2;39;30;5", "40x30"), ("turned.jpg;1;2;30;29;5", "30x40")):
        (tmp_path / "gt.txt").write_text(row)
        with pytest.raises(InputError, match=rf"line 1: the box ends outside .*{size} px\. Correct"):
            read_gtsdb(tmp_path)


def test_missing_folder_truth_and_pictures(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="Expected a folder"):
        read_gtsdb(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"Expected gt\.txt"):
        read_gtsdb(make_folder(tmp_path, None))
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(InputError, match="Expected GTSDB scenes"):
        read_gtsdb(make_folder(empty, "", names=()))
    (tmp_path / "gt.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"as text.* Save it as UTF-8 text\."):
        read_gtsdb(tmp_path)


@pytest.mark.data
def test_the_real_training_scenes(gtsdb: Path) -> None:
    scenes = read_gtsdb(gtsdb)
    assert len(scenes) == 600
    assert sum(len(s.boxes) for s in scenes) == 852
    assert sum(len(s.boxes) > 0 for s in scenes) == 506
    assert {int(c) for s in scenes for c in s.class_ids} <= set(range(43))
