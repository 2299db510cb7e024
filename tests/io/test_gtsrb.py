from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsr_engine.errors import InputError
from tsr_engine.io.gtsrb import (
    CropItem,
    folds_by_track,
    read_items,
    read_picture,
    read_table,
    split_by_track,
    tracks_of,
)

HEADER = "Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2;ClassId"


def picture(path: Path, width: int = 30, height: int = 32) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), np.full((height, width, 3), 90, np.uint8))


def table(path: Path, *lines: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for class_id in (3, 14):
        rows = [f"{t:05d}_{f:05d}.png;30;32;5;6;25;26;{class_id}" for t in (0, 1) for f in (0, 1, 2)]
        table(tmp_path / f"{class_id:05d}" / f"GT-{class_id:05d}.csv", HEADER, *rows)
        for row in rows:
            picture(tmp_path / f"{class_id:05d}" / row.split(";")[0])
    return tmp_path


def test_class_folders(folder: Path) -> None:
    items = read_items(folder)
    assert len(items) == 12
    assert items[4] == CropItem(folder / "00003" / "00001_00001.png", (5, 6, 25, 26), 3, (3, 1), 1)
    assert items[4].filename == "00001_00001.png"
    assert read_picture(items[4]).shape == (32, 30, 3)
    assert read_items(folder / "00014") == items[6:]


def test_the_test_table_with_and_without_classes(tmp_path: Path) -> None:
    with_class = table(tmp_path / "GT-final_test.csv", HEADER, "00000.ppm;53;54;6;5;48;49;16")
    (item,) = read_items(with_class)
    assert (item.class_id, item.roi, item.track) == (16, (6, 5, 48, 49), None)
    without = table(tmp_path / "other" / "test.csv", HEADER.removesuffix(";ClassId"), "00000.ppm;53;54;6;5;48;49")
    (item,) = read_table(without)
    assert (item.class_id, item.path) == (None, tmp_path / "other" / "00000.ppm")


@pytest.mark.parametrize(
    "lines",
    [
        ["Filename;Width;Height;RoiX1;RoiY1;RoiX2;RoiY2;ClassId", "00003_00007.ppm;53;54;6;5;48;49;16"],
        ["Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2;ClassId;", "00003_00007.ppm;53;54;6;5;48;49;16;"],
        [HEADER, "00003_00007.ppm;53;54;6;5;48;49;16;"],
        [HEADER, "", "00003_00007.ppm;53;54;6;5;48;49;16", ""],
        ["filename,width,height,roi_x1,roi_y1,roi_x2,roi_y2,class_id", "00003_00007.ppm,53,54,6,5,48,49,16"],
        ["ClassId\tFilename\tRoi X1\tRoi Y1\tRoi X2\tRoi Y2", "16\t00003_00007.ppm\t6\t5\t48\t49"],
    ],
)
def test_common_variants_of_tables(tmp_path: Path, lines: list[str]) -> None:
    (item,) = read_table(table(tmp_path / "t.csv", *lines))
    assert item == CropItem(tmp_path / "00003_00007.ppm", (6, 5, 48, 49), 16, (16, 3), 7)


def test_tables_of_kaggle_have_paths(tmp_path: Path) -> None:
    header = "Width,Height,Roi.X1,Roi.Y1,Roi.X2,Roi.Y2,ClassId,Path"
    (item,) = read_table(table(tmp_path / "Train.csv", header, "27,26,5,5,22,20,20,Train/20/00020_00003_00007.png"))
    assert item == CropItem(tmp_path / "Train/20/00020_00003_00007.png", (5, 5, 22, 20), 20, (20, 3), 7)
    (item,) = read_table(table(tmp_path / "Test.csv", header, "53,54,6,5,48,49,16,Test/00000.png"))
    assert (item.path, item.class_id, item.track) == (tmp_path / "Test/00000.png", 16, None)
    for path in ("/etc/passwd", "../a.png", "Test/../../a.png", "C:/a.png"):
        with pytest.raises(InputError, match="line 2: expected a path below the table's folder"):
            read_table(table(tmp_path / "Test.csv", header, f"53,54,6,5,48,49,16,{path}"))


def test_loose_pictures_have_no_roi(tmp_path: Path) -> None:
    for name in ("b.jpg", "a.png", "c.webp", "notes.txt"):
        if name.endswith("txt"):
            (tmp_path / name).write_text("x")
        else:
            picture(tmp_path / name)
    assert read_items(tmp_path) == [CropItem(tmp_path / name) for name in ("a.png", "b.jpg", "c.webp")]


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (["Filename,Width"], r"line 1: expected the columns"),
        ([""], r"line 1: expected the columns"),
        ([HEADER], "lists no pictures"),
        ([HEADER, "00000_00000.ppm;29;30;5;6;24;25;1", "00000_00001.ppm;29;30;5;x;24;25;1"], "line 3.*Roi.Y1.*'x'"),
        ([HEADER, "00000_00000.ppm;29;30;24;6;5;25;1"], "line 2.*X1 < X2"),
        ([HEADER, "00000_00000.ppm;29;30;5;6;24;25;43"], r"line 2.*0\.\.42.*43"),
        ([HEADER, "../escape.ppm;29;30;5;6;24;25;1"], "line 2.*file name without folders"),
        ([HEADER, "00000_00000.ppm;29;30"], "line 2.*whole number in Roi.X1"),
        ([HEADER, "00000_00000.ppm;29;30;5;6;24;25;1;7"], "line 2: expected 8 cells, found 9"),
    ],
)
def test_a_damaged_table_is_named_with_its_line(tmp_path: Path, lines: list[str], message: str) -> None:
    with pytest.raises(InputError, match=message) as error:
        read_table(table(tmp_path / "GT-00001.csv", *lines))
    assert "GT-00001.csv" in str(error.value)


def test_missing_and_damaged_pictures(folder: Path) -> None:
    items = read_items(folder)
    items[0].path.unlink()
    items[1].path.write_bytes(b"not a picture")
    items[2].path.write_bytes(b"")
    picture(items[3].path, 20, 20)
    for item, message in zip(items, ("Cannot read", "not a readable", "not a readable", "its ROI ends"), strict=False):
        with pytest.raises(InputError, match=message):
            read_picture(item)


@pytest.mark.parametrize("name", ["nothing", "empty"])
def test_a_source_without_pictures_is_refused_by_name(tmp_path: Path, name: str) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="Expected"):
        read_items(tmp_path / name)


def make_video(tracks: dict[int, int]) -> list[CropItem]:
    return [
        CropItem(Path(f"{t:05d}_{f:05d}.ppm"), (0, 0, 9, 9), c, (c, t), f)
        for c, count in tracks.items()
        for t in range(count)
        for f in range(3)
    ]


@settings(deadline=None, max_examples=40)
@given(
    st.dictionaries(st.integers(0, 42), st.integers(1, 12), min_size=1, max_size=6),
    st.floats(0.05, 0.95),
    st.integers(0, 99),
)
def test_tracks_are_on_one_side_and_small_classes_on_both(tracks: Any, share: float, seed: int) -> None:
    items = make_video(tracks)
    training, held = split_by_track(items, share, seed)
    assert sorted([*training, *held], key=items.index) == items
    assert not {i.track for i in training} & {i.track for i in held}
    for class_id, count in tracks.items():
        on_the_other_side = len({i.track for i in held if i.class_id == class_id})
        if count > 1:
            assert 1 <= on_the_other_side <= count - 1
            assert abs(on_the_other_side - share * count) <= 1
        else:
            assert on_the_other_side == 0
    assert split_by_track(items, share, seed) == (training, held)


@settings(deadline=None, max_examples=40)
@given(
    st.dictionaries(st.integers(0, 42), st.integers(4, 12), min_size=1, max_size=6),
    st.integers(2, 4),
    st.integers(0, 9),
)
def test_each_track_is_in_one_of_the_parts_and_each_class_in_all(tracks: Any, count: int, seed: int) -> None:
    items = make_video(tracks)
    parts = folds_by_track(items, count, seed)
    assert sorted((i for part in parts for i in part), key=items.index) == items
    assert parts[0] == split_by_track(items, 1 / count, seed)[1]
    for class_id, tracks_of_class in tracks.items():
        held = [{i.track for i in part if i.class_id == class_id} for part in parts]
        assert sum(map(len, held)) == tracks_of_class
        assert all(abs(len(part) - tracks_of_class / count) < 2 and part for part in held)


def test_a_split_into_one_part_is_refused() -> None:
    with pytest.raises(ValueError, match="at least 2"):
        folds_by_track(make_video({1: 4}), 1, 0)


def test_tracks_run_from_far_to_near() -> None:
    tracks = tracks_of(reversed(make_video({2: 2})))
    assert [[i.frame for i in frames] for frames in tracks.values()] == [[0, 1, 2], [0, 1, 2]]
    with pytest.raises(InputError, match="TTTTT_FFFFF"):
        tracks_of([CropItem(Path("loose.png"))])


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_share_that_empties_one_side_is_refused(share: float) -> None:
    with pytest.raises(ValueError, match="share"):
        split_by_track(make_video({1: 2}), share, 0)


@pytest.mark.data
def test_the_real_training_set(gtsrb: Path) -> None:
    items = read_items(gtsrb)
    assert len(items) == 39209
    assert len({i.track for i in items}) == 1307
    training, held = split_by_track(items, 0.25, 0)
    assert {i.class_id for i in training} == {i.class_id for i in held} == set(range(43))
