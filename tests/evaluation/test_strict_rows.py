"""Tables are read as intended, or refused with the first line that breaks a rule and the rule."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tsr_engine.errors import InputError
from tsr_engine.evaluation.box_tables import (
    RESULT_COLUMNS,
    TRUTH_COLUMNS,
    RowError,
    read_mot_table,
    read_result_table,
    read_truth_table,
)
from tsr_engine.evaluation.track_tables import read_clip_truth, read_mot_truth, read_results

TRUTH = ",".join(TRUTH_COLUMNS) + "\n"
RESULT = ",".join(RESULT_COLUMNS) + "\n"
GOOD = "0,1,10,20,30,40,14,1,0\n"


@pytest.mark.parametrize(
    ("row", "rule"),
    [
        ("1.9,1,10,20,30,40,14,1,0", "frame must be a whole number from 0 to 2147483647, got 1.9"),
        ("1e30,1,10,20,30,40,14,1,0", r"frame must be a whole number from 0 to 2147483647, got 1e\+30"),
        ("-1,1,10,20,30,40,14,1,0", "frame must be"),
        ("1,1.5,10,20,30,40,14,1,0", "track_id must be a whole number from 0 on, got 1.5"),
        ("1,1,30,20,10,40,14,1,0", "a box needs x1 < x2 and y1 < y2, got 30, 20, 10, 40"),
        ("1,1,10,20,30,20,14,1,0", "a box needs x1 < x2 and y1 < y2"),
        ("1,1,10,20,2e5,40,14,1,0", "the edges of a box lie within 100000 px"),
        ("1,1,10,20,30,40,43,1,0", "class_id must be a whole number from -1 to 42, got 43"),
        ("1,1,10,20,30,40,14,5,0", "visibility must lie in 0 to 1, got 5"),
        ("1,1,10,20,30,40,14,1,7", "ignore must be 0 or 1, got 7"),
        ("1,1,nan,20,30,40,14,1,0", "x1 must be finite, got nan"),
        ("inf,1,10,20,30,40,14,1,0", "frame must be finite, got inf"),
        ("0,1,11,21,31,41,14,1,0", "a track has one box a frame; line 2 has this frame and track already"),
        ("1,1,10,20,30,40,14,1", "a row has 9 values, got 8"),
        ("1,one,10,20,30,40,14,1,0", "track_id must be a number, got 'one'"),
        ("1,1_0,10,20,30,40,14,1,0", "track_id must be a number, got '1_0'"),
    ],
)
def test_a_bad_row_of_clip_ground_truth_is_refused(tmp_path: Path, row: str, rule: str) -> None:
    path = tmp_path / "clip.csv"
    path.write_text(TRUTH + GOOD + row + "\n")
    with pytest.raises(InputError, match=rf"clip\.csv, line 3: {rule}.*\. Correct the table\.$"):
        read_clip_truth(path)


@pytest.mark.parametrize(
    ("row", "rule"),
    [
        ("2.5,1,1,2,30,40,14,1.5,detected", "frame must be"),
        ("2,1,30,2,1,40,14,1.5,detected", "x1 < x2"),
        ("2,1,1,2,30,40,-2,1.5,detected", "class_id must be a whole number from -1 on"),
        ("2,1,1,2,30,40,14,inf,detected", "score must be finite"),
        ("1,1,1,2,30,40,14,1.5,predicted", "line 2 has this frame and track already"),
    ],
)
def test_a_bad_row_of_results_is_refused(tmp_path: Path, row: str, rule: str) -> None:
    path = tmp_path / "out.csv"
    path.write_text(RESULT + "1,1,1,2,30,40,14,1.5,detected\n" + row + "\n")
    with pytest.raises(InputError, match=rf"out\.csv, line 3: .*{rule}"):
        read_results(path)


@pytest.mark.parametrize(
    ("row", "rule"),
    [
        ("0,4,10.5,20,30,40,1,14,0.9", "frame must be a whole number from 1 to"),
        ("2.5,4,10.5,20,30,40,1,14,0.9", "frame must be"),
        ("2,4,10.5,20,-30,40,1,14,0.9", "width and height must be above 0, got -30, 40"),
        ("2,4,10.5,20,30,40,2,14,0.9", "flag must be 0 or 1"),
        ("2,4,10.5,20,30,40,1,1.5,0.9", "class_id must be"),
        ("2,4,10.5,20,30,40,1,14,-1", "visibility must lie in 0 to 1"),
        ("1,4,10.5,20,30,40,1,14,0.9", "line 1 has this frame and track already"),
        ("2,4,10.5,20,30,40,1,14", "a row has at least 9 values, got 8"),
    ],
)
def test_a_bad_mot_row_is_refused(tmp_path: Path, row: str, rule: str) -> None:
    path = tmp_path / "gt.txt"
    path.write_text("1,4,10.5,20,30,40,1,14,0.9\n" + row + "\n")
    with pytest.raises(InputError, match=rf"gt\.txt, line 2: .*{rule}"):
        read_mot_truth(path)


def test_the_first_bad_line_is_named_for_every_rule() -> None:
    """Numbers are read line by line, rules are checked at the end, duplicates are found across all lines."""
    twice = GOOD
    upside_down = "1,1,30,20,10,40,14,1,0\n"
    no_number = "2,1,10,20,thirty,40,14,1,0\n"
    for bad, line in (
        (upside_down + no_number, 3),
        (no_number + upside_down, 3),
        (upside_down + twice, 3),
        (twice + upside_down, 3),
        (twice + no_number, 3),
        ("\n" + GOOD.replace("0,1", "5,1") + twice + upside_down, 5),
    ):
        with pytest.raises(RowError) as caught:
            read_truth_table((TRUTH + GOOD + bad).encode())
        assert caught.value.line == line, bad


def test_columns_are_found_by_name() -> None:
    """Tables have more columns, another order, byte order marks and other line ends."""
    text = 'note,ignore,visibility,class_id,y2,x2,y1,x1,track_id,frame\r\n"a, b",0,0.5,14,40,30,20,10,1,7\r\n'
    assert read_truth_table(b"\xef\xbb\xbf" + text.encode()).tolist() == [[7, 1, 10, 20, 30, 40, 14, 0.5, 0]]
    table, source = read_result_table((RESULT + "2,1,1,2,30,40,-1,1.5,relocalised\n").encode())
    assert (table.tolist(), source) == ([[2, 1, 1, 2, 30, 40, -1, 1.5]], ("relocalised",))
    assert read_mot_table(b"1,4,10.5,20,30,40,1,77,0.9,more\n").tolist() == [[1, 4, 10.5, 20, 30, 40, 1, 77, 0.9]]
    with pytest.raises(RowError, match="each once"):
        read_truth_table(TRUTH.replace("ignore", "frame").encode())


@pytest.mark.parametrize(("read", "head"), [(read_truth_table, TRUTH), (read_mot_table, "")])
def test_a_table_without_rows_is_refused(read: Callable[[bytes], np.ndarray], head: str) -> None:
    assert read(head.encode()).shape == (0, 9)


def test_too_many_rows_are_refused() -> None:
    rows = "".join(f"{k},1,10,20,30,40,14,1,0\n" for k in range(4))
    assert len(read_truth_table((TRUTH + rows).encode(), max_rows=4)) == 4
    with pytest.raises(RowError, match="line 5: a file has at most 3 rows"):
        read_truth_table((TRUTH + rows).encode(), max_rows=3)
    with pytest.raises(RowError, match="frame must be a whole number from 0 to 2, got 3"):
        read_truth_table((TRUTH + rows).encode(), frames=3)
