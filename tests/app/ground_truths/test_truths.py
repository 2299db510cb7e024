"""Ground truth: strict rows, complete or refused, and returned as boxes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from app.errors import Invalid, NotFound
from app.ground_truths.service import GroundTruthService
from app.storage.ground_truth_rows import COLUMNS, pack, parse, unpack
from sample_videos import SHIPPED
from tsr_engine.evaluation.track_tables import read_clip_truth

HEAD = ",".join(COLUMNS) + "\n"
GOOD = "0,1,10,20,30,40,14,1,0\n"


def test_the_bundled_ground_truth_equals_the_engines_reading() -> None:
    for clip in SHIPPED:
        rows = parse(clip.truth.read_bytes(), 300)
        truth = read_clip_truth(clip.truth)
        order = np.lexsort((truth.track, truth.frame))
        assert np.array_equal(rows[:, 2:6], truth.boxes[order])
        assert np.array_equal(rows[:, 6], truth.class_id[order])
        assert np.array_equal(rows[:, 8] != 0, truth.ignore[order])
        assert np.array_equal(unpack(pack(rows)), rows)


@pytest.mark.data
def test_the_ground_truth_of_the_clip_is_accepted(clips: Any) -> None:
    for path in sorted((clips / "gt").glob("*.csv")):
        assert len(parse(path.read_bytes(), None)) == len(read_clip_truth(path).frame)


@pytest.mark.parametrize(
    ("text", "line", "rule"),
    [
        ("", 1, "the header must name frame,track_id"),
        ("frame,track_id\n", 1, "the header must name"),
        (HEAD + "0,1,10,20,30,40,14,1\n", 2, "9 values, got 8"),
        (HEAD + GOOD + "0,2,10,20,30,40,14,1,0,7\n", 3, "9 values, got 10"),
        (HEAD + "x,1,10,20,30,40,14,1,0\n", 2, "frame must be a number"),
        (HEAD + "0,1,nan,20,30,40,14,1,0\n", 2, "x1 must be finite"),
        (HEAD + "0,1,1e999,20,30,40,14,1,0\n", 2, "x1 must be finite"),
        (HEAD + "0.5,1,10,20,30,40,14,1,0\n", 2, "frame must be a whole number from 0 to 74"),
        (HEAD + "75,1,10,20,30,40,14,1,0\n", 2, "frame must be a whole number from 0 to 74"),
        (HEAD + "-1,1,10,20,30,40,14,1,0\n", 2, "frame must be"),
        (HEAD + "0,-1,10,20,30,40,14,1,0\n", 2, "track_id must be"),
        (HEAD + "0,1,30,20,30,40,14,1,0\n", 2, "x1 < x2"),
        (HEAD + "0,1,10,20,3e9,40,14,1,0\n", 2, "lie within"),
        (HEAD + "0,1,10,20,30,40,43,1,0\n", 2, "class_id must be"),
        (HEAD + "0,1,10,20,30,40,14,1.5,0\n", 2, "visibility"),
        (HEAD + "0,1,10,20,30,40,14,1,2\n", 2, "ignore must be 0 or 1"),
        (HEAD + GOOD + "\n" + GOOD, 4, "line 2 has this frame and track already"),
    ],
)
def test_the_first_bad_row_is_named_with_its_rule(text: str, line: int, rule: str) -> None:
    with pytest.raises(Invalid, match=rule) as caught:
        parse(text.encode(), 75)
    assert caught.value.message.startswith(f"Line {line}: ")
    assert caught.value.field == f"line {line}"


def test_invalid_text_is_refused() -> None:
    with pytest.raises(Invalid, match="UTF-8"):
        parse(HEAD.encode() + b"\xff\xfe", 75)


def test_byte_order_marks_and_other_line_ends_are_read() -> None:
    rows = parse(b"\xef\xbb\xbf" + (HEAD + GOOD).replace("\n", "\r\n").encode(), 75)
    assert rows.tolist() == [[0, 1, 10, 20, 30, 40, 14, 1, 0]]


def test_ground_truth_is_imported_replaced_read_and_removed(home: Any) -> None:
    ground_truths = GroundTruthService(home.database)
    first = ground_truths.put(home.video_id, "mine", (HEAD + GOOD + "3,1,10,20,30,40,-1,0.5,1\n").encode())
    assert (first.count, [t.name for t in ground_truths.of_video(home.video_id)]) == (2, ["mine"])
    with pytest.raises(Invalid):
        ground_truths.put(home.video_id, "mine", (HEAD + GOOD + GOOD).encode())
    assert [t.id for t in ground_truths.of_video(home.video_id)] == [first.id]
    assert ground_truths.window(first.id, 1, 10)[:, :2].tolist() == [[3, 1]]
    with pytest.raises(Invalid, match="1 to 256"):
        ground_truths.window(first.id, 0, 256)
    again = ground_truths.put(home.video_id, "mine", (HEAD + GOOD).encode())
    assert [t.id for t in ground_truths.of_video(home.video_id)] == [again.id]
    video, name, boxes = ground_truths.boxes(again.id)
    assert (video, name, boxes.names, boxes.boxes.tolist()) == (home.video_id, "mine", ("t1",), [[10, 20, 30, 40]])
    ground_truths.remove(again.id)
    for call in (lambda: ground_truths.remove(again.id), lambda: ground_truths.rows(again.id)):
        with pytest.raises(NotFound):
            call()
    with pytest.raises(NotFound):
        ground_truths.put("0" * 64, "mine", (HEAD + GOOD).encode())
