"""Traps of plain tables (CSV and JSON): each is repaired, or refused with file, line and rule."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.image_datasets import assert_refused, read_onto_drive, write_text
from tests.exchange.small_datasets import make_dataset, make_track, tracks_of
from tsr_engine.evaluation.track_tables import read_clip_truth, read_results
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.registry import FORMATS


def test_tables_have_the_layout_of_the_engine(tmp_path: Path) -> None:
    dataset = make_dataset(make_track("m7", [3, 4], boxes=[(10, 20, 30.125, 50)] * 2, score=np.array([0.5, 0.25])))
    for layout in ("full", "results", "truth"):
        options = ExportOptions(switches={"layout": layout})
        export_dataset(dataset, FORMATS["tracks-csv"], tmp_path / layout, options, zipped=False)
    results = read_results(tmp_path / "results" / "drive.csv")
    assert (results.track.tolist(), results.score.tolist()) == ([7, 7], [0.5, 0.25])
    assert read_results(tmp_path / "full" / "drive.csv").boxes[0].tolist() == [10, 20, 30.125, 50]
    assert read_clip_truth(tmp_path / "truth" / "drive.csv").frame.tolist() == [3, 4]
    for layout, uid in (("full", "m7"), ("results", "7"), ("truth", "7")):
        assert set(tracks_of(read_onto_drive(tmp_path / layout, "tracks-csv"))) == {uid}


@pytest.mark.parametrize(
    ("header", "row", "frame"),
    [
        ("frame,id,bb_left,bb_top,bb_width,bb_height,conf,x,y,z", "1,1,100,50,60,40,0.9,-1,-1,-1", 0),
        ("frame,id,bb_left,bb_top,bb_width,bb_height,conf,x,y,z", "1,1,100,50,60,40,-1,-1,-1,-1", 0),
        ("frame,x,y,left,top,width,height", "1,7,8,100,50,60,40", 1),
        ("frame,left,top,x,y,w,h", "1,7,8,100,50,60,40", 1),
        ("frame,bb_left,bb_top,w,h", "1,100,50,60,40", 1),
        ("width,height,frame,xmin,ymin,xmax,ymax", "640,480,1,100,50,160,90", 1),
    ],
)
def test_box_columns_are_chosen_as_a_set(tmp_path: Path, header: str, row: str, frame: int) -> None:
    frame = 0 if "bb_left" in header else frame
    (track,) = tracks_of(read_onto_drive(write_text(tmp_path, "rows.csv", f"{header}\n{row}\n"), "tracks-csv")).values()
    assert (track.frames.tolist(), track.boxes.tolist()) == ([frame], [[100, 50, 160, 90]])
    assert (track.score is not None and track.score.tolist() == [0.9]) == (",0.9," in row)


@pytest.mark.parametrize(
    ("row", "location"),
    [
        ("1,1,30,20,20,40", ", line 2: "),
        ("1,1,10,20", ", line 2: must have 6 cells"),
        ("1,1,10,20,3\xff,4", ", line 2"),
    ],
)
def test_files_of_one_name_are_told_apart(tmp_path: Path, row: str, location: str) -> None:
    for subset, each in (("train", "1,0,10,20,30,40"), ("val", row)):
        (tmp_path / subset).mkdir()
        content = f"track,frame,x1,y1,x2,y2\n{each}\n"
        (tmp_path / subset / "drive.csv").write_bytes(content.encode("latin-1"))
    assert_refused(tmp_path, "tracks-csv", f"val/drive.csv{location}")


@pytest.mark.parametrize(
    ("content", "location"),
    [
        ('{"tracks": [{"uid": 1, "boxes": [{"frame": 1}]}]}', ", track 1, box 1"),
        ('{"tracks": 5}', ", tracks: must be a list"),
        ('{"tracks": [', ", line 1: is not JSON"),
        ("{", ", line 1: is not JSON"),
    ],
)
def test_json_files_of_one_name_are_told_apart(tmp_path: Path, content: str, location: str) -> None:
    good = '{"tracks": [{"uid": 1, "boxes": [{"frame": 0, "box": [10, 20, 30, 40]}]}]}'
    for subset, each in (("train", good), ("val", content)):
        (tmp_path / subset).mkdir()
        write_text(tmp_path / subset, "drive.json", each)
    assert_refused(tmp_path, "tracks-json", f"val/drive.json{location}")


def test_the_first_frame_can_be_given_for_mot_columns(tmp_path: Path) -> None:
    path = write_text(tmp_path, "rows.csv", "frame,id,bb_left,bb_top,bb_width,bb_height\n1,1,100,50,60,40\n")
    (track,) = tracks_of(read_onto_drive(path, "tracks-csv", first_frame="0")).values()
    assert track.frames.tolist() == [1]


@pytest.mark.parametrize("header", ["frame,x,y,w,h,left,top,width,height", "frame,x,y,bb_left,bb_top,width,height,z,s"])
def test_two_sets_of_box_columns_are_refused(tmp_path: Path, header: str) -> None:
    path = write_text(tmp_path, "rows.csv", f"{header}\n1,1,1,1,1,1,1,1,1\n")
    assert_refused(path, "tracks-csv", "rows.csv, line 1", "more than one set", "Keep one")


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("0,1,10,20,nan,40,14", ("line 2", "x2", "finite")),
        ("0,1,10,20,5,40,14", ("line 2", "positive width")),
        ("100,1,10,20,30,40,14", ("line 2", "0 to 99")),
        ("0.5,1,10,20,30,40,14", ("line 2", "frame 0.5")),
        ("0,1,10,20,30,40", ("line 2", "7 cells", "Got 6")),
        ("0,1,10,20,30,40,1.5", ("line 2", "class_id")),
        ("0,1,10,20,30,40,14\n0,1,11,20,30,40,14", ("line 3", "second, different box")),
        ('0,1,"10,20,30,40,14', ("line 2", "CSV")),
    ],
)
def test_tables_that_break_a_rule(tmp_path: Path, row: str, words: tuple[str, ...]) -> None:
    path = write_text(tmp_path, "rows.csv", f"frame,track_id,x1,y1,x2,y2,class_id\n{row}\n")
    assert_refused(path, "tracks-csv", "rows.csv", *words)


def test_no_class_differs_from_an_empty_cell(tmp_path: Path) -> None:
    path = write_text(tmp_path, "rows.csv", "frame,track_id,x1,y1,x2,y2,class_id\n0,1,1,2,30,40,-1\n0,2,1,2,30,40,\n")
    message, empty = tracks_of(read_onto_drive(path, "tracks-csv")).values()
    assert (message.label, message.silent) == (empty.label, None) == (-1, None)
    assert empty.silent is not None
    entries = [
        {"frame": 3, "id": 5, "class_id": -1, "box": [1, 2, 30, 40]},
        {"frame": 3, "id": 6, "box": [1, 2, 30, 40]},
    ]
    path = write_text(tmp_path, "rows.json", json.dumps(entries))
    message, empty = tracks_of(read_onto_drive(path, "tracks-json")).values()
    assert (message.label, message.silent) == (empty.label, None) == (-1, None)
    assert empty.silent is not None


def test_a_table_without_boxes(tmp_path: Path) -> None:
    assert_refused(write_text(tmp_path, "rows.csv", "frame,speed\n0,1\n"), "tracks-csv", "rows.csv, line 1", "header")
    path = tmp_path / "latin.csv"
    path.write_bytes("frame,x1,y1,x2,y2,label\n0,1,2,30,40,Überholverbot\n".encode("latin-1"))
    assert_refused(path, "tracks-csv", "latin.csv, line 2", "UTF-8")


def test_formulas_in_cells(tmp_path: Path) -> None:
    dataset = make_dataset(make_track("=1+1", [3], boxes=[(10, 20, 30, 50)]))
    options = ExportOptions(switches={"formulas": "quoted"})
    export_dataset(dataset, FORMATS["tracks-csv"], tmp_path / "out", options, zipped=False)
    assert ",'=1+1," in (tmp_path / "out" / "drive.csv").read_text()
    assert set(tracks_of(read_onto_drive(tmp_path / "out", "tracks-csv"))) == {"=1+1"}


@pytest.mark.parametrize(
    "content",
    [
        {"tracks": [{"id": 5, "class": "stop", "boxes": [{"frame": 3, "box": [1, 2, 30, 40]}]}]},
        [{"id": 5, "label": "stop", "boxes": [{"frame": 3, "bbox": [1, 2, 29, 38]}]}],
        [{"frame": 3, "track_id": "5", "class_id": 14, "xyxy": [1, 2, 30, 40], "confidence": 0.5}],
        {"detections": [{"frame": 3, "id": 5, "class": "Stop", "xywh": [1, 2, 29, 38]}], "classes": []},
    ],
)
def test_json_of_another_tool_is_read(tmp_path: Path, content: object) -> None:
    back = read_onto_drive(write_text(tmp_path, "mine.json", json.dumps(content)), "tracks-json")
    track = tracks_of(back)["5"]
    assert (track.frames.tolist(), track.boxes.tolist(), track.label) == ([3], [[1, 2, 30, 40]], 14)


def test_detections_are_linked_or_not(tmp_path: Path) -> None:
    moving = [
        {"frame": k, "box": [10 + 2 * k, 10, 40 + 2 * k, 40], "class": "stop", "score": 0.5} for k in (0, 1, 2, 5, 20)
    ]
    other = [{"frame": k, "box": [300, 10, 330, 40], "class": "yield"} for k in range(3)]
    path = write_text(tmp_path, "mine.json", json.dumps({"detections": [*moving, *other]}))
    linked = tracks_of(read_onto_drive(path, "tracks-json"))
    assert sorted(track.frames.tolist() for track in linked.values()) == [[0, 1, 2], [0, 1, 2, 5], [20]]
    assert len(tracks_of(read_onto_drive(path, "tracks-json", link="none"))) == 8


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"tracks": [{"boxes": []}]}, ("track 1", "must have an id")),
        ({"tracks": [{"id": 1, "boxes": []}, {"id": "1", "boxes": []}]}, ("track 2", "second track")),
        ({"tracks": [{"id": 1, "boxes": [{"frame": 100, "box": [1, 2, 3, 4]}]}]}, ("track 1, box 1", "0 to 99")),
        ({"tracks": [{"id": 1, "boxes": [{"frame": 1, "box": [1, 2, 3]}]}]}, ("track 1, box 1", "[x1, y1, x2, y2]")),
        ({"tracks": [{"id": 1, "boxes": [{"box": [1, 2, 3, 4]}]}]}, ("track 1, box 1", "frame number")),
        ({"detections": [{"frame": 1, "box": [1, 2, 3, 4], "score": 7}]}, ("detection 1", "score")),
        ({"detections": [{"frame": 1, "box": [5, 2, 3, 4]}]}, ("detection 1", "positive width")),
        ({"detections": [{"frame": 1, "box": [1, 2, 3, 4], "key": 3}]}, ("detection 1", "true or false")),
        ({"video": {"width": 1, "height": 1}, "tracks": []}, ("1x1", "640x360")),
        ({"format": "tsr-tracks", "version": 2, "tracks": []}, ("version must be 1",)),
        ({"boxes": []}, ("tracks or detections",)),
    ],
)
def test_json_that_breaks_a_rule(tmp_path: Path, content: object, words: tuple[str, ...]) -> None:
    assert_refused(write_text(tmp_path, "mine.json", json.dumps(content)), "tracks-json", "mine.json", *words)


def test_the_table_of_tsr_track_has_log_odds(tmp_path: Path) -> None:
    head = "frame,track_id,x1,y1,x2,y2,class_id,score,source"
    rows = ["0,1,5,5,15,15,14,-1.0827,detected", "1,1,6,5,16,15,14,900,relocalised", "2,1,7,5,17,15,14,0,predicted"]
    (track,) = tracks_of(
        read_onto_drive(write_text(tmp_path, "rows.csv", "\n".join([head, *rows])), "tracks-csv")
    ).values()
    np.testing.assert_allclose(track.score, [0.25298, 1.0, 0.5], atol=1e-4)
    other = write_text(tmp_path, "others.csv", "\n".join([head, rows[0].replace("detected", "sort")]))
    assert_refused(other, "tracks-csv", "others.csv, line 2", "score -1.0827 must be in 0 to 1")
