"""Each kind of expectation, met and not, and the verdict that follows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.bundle.tracked_drive import make_expectation
from tsr_engine.bundle.expectation import read_expectation
from tsr_engine.bundle.judge import Finding, judge, overall_verdict
from tsr_engine.bundle.output import Output, read_rows, same_output, write_rows
from tsr_engine.errors import ImportFormatError
from tsr_engine.evidence import ResultRow

BOX = (10.0, 10.0, 30.0, 30.0)
FAR = (100.0, 100.0, 120.0, 120.0)


def rows(track: int, frames: Any, box: Any = BOX, label: int = 14) -> list[ResultRow]:
    return [ResultRow(frame, track, *box, label, 1.0, "detected") for frame in frames]


def output(*groups: list[ResultRow]) -> Output:
    return Output.from_rows([row for group in groups for row in group], 0, 20)


def sign(frames: Any = range(10), box: Any = BOX, **more: Any) -> dict[str, Any]:
    return {"frames": list(frames), "boxes": [box] * len(list(frames)), **more}


def verdict(kind: str, out: Output, signs: Any = None, **more: Any) -> Finding:
    content = {"signs": signs or {"s": sign()}, "expected": [{"id": "x", "kind": kind, "sign": "s", **more}]}
    return judge(make_expectation(**content), out)[0]


def shifted(px: float) -> tuple[float, ...]:
    return tuple(edge + px for edge in BOX)


def test_found_needs_a_track_on_the_sign() -> None:
    assert verdict("found", output(rows(1, range(5)))).met
    missed = verdict("found", output(rows(1, range(4))))
    assert (missed.met, missed.frame) == (False, 4)
    assert "4 of 10 frames" in missed.got
    hidden = {"s": sign(hidden=[4, 5, 6, 7, 8, 9])}
    assert verdict("found", output(rows(1, range(2))), hidden).met
    assert not verdict("found", output(rows(1, range(10), FAR))).met


def test_a_sign_may_have_a_blank_name() -> None:
    content = {"signs": {" ": sign()}, "expected": [{"id": "x", "kind": "found", "sign": " "}]}
    assert judge(make_expectation(**content), output(rows(1, range(10))))[0].met


def test_label_needs_the_class_of_most_frames() -> None:
    most = output(rows(1, range(4), label=3), rows(2, range(4, 10), label=14))
    assert verdict("label", most, class_id=14).met
    wrong = verdict("label", most, class_id=3)
    assert not wrong.met
    assert "Track 2 is labelled 14 (Stop)" in wrong.got or "14" in wrong.got
    assert verdict("label", output(), class_id=14).got == "No track lies on it."


def test_boxes_need_overlap_in_every_named_frame() -> None:
    near = output(rows(1, range(10), shifted(1.0)))
    assert verdict("boxes", near, frames=[0, 5]).met
    off = verdict("boxes", output(rows(1, range(5), BOX), rows(1, range(5, 10), shifted(5.0))), frames=[0, 5])
    assert (off.met, off.frame) == (False, 5)
    assert "1 of 2 boxes are off" in off.got
    assert verdict("boxes", output(), frames=[3]).got.endswith("is 1.00, in frame 3.")


def test_absent_needs_a_place_without_a_track() -> None:
    assert verdict("absent", output(rows(1, range(10), FAR))).met
    there = verdict("absent", output(rows(7, [3])))
    assert (there.met, there.frame, there.got) == (False, 3, "Track 7 lies there in 1 of 10 frames.")


def test_one_needs_a_single_track() -> None:
    assert verdict("one", output(rows(1, range(10)))).met
    two = verdict("one", output(rows(1, range(6)), rows(2, range(6, 10))))
    assert (two.met, two.frame) == (False, 6)
    assert not verdict("one", output(rows(1, range(10)), rows(2, [4]))).met
    assert not verdict("one", output()).met


def test_apart_needs_different_tracks() -> None:
    signs = {"s": sign(range(5)), "t": sign(range(5, 10), FAR)}
    one = output(rows(1, range(5)), rows(1, range(5, 10), FAR))
    assert verdict("apart", one, signs, other="t").got == "Track 1 lies on both."
    assert verdict("apart", output(rows(1, range(5)), rows(2, range(5, 10), FAR)), signs, other="t").met


def make_finding(id: str, met: bool) -> Finding:
    return Finding(id, met, "", "", 0)


@pytest.mark.parametrize(
    ("before", "now", "same", "wanted"),
    [
        ((False, True), (True, True), False, "fixed"),
        ((True, True), (True, True), True, "fixed"),
        ((False, True), (False, True), True, "still broken"),
        ((False, True), (False, False), False, "still broken"),
        ((False, False), (True, False), False, "still broken"),
        ((False, True), (True, False), False, "different"),
        ((True, True), (True, False), False, "different"),
        ((), (), True, "unchanged"),
        ((), (), False, "different"),
    ],
)
def test_the_verdict(before: Any, now: Any, same: bool, wanted: str) -> None:
    pairs = [[make_finding(str(i), met) for i, met in enumerate(side)] for side in (before, now)]
    assert overall_verdict(pairs[0], pairs[1], same) == wanted


def test_equality_of_two_outputs() -> None:
    base = output(rows(1, range(10)), rows(2, range(10), FAR))
    assert same_output(base, output(rows(8, range(10)), rows(5, range(10), FAR)))  # track numbers do not matter
    assert same_output(base, output(rows(1, range(10), shifted(0.4)), rows(2, range(10), FAR)))
    assert not same_output(base, output(rows(1, range(10), shifted(0.6)), rows(2, range(10), FAR)))
    assert not same_output(base, output(rows(1, range(10), label=3), rows(2, range(10), FAR)))
    assert not same_output(base, output(rows(1, range(10))))
    parted = output(rows(1, range(5)), rows(3, range(5, 10)), rows(2, range(10), FAR))
    assert not same_output(base, parted)
    assert not same_output(parted, base)
    assert same_output(output(), output())


def test_rows_round_trip(tmp_path: Path) -> None:
    path = tmp_path / "output.csv"
    with path.open("w", encoding="utf-8") as out:
        write_rows(out, rows(3, range(4)))
    assert read_rows(path) == rows(3, range(4))
    for text, words in (("x\n", "line 1"), ("1,2\n", "line 2"), ("0,1,nan,0,1,1,0,1,detected\n", "line 2: a box")):
        header = "" if text == "x\n" else path.read_text().splitlines()[0] + "\n"
        bad = tmp_path / "bad.csv"
        bad.write_text(header + text)
        with pytest.raises(ImportFormatError, match=words):
            read_rows(bad)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('{"signs": {"s": {"frames": [1, 1], "boxes": [[0,0,1,1],[0,0,1,1]]}}}', "not ascending"),
        ('{"signs": {"s": {"frames": [1], "boxes": [[0,0,0,1]]}}}', "box of frame 1"),
        ('{"signs": {"s": {"frames": [1], "boxes": []}}}', "1 frames have 0 boxes"),
        ('{"signs": {"s": {"frames": [1], "boxes": [[0,0,NaN,1]]}}}', "signs.s.boxes"),
        ('{"expected": [{"id": "a", "kind": "found", "sign": "s"}]}', "no sign 's'"),
        ('{"expected": [{"id": "a", "kind": "label", "sign": "s"}]}', "class_id belongs"),
        ('{"expected": [{"id": "a", "kind": "label", "sign": "s", "class_id": 43}]}', "class_id"),
        ('{"expected": [{"id": "a", "kind": "perfect", "sign": "s"}]}', "kind"),
        ('{"format": 2}', "format"),
        ("[[[", "not JSON"),
        ("[" * 100_000, "not JSON"),
    ],
)
def test_invalid_expectations_are_refused(tmp_path: Path, content: str, words: str) -> None:
    path = tmp_path / "expectation.json"
    path.write_text(content)
    with pytest.raises(ImportFormatError, match=words) as caught:
        read_expectation(path)
    assert "\n" not in str(caught.value)
