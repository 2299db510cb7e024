"""Colours and legends."""

from __future__ import annotations

import numpy as np

from app.scene3d.colours import Entry, height_colours, legend_html, linear, paint
from tsr_engine.recognition.gtsrb_classes import CLASS_NAMES

NAMES = dict(enumerate(CLASS_NAMES))


def test_the_most_frequent_classes_have_distinct_colours_and_a_legend() -> None:
    classes = np.array([14, 14, 14, 2, 2, -1, *range(20, 32)])
    track = np.arange(len(classes))
    found = paint("class", track, classes, np.zeros(len(track), int), np.zeros(len(track), int), NAMES)
    assert [entry.text for entry in found.legend[:2]] == ["stop", "speed limit 50 km/h"]
    assert found.legend[-2].text == "6 other labels"
    assert found.legend[-1].text == "not recognised"
    assert tuple(found.rows[0]) == found.legend[0].colour
    assert tuple(found.rows[5]) == found.legend[-1].colour
    assert len({entry.colour for entry in found.legend[:8]}) == 8


def test_the_legend_lists_only_present_classes() -> None:
    found = paint("verdict", [0, 0], [3], [0, 0], [1, 2], NAMES)
    assert [entry.text for entry in found.legend] == ["confident", "rejected"]
    assert [entry.text for entry in paint("source", [0], [3], [2], [0], NAMES).legend] == [
        "found again by the online detector"
    ]


def test_nothing_is_painted_without_tracks() -> None:
    assert paint("class", [], [], [], [], NAMES).rows.shape == (0, 3)


def test_names_are_plain_text_in_a_legend() -> None:
    page = legend_html("<b>Run</b>", (Entry((1, 2, 3), "<img src=x>"),), ("a & b",))
    assert "<b>" not in page
    assert "<img" not in page
    assert "&lt;img src=x&gt;" in page
    assert "a &amp; b" in page


def test_linear_light_is_the_inverse_of_srgb() -> None:
    assert linear([[0, 0, 0], [255, 255, 255]]).tolist() == [[0, 0, 0], [255, 255, 255]]
    assert linear([188, 188, 188]).tolist() == [128, 128, 128]  # the grey that is half as bright as white


def test_heat_goes_from_blue_to_yellow() -> None:
    low, high = height_colours([0.0, 1.0]).astype(int)
    assert low[2] > low[0]
    assert high[0] > high[2]
