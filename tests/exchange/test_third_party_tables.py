"""Tables and JSON of supervision, Ultralytics and others: columns, classes, frames, and the video they belong to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.exchange.small_datasets import make_dataset, target_of, tracks_of
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.added_labels import UnknownLabels
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.exchange.table_columns import edges_of, find_columns

BOXES = [(110.0 + k, 85 + k / 2, 150.0 + k, 125 + k / 2) for k in range(6)]
FIT_BOTH = "frames were counted from 0, but the numbers 10 to 15 fit 0 and 1"


def _read(folder: Path, name: str, content: str | Any, **more: Any) -> Dataset:
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    switches = more.pop("switches", {})
    return read_dataset(path, target_of(make_dataset(), switches=switches, **more))


def _csv(header: str, row: str, *, quote: str = "") -> str:
    """A table of boxes in frames 10 to 15; ``row`` is a template with {f}, {x1}..."""
    rows = (row.format(f=10 + k, x1=a, y1=b, x2=c, y2=d) for k, (a, b, c, d) in enumerate(BOXES))
    return "".join(f"{line}\n" for line in (header, *rows))


def _is_the_track(found: Dataset, uid: str = "7") -> None:
    (track,) = tracks_of(found).values()
    assert (track.uid, track.label) == (uid, 14)
    assert track.frames.tolist() == list(range(10, 16))
    assert track.boxes.tolist() == [list(box) for box in BOXES]


def _reported(found: Dataset, *words: str) -> bool:
    return any(all(word in sentence for word in words) for sentence in found.repaired)


DICT = "\"{{'x1': {x1}, 'y1': {y1}, 'x2': {x2}, 'y2': {y2}}}\""


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("x_min,y_min,x_max,y_max,class_id,confidence,tracker_id,class_name,frame_number",
         "{x1},{y1},{x2},{y2},0,0.9,7,stop,{f}"),
        ("x_min,y_min,x_max,y_max,class_id,confidence,tracker_id,class_name,frame_index",
         "{x1},{y1},{x2},{y2},0,0.9,7,stop,{f}"),
        ("frame,name,class,confidence,track_id,x1,y1,x2,y2", "{f},stop,0,0.9,7,{x1},{y1},{x2},{y2}"),
        (",name,class,confidence,box,track_id,frame", f"0,stop,0,0.9,{DICT},7.0,{{f}}"),
        ("frame,name,class,confidence,track_id,box.x1,box.y1,box.x2,box.y2",
         "{f},stop,0,0.9,7,{x1},{y1},{x2},{y2}"),
        ("frame,track_id,xyxy,class_name", '{f},7,"[{x1}, {y1}, {x2}, {y2}]",stop'),
        ("frame;id;bbox;label", "{f};7;({x1}, {y1}, 40, 40);stop"),
        ("Frame;ID;Left;Top;Width;Height;Label;Confidence", "{f};7;{x1};{y1};40;40;stop;0.5"),
        ("Frame Number,Track-ID,X Min,Y Min,X Max,Y Max,Class Name,Class ID",
         "{f},7,{x1},{y1},{x2},{y2},stop,3"),
        ("FRAME\tTRACK_ID\tXMIN\tYMIN\tXMAX\tYMAX\tCATEGORY", "{f}\t7\t{x1}\t{y1}\t{x2}\t{y2}\tstop"),
        ("frame_idx,track_id,bbox_x,bbox_y,bbox_w,bbox_h,class_id,class", "{f},7,{x1},{y1},40,40,3,stop"),
    ],
)  # fmt: skip
def test_tables_of_other_tools(tmp_path: Path, header: str, row: str) -> None:
    found = _read(tmp_path, "rows.csv", _csv(header, row))
    _is_the_track(found)
    assert len(found.repaired) == 1
    assert FIT_BOTH in found.repaired[0]


def test_centres_are_not_read_as_corners(tmp_path: Path) -> None:
    text = "frame,track_id,x_center,y_center,width,height,class\n10,7,130,105,40,40,stop\n"
    (track,) = tracks_of(_read(tmp_path, "rows.csv", text)).values()
    assert track.boxes.tolist() == [[110, 85, 150, 125]]


ULTRALYTICS = [
    {"name": "stop", "class": 0, "confidence": 0.9, "box": {"x1": a, "y1": b, "x2": c, "y2": d}, "track_id": 7}
    for a, b, c, d in BOXES
]
SUPERVISION = [
    {"x_min": a, "y_min": b, "x_max": c, "y_max": d, "class_id": 0, "confidence": 0.9, "tracker_id": 7,
     "class_name": "stop", "frame_index": str(10 + k)}
    for k, (a, b, c, d) in enumerate(BOXES)
]  # fmt: skip


@pytest.mark.parametrize(
    "content",
    [
        SUPERVISION,
        [{"frame": 10 + k, **box} for k, box in enumerate(ULTRALYTICS)],
        [{"Frame": 10 + k, "Box": list(edges), "Track ID": 7.0, "Label": "stop"} for k, edges in enumerate(BOXES)],
        {str(10 + k): [box] for k, box in enumerate(ULTRALYTICS)},
        {f"frame_{10 + k:06d}": [box] for k, box in enumerate(ULTRALYTICS)},
        [{"frame": 10 + k, "detections": [box]} for k, box in enumerate(ULTRALYTICS)],
        {"frames": [{"frame_id": 10 + k, "objects": [box]} for k, box in enumerate(ULTRALYTICS)]},
    ],
)
def test_json_of_other_tools(tmp_path: Path, content: Any) -> None:
    found = _read(tmp_path, "rows.json", content)
    _is_the_track(found)
    assert len(found.repaired) == 1
    assert FIT_BOTH in found.repaired[0]


@pytest.mark.parametrize("as_text", [False, True])
@pytest.mark.parametrize("switches", [{}, {"first_frame": "1"}])
def test_one_list_per_frame_is_read_in_order(tmp_path: Path, as_text: bool, switches: dict[str, str]) -> None:
    lists = [[] for _ in range(10)] + [[box] for box in ULTRALYTICS]
    found = _read(tmp_path, "rows.json", [json.dumps(each) for each in lists] if as_text else lists, switches=switches)
    _is_the_track(found)
    assert [sentence.split(": ")[1][:5] for sentence in found.repaired] == ["lists"]


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", "filename,width,height,class,xmin,ymin,xmax,ymax\na_jpg.rf.1f.jpg,640,360,stop,1,1,9,9\n",
         "line 1: names pictures \\(filename\\), not frames"),
        ("a.csv", _csv(",name,class,confidence,box", f"0,stop,0,0.9,{DICT}"), "line 1: the header must have frame"),
        ("a.csv", "frame,id,x1,y1,x2,y2\n3,1,0.1,0.1,0.2,0.2\n", "line 2: the box lies within one pixel.*relative"),
        ("a.csv", "frame,id,box\n3,1,near\n", "line 2: box must be four numbers"),
        ("a.csv", "frame,id,box\n3,1,\"{'x1': 'a', 'y1': 1, 'x2': 5, 'y2': 5}\"\n", "line 2: box must be four numbers"),
        ("a.json", json.dumps(ULTRALYTICS), "entry 1: must have a frame number"),
        ("a.json", json.dumps([{"frame": 1, "confidence": 1, "box": {"x1": 0.1, "y1": 0.1, "x2": 0.2, "y2": 0.2}}]),
         "entry 1: the box lies within one pixel"),
        ("a.json", json.dumps([{"frame": 1, "confidence": 1, "box": {"x1": "a"}}]), "entry 1: must have box"),
        ("a.json", json.dumps([{"frame": "x", "confidence": 1, "box": [1, 1, 9, 9]}]), "entry 1: frame 'x'"),
    ],
)  # fmt: skip
def test_required_columns_of_a_table(tmp_path: Path, name: str, text: str, words: str) -> None:
    with pytest.raises(ImportFormatError, match=words):
        _read(tmp_path, name, text)


@pytest.mark.parametrize("name", ["rows.csv", "rows.json"])
@pytest.mark.parametrize(
    ("numbers", "switch", "first", "reported"),
    [
        (range(1, 101), {}, 0, "counted from 1, since the numbers are 1 to 100"),
        (range(100), {}, 0, ""),
        (range(1, 100), {}, 1, "fit 0 and 1"),
        (range(1, 100), {"first_frame": "1"}, 0, ""),
        (range(1, 100), {"first_frame": "0"}, 1, ""),
        ((98, 100), {"first_frame": "1"}, 97, ""),
    ],
)
def test_the_first_frame_of_a_table(
    tmp_path: Path, name: str, numbers: range, switch: dict[str, str], first: int, reported: str
) -> None:
    rows = [{"frame": k, "track_id": 7, "x1": 10, "y1": 10, "x2": 50, "y2": 50, "class": "stop"} for k in numbers]
    table = "\n".join([",".join(rows[0]), *(",".join(str(cell) for cell in row.values()) for row in rows)])
    found = _read(tmp_path, name, table + "\n" if name.endswith("csv") else rows, switches=switch)
    (track,) = tracks_of(found).values()
    assert track.frames[0] == first
    assert (len(found.repaired), _reported(found, reported)) == ((1, True) if reported else (0, False))


@pytest.mark.parametrize("name", ["rows.csv", "rows.json"])
def test_the_error_about_a_frame_beyond_the_video_names_the_option(tmp_path: Path, name: str) -> None:
    rows = [{"frame": k, "x1": 10, "y1": 10, "x2": 50, "y2": 50} for k in (98, 100)]
    table = "frame,x1,y1,x2,y2\n98,10,10,50,50\n100,10,10,50,50\n"
    with pytest.raises(ImportFormatError, match="frame 100 must be in 0 to 99.*first_frame=1"):
        _read(tmp_path, name, table if name.endswith("csv") else rows)


@pytest.mark.parametrize(
    ("row", "label", "reported"),
    [
        ({"name": "stop", "class": "0"}, 14, False),
        ({"class": "0", "class_name": "stop", "name": "drive.mp4"}, 14, False),
        ({"label": "3", "class_id": "stop"}, 14, False),
        ({"class_id": "3", "label": ""}, 3, True),
        ({"cls": "3"}, 3, True),
        ({"class_id": "-1"}, -1, False),
        ({"class_id": "nan"}, -1, False),
    ],
)
def test_names_win_over_numbers_and_numbers_are_reported(
    tmp_path: Path, row: dict[str, str], label: int, reported: bool
) -> None:
    table = f"frame,track_id,x1,y1,x2,y2,{','.join(row)}\n0,7,10,10,50,50,{','.join(row.values())}\n"
    found = _read(tmp_path, "rows.csv", table)
    assert tracks_of(found)["7"].label == label
    assert _reported(found, "without a class name were taken as the tool's: 1", "line 2") == reported
    typed = {key: int(value) if value.lstrip("-").isdigit() else value for key, value in row.items()}
    entry = {"frame": 0, "track_id": 7, "box": [10, 10, 50, 50], **typed}
    found = _read(tmp_path, "rows.json", [entry])
    assert tracks_of(found)["7"].label == label
    assert _reported(found, "without a class name were taken as the tool's: 1", "entry 1") == reported


@pytest.mark.parametrize("column", ["class", "label", "name", "category"])
def test_numbers_in_a_column_of_names_are_not_matched(tmp_path: Path, column: str) -> None:
    table = f"frame,track_id,x1,y1,x2,y2,{column}\n0,7,10,10,50,50,3\n"
    with pytest.raises(UnknownLabels, match=r"'3' \(1 track, 1 box.*It stands in rows.csv, line 2"):
        _read(tmp_path, "rows.csv", table)
    with pytest.raises(UnknownLabels, match=r"'3\.5' "):
        _read(tmp_path, "rows.csv", table.replace(",3\n", ",3.5\n"))
    entry = {"frame": 0, "track_id": 7, "box": [10, 10, 50, 50]}
    with pytest.raises(UnknownLabels, match=r"'3' \(1 track, 1 box.*It stands in rows.json, entry 1"):
        _read(tmp_path, "rows.json", [{**entry, column: "3"}])
    assert tracks_of(_read(tmp_path, "rows.json", [{**entry, column: 3}]))["7"].label == 3, "a number is told as one"


def test_mapped_numbers_are_not_reported(tmp_path: Path) -> None:
    table = "frame,track_id,x1,y1,x2,y2,class\n0,7,10,10,50,50,0\n"
    found = _read(tmp_path, "rows.csv", table, label_map={"0": 14})
    assert (tracks_of(found)["7"].label, found.repaired) == (14, ())


@pytest.mark.parametrize("name", ["rows.csv", "rows.json"])
def test_rows_of_other_videos_are_left_out(tmp_path: Path, name: str) -> None:
    def given(*videos: str) -> Any:
        if name.endswith("json"):
            return [{"video": each, "frame": 0, "box": [10 + k, 1, 90, 90]} for k, each in enumerate(videos)]
        rows = (f"{each},0,{10 + k},1,90,90\n" for k, each in enumerate(videos))
        return "video,frame,x1,y1,x2,y2\n" + "".join(rows)

    found = _read(tmp_path, name, given("other.mp4", "clips/drive.mp4"))
    (track,) = tracks_of(found).values()
    assert track.boxes[0, 0] == 11
    assert "other.mp4" in found.skipped[0].reason
    assert _reported(_read(tmp_path, name, given("other.mp4")), "names other.mp4", "drive.mp4")
    with pytest.raises(ImportFormatError, match=r"2 videos, none about drive\.mp4: .*task=NAME"):
        _read(tmp_path, name, given("other.mp4", "rear-drive.mp4"))
    chosen = _read(tmp_path, name, given("other.mp4", "rear-drive.mp4"), switches={"task": "rear-drive"})
    assert tracks_of(chosen)["box1"].boxes[0, 0] == 11


def test_our_json_of_another_video_is_reported(tmp_path: Path) -> None:
    about = {"name": "other.mp4", "width": 640, "height": 360}
    content = {"video": about, "tracks": [{"id": 7, "boxes": [{"frame": 3, "box": [1, 1, 30, 30]}]}]}
    assert _reported(_read(tmp_path, "rows.json", content), "names other.mp4")
    about |= {"name": "drive.mp4", "sha256": "b" * 64}
    assert _reported(_read(tmp_path, "rows.json", content), "another file called drive.mp4, by its hash")
    about |= {"sha256": "a" * 64}
    assert _read(tmp_path, "rows.json", content).repaired == ()


def test_pictures_of_another_size_are_reported(tmp_path: Path) -> None:
    rows = "frame,x1,y1,x2,y2,width,height\n0,10,10,50,50,{},360\n"
    assert _reported(_read(tmp_path, "rows.csv", rows.format(1280)), "pictures of 1280x360 px, drive.mp4 has 640x360")
    assert not _reported(_read(tmp_path, "rows.csv", rows.format(640)), "pictures of")


@pytest.mark.parametrize("header", ["frame,track_id,x1,y1,x", "frame,speed", ""])
def test_a_header_without_rows_is_checked(tmp_path: Path, header: str) -> None:
    path = tmp_path / "rows.csv"
    path.write_text(header)
    with pytest.raises(ImportFormatError, match="rows.csv.*header"):
        read_dataset(path, target_of(make_dataset()), FORMATS["tracks-csv"])


def test_a_last_row_that_may_be_truncated_is_reported(tmp_path: Path) -> None:
    rows = "frame,x1,y1,x2,y2\n0,10,10,50,50"
    assert _reported(_read(tmp_path, "rows.csv", rows), "without a line end after the last line", "rows.csv")
    assert not _reported(_read(tmp_path, "rows.csv", rows + "\n"), "without a line end after the last line")


def test_a_json_with_another_number_of_frames_is_reported(tmp_path: Path) -> None:
    content = {"video": {"frames": 200}, "tracks": [{"id": 7, "boxes": [{"frame": 3, "box": [1, 1, 30, 30]}]}]}
    assert _reported(_read(tmp_path, "rows.json", content), "a video of 200 frames, drive.mp4 has 100")


@pytest.mark.parametrize("column", ["filename", "source", "path"])
def test_any_column_may_name_the_video(tmp_path: Path, column: str) -> None:
    table = f"{column},frame,x1,y1,x2,y2\n{{}},0,10,10,50,50\n"
    assert _reported(_read(tmp_path, "rows.csv", table.format("a/other.mp4")), "names other.mp4")
    assert not _reported(_read(tmp_path, "rows.csv", table.format("a/drive.mp4")), "It was imported onto")
    assert not _reported(_read(tmp_path, "rows.csv", table.format("camera")), "It was imported onto")


def test_ids_above_the_whole_numbers_of_a_float(tmp_path: Path) -> None:
    rows = "".join(f"{frame},{2**53 + k},stop,{10 + 100 * k},10,50,50\n" for k in range(2) for frame in range(3))
    found = tracks_of(_read(tmp_path, "rows.csv", "frame,track_id,label,x,y,w,h\n" + rows))
    assert {uid: track.frames.tolist() for uid, track in found.items()} == {
        "9007199254740992": [0, 1, 2],
        "9007199254740993": [0, 1, 2],
    }


def test_a_source_that_names_a_video_is_not_in_our_tables(tmp_path: Path) -> None:
    rows = "".join(f"3,{uid},14,10,10,50,50,0.9,{source}\n" for uid, source in ((1, "drive.mp4"), (2, "rear.mp4")))
    found = _read(tmp_path, "rows.csv", "frame,track_id,class_id,x1,y1,x2,y2,score,source\n" + rows)
    assert list(tracks_of(found)) == ["1"]
    assert "rear.mp4" in found.skipped[0].reason
    assert _reported(found, "class numbers", "taken as the tool's")


def test_the_head_of_a_json_gives_video_and_size(tmp_path: Path) -> None:
    box = {"frame": 3, "box": [1, 1, 30, 30]}
    content: dict[str, Any] = {"video": "other.mp4", "detections": [box]}
    assert _reported(_read(tmp_path, "rows.json", content), "names other.mp4")
    with pytest.raises(ImportFormatError, match="1280x720"):
        _read(tmp_path, "rows.json", {"width": 1280, "height": 720, "detections": [box]})
    scaled = _read(
        tmp_path, "rows.json", {"width": 1280, "height": 720, "detections": [box]}, switches={"size": "scale"}
    )
    assert tracks_of(scaled)["box1"].boxes.tolist() == [[0.5, 0.5, 15, 15]]


def test_two_columns_of_frames_must_agree(tmp_path: Path) -> None:
    table = "frame_index,frame_number,x1,y1,x2,y2\n10,{},10,10,50,50\n"
    with pytest.raises(ImportFormatError, match="line 2: frame_number says 11 and frame_index 10"):
        _read(tmp_path, "rows.csv", table.format(11))
    assert tracks_of(_read(tmp_path, "rows.csv", table.format("10.0")))["box1"].frames.tolist() == [10]
    with pytest.raises(ImportFormatError, match="entry 1: says frame 11 and frame_index 10"):
        _read(tmp_path, "rows.json", [{"frame_index": 10, "frame_number": 11, "box": [1, 1, 9, 9]}])


def test_boxes_of_any_kind() -> None:
    corners = {"x1": 10, "y1": 20, "x2": 30, "y2": 10, "x3": 40, "y3": 30, "x4": 20, "y4": 40}
    assert edges_of(corners, sized=False) == (10, 10, 40, 40)
    assert edges_of("{10.0,20.0,30.0,40.0}", sized=False) == (10, 20, 30, 40)
    assert edges_of("10 20 30 40", sized=True) == (10, 20, 40, 60)
    assert edges_of({"x_min": "10", "y_min": "2.5", "x_max": "3e1", "y_max": "9"}, sized=False) == (10, 2.5, 30, 9)
    assert edges_of({"cx": 20, "cy": 30, "w": 4, "h": 6}, sized=False) == (18, 27, 22, 33)
    for wrong in ("", "a", [1, 2, 3], {"x1": 1}, {"x1": True, "y1": 1, "x2": 2, "y2": 2}, 7, None, "[" * 5000):
        assert edges_of(wrong, sized=False) is None
    with pytest.raises(ValueError, match=r"x,y,w,h or left,top,width,height"):
        find_columns(["x", "y", "w", "h", "left", "top", "width", "height"])
