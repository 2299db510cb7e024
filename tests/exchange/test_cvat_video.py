"""CVAT for video 1.1: written files, round trips, and refusals with file and line."""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.cvat_files import BOX, SAMPLE, Read, cvat_file, cvat_track, one_track
from tests.exchange.small_datasets import (
    CLASS_NAMES,
    GTSRB,
    make_dataset,
    make_label_set,
    make_track,
    make_video,
    round_trip,
    same_tracks,
    target_of,
    tracks_of,
)
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.added_labels import UnknownLabels
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.exchange.split import make_split
from tsr_engine.exchange.thinning import key_frames


def test_the_sample_of_the_documentation(read_file: Read) -> None:
    found = read_file(SAMPLE)
    track = tracks_of(found)["t-7f3a"]
    assert track.frames.tolist() == list(range(10, 40))
    # CVAT moves the box towards the end mark (``get_interpolated_shapes`` in ``annotation.py``).
    assert np.allclose(track.boxes, np.linspace([10, 10, 20, 22], [18, 11, 40, 35], 31)[:30])
    assert np.flatnonzero(track.key).tolist() == [0]
    assert track.score[0] == 0.93
    assert np.isnan(track.score[1:]).all()
    assert (track.label, track.source) == (14, "imported")
    assert found.repaired == ()
    assert found.skipped == ()


def test_every_shown_frame_is_written_and_gaps_end_with_outside(tmp_path: Path) -> None:
    track = make_track("m1", [10, 11, 12, 20, 21, 98, 99], jitter=0)
    export_dataset(make_dataset(track), FORMATS["cvat-video"], tmp_path / "o", zipped=False)
    root = ET.parse(tmp_path / "o" / "annotations.xml").getroot()
    rows = [(int(b.get("frame", "")), b.get("keyframe"), b.get("outside")) for b in root.iter("box")]
    # The last run ends with the video, so no frame follows that could end it.
    assert [row[:1] + row[2:] for row in rows] == [
        *((frame, "0") for frame in (10, 11, 12)),
        (13, "1"),
        *((frame, "0") for frame in (20, 21)),
        (22, "1"),
        *((frame, "0") for frame in (98, 99)),
    ]
    keys = key_frames(track, 0.5, rounding=0.005)
    assert [key == "1" for _, key, outside in rows if outside == "0"] == keys.tolist()
    assert all(key == "1" for _, key, outside in rows if outside == "1")
    text = root.find("meta/task/labels/label/name")
    assert text is not None
    assert text.text == CLASS_NAMES[0]
    attributes = root.findall("meta/task/labels/label[1]//attribute")
    constant = dict.fromkeys(("uid", "state", "source", "note"), "False")
    assert {each.findtext("name"): each.findtext("mutable") for each in attributes} == {**constant, "score": "True"}
    assert root.findtext("meta/task/stop_frame") == "99"
    assert root.findtext("meta/task/original_size/width") == "640"
    assert root.findtext("meta/task/source") == "drive.mp4"


@pytest.mark.parametrize("rows", ["all", "keys"])
@pytest.mark.parametrize("thin_px", [0.0, 0.5, 3.0])
def test_round_trip(tmp_path: Path, rows: str, thin_px: float) -> None:
    back = round_trip(make_dataset(), "cvat-video", tmp_path, thin_px=thin_px, switches={"rows": rows})
    for track, again in same_tracks(make_dataset(), back, max(thin_px, 0.005)):
        assert (again.occluded == track.occluded).all()
        assert (again.key == key_frames(track, thin_px, rounding=0.005)).all()
        assert np.allclose(again.score[again.key], track.score[again.key], atol=1e-5, equal_nan=True)


def test_classes_by_frame_and_ignored_regions_round_trip(tmp_path: Path) -> None:
    labels = np.full(30, 14)
    labels[5:9] = 1
    ignore = np.zeros(30, dtype=np.bool_)
    ignore[20:] = True
    back = tracks_of(round_trip(make_dataset(make_track(labels=labels, ignore=ignore)), "cvat-video", tmp_path))["m1"]
    assert back.labels is not None
    assert back.labels.tolist() == labels.tolist()
    assert back.ignore is not None
    assert back.ignore.tolist() == ignore.tolist()


def test_names_with_markup_characters(tmp_path: Path) -> None:
    track = make_track('<a href="x">&amp;\'"', label=0, notes=((10, "a]]>b"), (11, "\x00\x1b \\u0041 \ufffe")))
    data = Dataset(make_label_set("<b>&\"'", "ok"), (make_video([track], name='<drive> & "co".mp4'),))
    back = tracks_of(round_trip(data, "cvat-video", tmp_path))[track.uid]
    assert back.label == 0
    assert back.notes == track.notes


def test_several_videos_and_subsets_get_a_folder_each(tmp_path: Path) -> None:
    one = make_video([make_track(f"m{k}", range(20 * k, 20 * k + 10)) for k in range(4)])
    two = make_video([make_track("n1")], name="night drive.mp4", sha="b" * 64)
    data = Dataset(GTSRB, (one, two))
    export_dataset(data, FORMATS["cvat-video"], tmp_path / "two.zip", zipped=True)
    with zipfile.ZipFile(tmp_path / "two.zip") as archive:
        names = sorted(archive.namelist())
    assert names == ["drive/annotations.xml", "manifest.json", "night-drive/annotations.xml"]
    assert sorted(tracks_of(read_dataset(tmp_path / "two.zip", target_of(data)))) == ["m0", "m1", "m2", "m3"]
    split = make_split(data, {"train": 0.6, "val": 0.4}, 1)
    options = ExportOptions(split=split)
    export_dataset(data, FORMATS["cvat-video"], tmp_path / "four.zip", options, zipped=True)
    assert sorted(tracks_of(read_dataset(tmp_path / "four.zip", target_of(data)))) == ["m0", "m1", "m2", "m3"]
    export_dataset(make_dataset(*one.tracks()), FORMATS["cvat-video"], tmp_path / "own", options, zipped=False)
    for side in ("train", "val"):
        root = ET.parse(tmp_path / "own" / side / "annotations.xml").getroot()
        found = {a.text for a in root.iter("attribute") if a.get("name") == "uid" and a.text}
        assert found == {uid for (video, uid), on in split.items() if on == side and video == "a" * 64}
    foreign = make_video(name="elsewhere.mp4", sha="c" * 64)
    with pytest.raises(
        ImportFormatError, match=r"two.zip: is an export of drive.mp4, night drive.mp4, not of elsewhere"
    ):
        read_dataset(tmp_path / "two.zip", target_of(Dataset(GTSRB, (foreign,))))
    export_dataset(data, FORMATS["cvat-video"], tmp_path / "loose", zipped=False)
    (tmp_path / "loose" / "manifest.json").unlink()
    with pytest.raises(ImportFormatError, match="none in a folder called elsewhere"):
        read_dataset(tmp_path / "loose", target_of(Dataset(GTSRB, (foreign,))))


@pytest.mark.parametrize(
    ("rows", "frames", "edges"),
    [
        ([(1, 1, 0, 20), (2, 0, 0, 99), (5, 1, 0, 24), (7, 0, 0, 24)], range(1, 8), [20, 21, 22, 23, 24, 24, 24]),
        ([(1, 1, 0, 20), (2, 0, 0, 22), (3, 0, 0, 24), (4, 1, 1, 26)], range(1, 4), [20, 22, 24]),
        ([(1, 1, 0, 20), (2, 0, 0, 22), (3, 0, 0, 24)], range(1, 4), [20, 22, 24]),
        ([(3, 1, 0, 20), (4, 1, 1, 20)], [3], [20]),
        ([(98, 1, 0, 20), (100, 1, 1, 20)], [98, 99], [20, 20]),
    ],
    ids=[
        "only key frames count and the last row ends the track",
        "a box moves until it is hidden",
        "a box moves until the end of the job",
        "single shape",
        "end after the last frame",
    ],
)
def test_frames_between_rows(
    read_file: Read, rows: list[tuple[int, ...]], frames: Sequence[int], edges: list[int]
) -> None:
    track = tracks_of(read_file(one_track(*(BOX.format(*row) for row in rows))))["cvat-0"]
    assert track.frames.tolist() == list(frames)
    assert track.boxes[:, 2].tolist() == edges


def test_rotated_boxes_become_upright(read_file: Read) -> None:
    box = '<box frame="3" keyframe="1" xtl="100" ytl="100" xbr="140" ybr="120" rotation="{}"/>'
    found = read_file(cvat_file(cvat_track(box.format("90.00")), cvat_track(box.format("0.00"), id=1)))
    assert np.allclose(tracks_of(found)["cvat-0"].boxes, [[110, 90, 130, 130]])
    assert tracks_of(found)["cvat-1"].boxes.tolist() == [[100, 100, 140, 120]]
    assert "Rotated boxes were replaced by the upright boxes around them: 1" in found.repaired[0]
    with pytest.raises(ImportFormatError, match="line 3: rotation must be a finite number"):
        read_file(one_track(box.format("nan")))


def test_tracks_of_one_name_are_kept_apart(read_file: Read) -> None:
    box = '<box frame="{}" keyframe="1" xtl="1" ytl="1" xbr="9" ybr="9"><attribute name="uid">a</attribute></box>'
    found = read_file(cvat_file(cvat_track(box.format(1)), cvat_track(box.format(2)), cvat_track(box.format(3))))
    assert list(tracks_of(found)) == ["a", "a-2", "a-3"]
    assert any("a is now a-2" in text for text in found.repaired)


def test_other_shapes_are_skipped(read_file: Read) -> None:
    found = read_file(
        cvat_file('<track id="0" label="stop"><polygon frame="1"/></track>', cvat_track(BOX.format(3, 1, 0, 20)))
    )
    assert len(tracks_of(found)) == 1
    assert found.skipped[0].what == "annotations.xml, line 2: track"
    assert "polygon" in found.skipped[0].reason


def test_pictures_of_another_size(read_file: Read) -> None:
    half = SAMPLE.replace("<width>640</width><height>360", "<width>320</width><height>180")
    with pytest.raises(ImportFormatError, match="line 4: has a picture size of 320x180 px, drive.mp4 has 640x360"):
        read_file(half)
    found = read_file(half, size="scale")
    assert tracks_of(found)["t-7f3a"].boxes[0].tolist() == [20, 20, 40, 44]
    assert "scaled from 320x180 to 640x360" in found.repaired[0]


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        ('<!DOCTYPE annotations [<!ENTITY a "aaaa">]>\n<annotations>&a;</annotations>', "line 1: a DOCTYPE"),
        ('<!DOCTYPE annotations SYSTEM "http://x/y.dtd"><annotations/>', "line 1: a DOCTYPE"),
        ("<annotations>\n<track>\n&xxe;</track></annotations>", "line 3: is not well-formed XML: undefined entity"),
        ("<annotations>\n<track></annotations>", "line 2: is not well-formed XML: mismatched tag"),
        ("", "no element found"),
        ("<annotations>" + "<track>" * 100, "nested deeper than 32"),
        ("<annotations><image/></annotations>", "line 1: has <image> elements: it is CVAT for images"),
        (cvat_file('<track id="0"/>'), "line 2: <track> must have label"),
        (one_track('<box frame="1"/>'), "line 3: <box> must have xtl"),
        (one_track(BOX.format(1, "yes", 0, 20)), "line 3: keyframe of <box> must be 0 or 1. Got 'yes'"),
        (one_track(BOX.format(1, 1, 2, 20)), "line 3: outside of <box> must be 0 or 1"),
        (one_track(BOX.format(1, 1, 0, 20), BOX.format(100, 1, 0, 20)), "line 4: frame 100 must be in 0 to 99"),
        (one_track(BOX.format(-1, 1, 0, 20)), "line 3: frame -1"),
        (one_track(BOX.format("1.5", 1, 0, 20)), "line 3: frame 1.5"),
        (one_track(BOX.format(10**9, 1, 1, 20)), "line 3: frame 1000000000"),
        (one_track(BOX.format(1, 1, 0, "nan")), "line 3: box .* finite"),
        (one_track(BOX.format(1, 1, 0, "inf")), "line 3: box .* finite"),
        (one_track(BOX.format(1, 1, 0, "5")), "line 3: box .* positive width"),
        (one_track(BOX.format(1, 1, 0, "wide")), "line 3: xbr of <box> must be a number. Got 'wide'"),
        (one_track('<box frame="1" keyframe="1" xtl="1" ytl="1" xbr="9"/>'), "line 3: <box> must have ybr"),
        (one_track(BOX.format(1, 1, 0, 20), BOX.format(1, 1, 0, 21)), "line 4: track 'cvat-0' has a second"),
        (SAMPLE.replace("0.93", "high"), "line 6: the attribute score must be a number"),
        (SAMPLE.replace("0.93", "7"), "line 6: score 7.0 must be in 0 to 1"),
        (SAMPLE.replace("640", "wide"), "line 4: <original_size> must have"),
    ],
)
def test_refusals(read_file: Read, content: str, rule: str) -> None:
    with pytest.raises(ImportFormatError, match=f"^annotations.xml, .*{rule}"):
        read_file(content)


@pytest.mark.parametrize("encoding", ["utf-16", "latin-1"])
def test_encodings_named_by_the_header(tmp_path: Path, encoding: str) -> None:
    content = SAMPLE.replace("utf-8", encoding).replace("t-7f3a", "tö")
    (tmp_path / "a.xml").write_bytes(content.encode(encoding))
    assert "tö" in tracks_of(read_dataset(tmp_path / "a.xml", target_of(make_dataset())))
    (tmp_path / "a.xml").write_bytes(SAMPLE.replace("t-7f3a", "tö").encode("latin-1"))
    with pytest.raises(ImportFormatError, match="a.xml, line 7: is not well-formed XML"):
        read_dataset(tmp_path / "a.xml", target_of(make_dataset()))


def test_unknown_classes_can_be_mapped(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text(one_track(BOX.format(3, 1, 0, 20), BOX.format(8, 1, 1, 20), label="Zebra"))
    with pytest.raises(UnknownLabels, match=r"a.xml: 1 name is no label.*'Zebra' \(1 track, 1 box\)") as reported:
        read_dataset(tmp_path / "a.xml", target_of(make_dataset()))
    assert [(each.name, each.tracks, each.boxes, each.frame) for each in reported.value.labels] == [("Zebra", 1, 1, 3)]
    found = read_dataset(tmp_path / "a.xml", target_of(make_dataset(), label_map={"Zebra": 14}))
    assert tracks_of(found)["cvat-0"].label == 14
    assert found.repaired == ()


def test_a_file_without_tracks(tmp_path: Path) -> None:
    empty = Dataset(GTSRB, (make_video(),))
    assert not tracks_of(round_trip(empty, "cvat-video", tmp_path))


FIFTYONE = '<box frame="{}" xtl="{}" ytl="85" xbr="150" ybr="125" outside="{}" {}>\n</box>'


def test_flags_in_words_of_older_fiftyone(read_file: Read) -> None:
    rows = (FIFTYONE.format(frame, 100, frame == 16, 'keyframe="True"') for frame in (10, 16))
    track = tracks_of(read_file(one_track(*rows)))["cvat-0"]
    assert track.frames.tolist() == list(range(10, 16))


@pytest.mark.parametrize("keys", [(), (10, 15), (10, 12, 15)])
def test_boxes_of_fiftyone_without_key_frames(read_file: Read, keys: tuple[int, ...]) -> None:
    # The edge of frame 12 is not on the line between its neighbours.
    left = {10: 110, 11: 111, 12: 100, 13: 113, 14: 114, 15: 115, 16: 115}
    rows = [
        FIFTYONE.format(frame, x, int(frame == 16), ' keyframe="1" ' if frame in keys else "")
        for frame, x in left.items()
    ]
    track = tracks_of(read_file(one_track(*rows)))["cvat-0"]
    assert track.frames.tolist() == list(range(10, 16))
    assert track.boxes[:, 0].tolist() == [110, 111, 100, 113, 114, 115]
    assert track.frames[track.key].tolist() == list(keys or range(10, 16))


def test_a_folder_of_fiftyone_has_a_file_for_each_video(tmp_path: Path) -> None:
    for name, frame in (("drive", 10), ("other", 20)):
        path = tmp_path / "labels" / f"{name}.xml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(one_track(FIFTYONE.format(frame, 100, 0, "")))
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "drive.mp4").write_bytes(b"")
    assert tracks_of(read_dataset(tmp_path, target_of(make_dataset())))["cvat-0"].frames[0] == 10
    with pytest.raises(ImportFormatError, match=r"several videos \(drive, other\), none in a file called night"):
        read_dataset(tmp_path, target_of(make_dataset(name="night.mp4")))


def test_regions_to_ignore_that_datumaro_writes(read_file: Read) -> None:
    """Datumaro keeps the marks of COCO, MOT and Pascal VOC as attributes when it converts to CVAT."""
    mark = '<box frame="3" keyframe="1" xtl="1" ytl="1" xbr="9" ybr="9">{}<attribute name="{}">True</attribute></box>'
    own = '<attribute name="uid">a</attribute>'
    names = ("is_crowd", "ignored", "difficult", "ignore", "dirty")
    for uid, marked in (("", [True] * 4 + [False]), (own, [False] * 3 + [True, False])):
        found = read_file(cvat_file(*(cvat_track(mark.format(uid, name), id=k) for k, name in enumerate(names))))
        assert [track.ignore is not None for track in tracks_of(found).values()] == marked


def test_boxes_between_rotated_key_frames_have_their_own_angle(read_file: Read) -> None:
    """CVAT interpolates box and angle and writes both in each row (``simple_interpolation`` in ``annotation.py``)."""
    row = '<box frame="{}" keyframe="{}" outside="{}" xtl="100" ytl="100" xbr="140" ybr="120" rotation="{}"/>'
    rows = [(10, 1, 0, "0.00"), (11, 0, 0, "45.00"), (12, 1, 0, "90.00"), (13, 1, 1, "90.00")]
    track = tracks_of(read_file(one_track(*(row.format(*values) for values in rows))))["cvat-0"]
    half = 30 / 2**0.5
    middle = [120 - half, 110 - half, 120 + half, 110 + half]
    assert np.allclose(track.boxes, [[100, 100, 140, 120], middle, [110, 90, 130, 130]])
    assert track.key.tolist() == [True, False, True]
