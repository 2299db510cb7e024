"""Refusals, repairs and omissions of the validator, with file, line and rule."""

from __future__ import annotations

import math
import tracemalloc
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.small_datasets import GTSRB, make_dataset, make_track, make_video, target_of
from tsr_engine.errors import ExportError, ImportFormatError
from tsr_engine.exchange.added_labels import UnknownLabels
from tsr_engine.exchange.check_track import check_track
from tsr_engine.exchange.dataset import UNSTATED_LABEL
from tsr_engine.exchange.formats import ImportLimits
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.reading import read_json, read_text


@pytest.fixture
def validator() -> ImportValidator:
    return ImportValidator(target_of(make_dataset()))


@pytest.mark.parametrize(
    ("edges", "rule"),
    [
        ((math.nan, 1, 2, 3), "finite"),
        ((1, 1, math.inf, 3), "finite"),
        ((5, 5, 5, 9), "positive width"),
        ((5, 5, 9, 4), "positive width"),
    ],
)
def test_invalid_boxes(validator: ImportValidator, edges: tuple[float, float, float, float], rule: str) -> None:
    with pytest.raises(ImportFormatError, match=f"f.xml, line 7: box .*{rule}"):
        validator.box("a", 1, edges, 0, file="f.xml", line=7)


def test_a_rate_that_is_only_rounded_is_not_reported() -> None:
    for stated, own, reports in (
        (12, "25/2", 0),
        (13, "25/2", 0),
        (30, "30000/1001", 0),
        (12.2, "25/2", 1),
        (14, "25/2", 1),
    ):
        validator = ImportValidator(target_of(make_dataset(rate=Fraction(own))))
        validator.check_rate(stated, "f.ini")
        assert len(validator.finish("f.ini").repaired) == reports, stated


@pytest.mark.parametrize("frame", [-1, 100, 10**12])
def test_frames_outside_of_the_video(validator: ImportValidator, frame: int) -> None:
    with pytest.raises(ImportFormatError, match=r"f.csv, line 3: frame .* must be in 0 to 99.*counts from 0 or 1"):
        validator.box("a", frame, (0, 0, 9, 9), 0, file="f.csv", line=3)


@pytest.mark.parametrize("frame", ["x", "1.5", math.nan, math.inf, "", None])
def test_frames_that_are_not_numbers(validator: ImportValidator, frame: object) -> None:
    with pytest.raises(ImportFormatError, match="f.csv, line 3: frame"):
        validator.frame(frame, "f.csv", 3)  # type: ignore[arg-type]


def test_frames_that_count_from_one(validator: ImportValidator) -> None:
    assert validator.frame("100", "f", origin=1) == 99
    with pytest.raises(ImportFormatError, match="frame 0 must be in 1 to 100"):
        validator.frame(0, "f", origin=1)


@pytest.mark.parametrize("score", [-0.1, 1.1, math.inf])
def test_scores_outside_of_their_range(validator: ImportValidator, score: float) -> None:
    with pytest.raises(ImportFormatError, match="line 1: score"):
        validator.box("a", 1, (0, 0, 9, 9), 0, file="f", line=1, score=score)


def test_boxes_over_the_edge_are_clipped(validator: ImportValidator) -> None:
    assert validator.box("a", 1, (-5, 10, 700, 400), 0, file="f.xml", line=4)
    assert not validator.box("a", 2, (-5, 10, -1, 20), 0, file="f.xml", line=5)
    # Half of the second decimal is not a repair.
    assert validator.box("a", 3, (-0.005, 0, 640.005, 360), 0, file="f.xml", line=6)
    found = validator.finish("f.xml")
    track = next(found.videos[0].tracks())
    assert track.boxes.tolist() == [[0, 10, 640, 360], [0, 0, 640, 360]]
    assert found.repaired == (
        "Boxes that reached over the edge of the picture were cut there: 1; the first is f.xml, line 4.",
    )
    assert "outside the picture; the first: f.xml, line 5, track a" in found.skipped[0].reason


def test_boxes_outside_are_counted_without_keeping_them(validator: ImportValidator) -> None:
    """A file of another video may have only such boxes, without limit."""
    validator.box("a", 2, (-5, 10, -1, 20), 0, file="f.xml", line=1)
    tracemalloc.start()
    try:
        for line in range(2, 20_001):
            validator.box("a", 2, (-5, 10, -1, 20), 0, file="f.xml", line=line)
        assert tracemalloc.get_traced_memory()[0] < 100_000, "a sentence each would be 2 MB"
    finally:
        tracemalloc.stop()
    (skipped,) = validator.finish("f.xml").skipped
    assert skipped.what == "20000 boxes"
    assert skipped.reason == "They lie outside the picture; the first: f.xml, line 1, track a: (-5, 10, -1, 20)."


def test_a_second_box_in_a_frame(validator: ImportValidator) -> None:
    validator.box("a", 1, (0, 0, 9, 9), 0, file="f", line=1)
    validator.box("a", 1, (0, 0, 9, 9), 0, file="f", line=2)
    validator.box("a", 1, (0, 0, 9, 8), 0, file="f", line=3)
    with pytest.raises(ImportFormatError, match="line 3: track 'a' has a second, different box in frame 1"):
        validator.finish("f")


def test_a_second_box_is_reported_in_its_own_file(validator: ImportValidator) -> None:
    for number, x in enumerate((1, 1, 2), start=1):
        validator.box("a", 3, (x, 1, 9, 9), 14, file=f"{number}.txt", line=number)
    with pytest.raises(ImportFormatError, match=r"^3\.txt, line 3: track 'a' has a second, different box in frame 3"):
        validator.finish("1.txt")


def test_the_same_row_twice_is_taken_once(validator: ImportValidator) -> None:
    for _ in range(3):
        validator.box("a", 1, (0, 0, 9, 9), 0, file="f", line=2)
    found = validator.finish("f")
    assert len(next(found.videos[0].tracks()).frames) == 1
    assert found.repaired == ("Repeated boxes were taken once: 2; the first is f, line 2.",)


def test_unknown_names_are_refused_with_their_list(validator: ImportValidator) -> None:
    for frame, name in enumerate(("tree", "stopp", "tree")):
        validator.box(name, frame, (0, 0, 9, 9), validator.label(name, "f", 8), file="f", line=8)
    validator.box("left out", 1, (900, 900, 909, 909), validator.label("of no box", "f", 8), file="f", line=8)
    with pytest.raises(UnknownLabels, match=r"f: 2 names are no label of .*'tree' \(1 track, 2 boxes\)") as reported:
        validator.finish("f")
    assert [(each.name, each.boxes) for each in reported.value.labels] == [("tree", 2), ("stopp", 1)]
    assert [label.key for label in reported.value.labels[1].suggestions] == ["stop"]


def test_the_example_of_a_name_is_its_clearest_box(validator: ImportValidator) -> None:
    tree = validator.label("tree", "f", 8)
    for track, frame, edges, more in (
        ("a", 1, (10, 10, 20, 20), {}),
        ("a", 2, (10, 10, 90, 90), {"occluded": True}),
        ("b", 3, (0, 10, 60, 60), {}),
        ("b", 4, (10, 10, 45, 45), {}),
        ("b", 5, (10, 10, 44, 44), {}),
    ):
        validator.box(track, frame, edges, tree, file="f", **more)
    validator.hide_from("b", 6)
    with pytest.raises(UnknownLabels) as reported:
        validator.finish("f", interpolate=True)
    (found,) = reported.value.labels
    assert (found.tracks, found.boxes, found.frame, found.box) == (2, 5, 4, (10, 10, 45, 45))


def test_no_class_is_a_value_like_any_class(validator: ImportValidator) -> None:
    for frame, label in enumerate((-1, -1, -1, UNSTATED_LABEL, 14)):
        validator.box("a", frame, (0, 0, 9, 9), label, file="f")
        validator.box("b", frame, (0, 0, 9, 9), 14 if label == 14 else UNSTATED_LABEL, file="f")
    first, second = validator.finish("f").videos[0].tracks()
    assert first.labels is not None
    assert (first.label, first.labels.tolist()) == (-1, [-1, -1, -1, -1, 14])
    assert first.silent is not None
    assert first.silent.tolist() == [False, False, False, True, False]
    assert second.label == 14, "what is not said says nothing"


def test_rows_come_in_any_order(validator: ImportValidator) -> None:
    for frame in (5, 3, 9):
        validator.box("a", frame, (frame, 0, frame + 9, 9), frame, file="f")
    track = next(validator.finish("f").videos[0].tracks())
    assert track.frames.tolist() == [3, 5, 9]
    assert track.boxes[:, 0].tolist() == [3, 5, 9]
    assert track.label == 3
    assert track.labels is not None
    assert track.labels.tolist() == [3, 5, 9]


def test_interpolation_stops_at_the_end_of_a_track(validator: ImportValidator) -> None:
    validator.box("a", 0, (0, 0, 10, 10), 0, file="f")
    validator.box("a", 4, (8, 0, 18, 10), 0, file="f", occluded=True)
    validator.hide_from("a", 6)
    validator.box("a", 9, (50, 0, 60, 10), 0, file="f")
    validator.describe("a", until=11)
    track = next(validator.finish("f", interpolate=True).videos[0].tracks())
    assert track.frames.tolist() == [0, 1, 2, 3, 4, 5, 9, 10, 11]
    assert track.boxes[:, 0].tolist() == [0, 2, 4, 6, 8, 8, 50, 50, 50]
    assert np.flatnonzero(track.key).tolist() == [0, 4, 6]
    assert np.flatnonzero(track.occluded).tolist() == [4, 5]


def test_too_many_interpolated_boxes_are_refused(validator: ImportValidator) -> None:
    validator.target = replace(validator.target, limits=ImportLimits(boxes=500))
    for k in range(6):
        validator.box(f"t{k}", 0, (0, 0, 9, 9), 0, file="f")
        validator.box(f"t{k}", 99, (0, 0, 9, 9), 0, file="f")
    with pytest.raises(ImportFormatError, match="more than 500 boxes"):
        validator.finish("f", interpolate=True)


def test_a_track_without_a_visible_box_is_skipped(validator: ImportValidator) -> None:
    validator.hide_from("a", 3)
    validator.box("b", 1, (0, 0, 9, 9), 0, file="f")
    found = validator.finish("f", interpolate=True)
    assert [track.uid for track in found.videos[0].tracks()] == ["b"]
    assert found.skipped[0].what == "f: track a"


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        ("é".encode("latin-1"), "line 1: byte 0xe9 is not UTF-8"),
        (b"a\nb\n\xff", "line 3: byte 0xff"),
        ("a".encode("utf-16"), "line 1: is UTF-16"),
    ],
)
def test_other_encodings(tmp_path: Path, content: bytes, rule: str) -> None:
    (tmp_path / "f.csv").write_bytes(content)
    with pytest.raises(ImportFormatError, match=f"f.csv, {rule}"):
        read_text(tmp_path / "f.csv")


def test_a_byte_order_mark_is_ignored(tmp_path: Path) -> None:
    (tmp_path / "f.csv").write_bytes(b"\xef\xbb\xbfa;b")
    assert read_text(tmp_path / "f.csv") == "a;b"


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        (b'{\n"a": }', "line 2: is not JSON"),
        (b"[Infinity]", "Infinity is not a JSON number"),
        (b"[-Infinity]", "-Infinity is not a JSON number"),
        (b"[" * 100_000, "nested too deeply"),
        (b"[" + b"9" * 5000 + b"]", "is not JSON"),
        (b"", "line 1: is not JSON"),
    ],
)
def test_invalid_json_is_refused(tmp_path: Path, content: bytes, rule: str) -> None:
    (tmp_path / "f.json").write_bytes(content)
    with pytest.raises(ImportFormatError, match=rf"f.json.*{rule}"):
        read_json(tmp_path / "f.json")


def test_a_too_long_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "f.json").write_bytes(b"[]" * 100)
    with pytest.raises(ImportFormatError, match="has 200 bytes, more than the 100"):
        read_json(tmp_path / "f.json", limit=100)


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        ({"boxes": np.full((30, 4), np.nan)}, "finite"),
        ({"boxes": np.tile([5.0, 5, 5, 9], (30, 1))}, "x1 < x2"),
        ({"frames": np.zeros(30, dtype=np.int64)}, "out of order"),
        ({"frames": np.arange(80, 110)}, "must be in 0 to 99"),
        ({"frames": np.arange(-1, 29)}, "must be in 0 to 99"),
        ({"label": 43}, "label"),
        ({"label": -2}, "label"),
        ({"labels": np.full(30, 99)}, "label"),
        ({"score": np.zeros(3)}, "shape"),
        ({"boxes": np.zeros((30, 3))}, "shape"),
        ({"frames": np.zeros(0, dtype=np.int64)}, "no boxes"),
    ],
)
def test_invalid_tracks_are_not_exported(change: dict[str, object], rule: str) -> None:
    track = replace(make_track(), **change)  # type: ignore[arg-type]
    with pytest.raises(ExportError, match=f"drive.mp4, track 'm1': .*{rule}"):
        check_track(track, make_video(), {label.id for label in GTSRB})
