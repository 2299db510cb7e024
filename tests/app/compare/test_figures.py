"""Figures of a comparison, against the evaluation's and against hand-computed cases."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.compare.figures import OF_CANDIDATE, confusion, figures
from tsr_engine.evaluation.matching import match
from tsr_engine.evaluation.tracking import evaluate_video, summarise
from tsr_engine.track_table import TrackTable

Row = tuple[int, int, float, float, float, int, bool]
"""Frame, track, left, top, side, class, ignore."""


def table(rows: Sequence[Row], letter: str) -> TrackTable:
    ordered = sorted(rows, key=lambda row: row[:2])
    tracks = sorted({row[1] for row in ordered})
    boxes = np.array([[x, y, x + s, y + s] for _, _, x, y, s, _, _ in ordered], np.float64).reshape(-1, 4)
    return TrackTable(
        frame=np.array([row[0] for row in ordered], np.int64),
        track=np.array([tracks.index(row[1]) for row in ordered], np.int64),
        boxes=boxes,
        class_id=np.array([row[5] for row in ordered], np.int64),
        ignore=np.array([row[6] for row in ordered], np.bool_),
        names=tuple(f"{letter}{track}" for track in tracks),
    )


place = st.tuples(
    st.integers(0, 7), st.integers(0, 3), st.integers(0, 12), st.integers(0, 12), st.integers(12, 40), st.integers(0, 3)
)


def rows_of(drawn: list[tuple[int, ...]], ignore: bool) -> list[Row]:
    unique = {(f, t): (f, t, float(x), float(y), float(s), c, ignore and c == 3) for f, t, x, y, s, c in drawn}
    # A track has one class, as the engine's results have.
    label = {t: c for (_, t), (*_, c, _) in unique.items()}
    return [(f, t, x, y, s, c if ignore else label[t], skip) for f, t, x, y, s, c, skip in unique.values()]


@settings(max_examples=150, deadline=None)
@given(st.lists(place, max_size=40), st.lists(place, max_size=40))
def test_figures_equal_those_of_the_engine(one: list[tuple[int, ...]], two: list[tuple[int, ...]]) -> None:
    reference, candidate = table(rows_of(one, True), "t"), table(rows_of(two, False), "m")
    found = match(reference, candidate)
    report = evaluate_video("x", reference, candidate, 8)
    summary = summarise([report])
    got = figures(reference, candidate, found)
    assert len(found.reference) == len(report.errors) + len(report.narrow_errors)
    assert len(found.false) == report.false_rows
    assert got["coverage"].value == pytest.approx(summary.coverage)
    assert got["eq7"].value == pytest.approx(summary.mean_error_any_width)
    assert got["switches"].value == summary.switches
    assert got["fragmentation"].value == summary.fragments
    assert got["ids_per_sign"].value == pytest.approx(summary.ids_per_sign)
    assert got["signs_found"].value == pytest.approx(summary.detection_rate)
    assert got["signs_classified"].value == pytest.approx(summary.classified_of_detected)
    assert got["false_tracks"].value == summary.false_tracks
    cells = confusion(reference, candidate, found).cells
    assert sum(cell.count for cell in cells) == len(found.reference) + len(found.missed) + len(found.false)


def line(track: int, frames: range, x: float, label: int = 14, side: float = 30.0, ignore: bool = False) -> list[Row]:
    return [(k, track, x, 10.0, side, label, ignore) for k in frames]


def test_every_figure_opens_its_places() -> None:
    reference = table([*line(1, range(10), 0.0), *line(2, range(5, 15), 100.0, 13)], "t")
    candidate = table(
        [
            *line(1, range(4), 0.0),  # the first sign, lost for two frames, then found by another track
            *line(4, range(6, 10), 1.0),
            *line(7, range(5, 15), 100.0, 17),  # the second sign with another class
            *line(9, range(20, 23), 50.0),  # a false track
        ],
        "m",
    )
    found = match(reference, candidate)
    got = figures(reference, candidate, found)
    assert got["precision"].of == (18, 21)
    assert (got["precision"].frames, got["precision"].lasts, got["precision"].tracks) == ([20], [22], ["m9"])
    assert got["recall"].of == (18, 20)
    assert (got["recall"].frames, got["recall"].lasts, got["recall"].tracks) == ([4], [5], ["t1"])
    assert (got["fragmentation"].value, got["fragmentation"].frames) == (1.0, [4])
    assert (got["switches"].value, got["switches"].frames, got["switches"].tracks) == (1.0, [6], ["m4"])
    assert (got["ids_per_sign"].value, got["ids_per_sign"].frames) == (1.5, [6])
    assert got["false_tracks"].tracks == ["m9"]
    assert got["signs_classified"].of == (1, 2)
    assert got["signs_classified"].tracks == ["t2"]
    # the other side's name, so that a sign of the ground truth opens with its matching track
    assert got["signs_classified"].partners == ["m7"]
    assert (got["ids_per_sign"].partners, got["switches"].partners) == (["m4"], ["t1"])
    assert (got["recall"].partners, got["false_tracks"].partners) == ([None], [None])
    assert got["eq7"].frames[:4] == [6, 7, 8, 9]
    assert got["eq7"].errors == pytest.approx([1 / 30] * 4)
    assert got["recall"].errors is None
    assert got["eq7"].value == pytest.approx(4 * (1 / 30) / 18)
    table_of = {
        (c.reference, c.candidate): (c.count, c.frames, c.tracks, c.partners)
        for c in confusion(reference, candidate, found).cells
    }
    assert table_of == {
        (14, 14): (8, [0, 6], ["t1", "t1"], ["m1", "m4"]),
        (13, 17): (10, [5], ["t2"], ["m7"]),
        (14, None): (2, [4], ["t1"], [None]),
        (None, 14): (3, [20], ["m9"], [None]),
    }


def test_a_sign_without_a_class_is_neither_missed_nor_false() -> None:
    reference = table([*line(1, range(4), 0.0, -1), *line(2, range(4), 100.0), *line(3, range(4), 200.0, -1)], "t")
    candidate = table([*line(1, range(4), 0.0, -1), *line(2, range(4), 100.0, -1), *line(9, range(3), 50.0, -1)], "m")
    found = confusion(reference, candidate, match(reference, candidate))
    assert {(cell.reference, cell.candidate): (cell.count, cell.tracks, cell.partners) for cell in found.cells} == {
        (-1, -1): (4, ["t1"], ["m1"]),
        (14, -1): (4, ["t2"], ["m2"]),
        (-1, None): (4, ["t3"], [None]),
        (None, -1): (3, ["m9"], [None]),
    }
    assert found.classes == [14, -1]


def test_a_figure_names_the_side_of_its_tracks() -> None:
    page = Path(__file__).parents[3] / "static" / "js" / "views" / "compare_figures.js"
    sides = dict(
        re.findall(r"^  (\w+): \[[^\]]*?'(reference|candidate)'", page.read_text(encoding="utf-8"), re.MULTILINE)
    )
    empty = table([], "t")
    assert sides.keys() == figures(empty, empty, match(empty, empty)).keys()
    assert {name for name, side in sides.items() if side == "candidate"} == OF_CANDIDATE


def test_a_box_on_an_ignored_one_is_neither_right_nor_wrong() -> None:
    reference = table([*line(1, range(3), 0.0), *line(2, range(3), 100.0, ignore=True)], "t")
    candidate = table([*line(1, range(3), 0.0), *line(2, range(3), 105.0, side=10.0)], "m")
    got = figures(reference, candidate, match(reference, candidate))
    assert got["precision"].of == (3, 3)
    assert got["recall"].of == (3, 3)
    assert got["false_tracks"].value == 0


def test_two_empty_sides_have_no_figures() -> None:
    empty = table([], "t")
    got = figures(empty, empty, match(empty, empty))
    assert {name for name, figure in got.items() if figure.value is None} == {
        "precision",
        "recall",
        "eq7",
        "coverage",
        "ids_per_sign",
        "signs_found",
        "signs_classified",
    }
