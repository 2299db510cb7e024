"""The numbers of the scenes."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.scene3d.geometry import (
    Camera,
    Volume,
    block_positions,
    focal_length,
    frustum_scale,
    grid_lines,
    metric_positions,
    nice_step,
    pick_rows,
    polyline_ids,
    simplify_lines,
    surface,
)

VOLUME = Volume(width=1600, height=800, first=10.0, last=20.0, size=4.0, depth=10.0)


def test_picture_and_time_map_to_the_corners_of_the_block() -> None:
    boxes = [[0, 0, 0, 0], [1600, 800, 1600, 800], [800, 400, 800, 400]]
    places = VOLUME.positions(boxes, [10.0, 20.0, 15.0])
    assert np.allclose(places, [[-4, -5, 2], [4, 5, -2], [0, 0, 0]])
    assert VOLUME.half_width == pytest.approx(4.0)


def test_an_empty_range_does_not_divide_by_zero() -> None:
    volume = Volume(100, 50, 3.0, 3.0)
    assert np.isfinite(volume.along([3.0])).all()


def test_lines_do_not_join_tracks_or_bridge_long_gaps() -> None:
    track = [0, 0, 0, 1, 1, 2]
    frame = [1, 2, 20, 20, 21, 22]
    assert polyline_ids(track, frame, gap=5).tolist() == [0, 0, 1, 2, 2, 3]
    assert polyline_ids(track, frame, gap=18).tolist() == [0, 0, 0, 1, 1, 2]
    assert polyline_ids([], []).tolist() == []


def passes_by(points: np.ndarray, rows: np.ndarray) -> float:
    """Largest distance of a point from a line through some of the points."""
    worst = 0.0
    for a, b in itertools.pairwise(rows.tolist()):
        way, here = points[b] - points[a], points[a : b + 1] - points[a]
        along = np.clip(here @ way / max(float(way @ way), 1e-18), 0, 1)
        worst = max(worst, float(np.linalg.norm(here - along[:, None] * way, axis=1).max()))
    return worst


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(1, 60), min_size=1, max_size=20), st.integers(1, 400), st.integers(0, 2**31))
def test_simplified_lines_keep_their_ends_and_stay_close_to_boxes(lengths: list[int], most: int, seed: int) -> None:
    strand = np.repeat(np.arange(len(lengths)), lengths)
    points = np.random.default_rng(seed).normal(size=(len(strand), 3)).cumsum(axis=0) * 0.1
    rows = simplify_lines(strand, points, 0.15, most)
    ends = set((np.cumsum(lengths) - 1).tolist()) | {0, *np.cumsum(lengths)[:-1].tolist()}
    assert ends <= set(rows.tolist())
    assert len(rows) <= max(most, len(ends))
    assert (np.diff(rows) > 0).all()
    if len(rows) < most:
        for number in range(len(lengths)):
            of_strand = np.flatnonzero(strand == number)
            assert passes_by(points[of_strand], np.searchsorted(of_strand, rows[strand[rows] == number])) <= 0.15 + 1e-9


def test_a_straight_line_needs_two_corners_and_a_bend_one_more() -> None:
    straight = np.linspace([0, 0, 0], [10, 5, 1], 400)
    assert simplify_lines(np.zeros(400, int), straight, 0.01, 400).tolist() == [0, 399]
    bent = straight.copy()
    bent[200:] += np.arange(200)[:, None] * [0.0, 0.0, 0.1]
    assert simplify_lines(np.zeros(400, int), bent, 0.01, 400).tolist() in ([0, 199, 399], [0, 200, 399])
    assert simplify_lines([], np.zeros((0, 3)), 0.1, 5).tolist() == []


def test_line_colours_change_at_the_right_frame() -> None:
    keep = np.zeros(1000, np.bool_)
    keep[333] = True
    straight = np.linspace([0, 0, 0], [10, 5, 1], 1000)
    assert simplify_lines(np.zeros(1000, int), straight, 0.1, 10, keep).tolist() == [0, 333, 999]
    assert len(simplify_lines(np.zeros(1000, int), straight, 0.1, 10, np.ones(1000, np.bool_))) <= 11


def test_boxes_near_the_cursor_or_selected_are_clickable() -> None:
    frame = np.array([0, 10, 20, 30, 0, 100])
    track = np.array([0, 0, 0, 0, 1, 1])
    rows, left = pick_rows(frame, track, 20, 10, np.array([False, False]), 100)
    assert rows.tolist() == [1, 2, 3]
    assert left == 0
    rows, _ = pick_rows(frame, track, 20, 0, np.array([False, True]), 100)
    assert rows.tolist() == [2, 4, 5]


def test_too_many_boxes_are_thinned_far_ones_first_and_selected_ones_last() -> None:
    frame = np.tile(np.arange(100), 2)
    track = np.repeat([0, 1], 100)
    rows, left = pick_rows(frame, track, 50, 50, np.array([False, True]), 120)
    assert len(rows) == 120
    assert left == 80
    assert (track[rows] == 1).sum() == 100
    assert (np.abs(frame[rows[track[rows] == 0]] - 50) <= 10).all()


def test_a_block_has_the_size_of_the_box_and_the_depth_of_a_frame() -> None:
    places, sizes = block_positions(VOLUME, [[100, 100, 300, 200], [0, 0, 1, 1]], [10.0, 15.0], 0.04, min_side=0.02)
    assert np.allclose(sizes[0], [200 * 4 / 800, 0.04, 100 * 4 / 800])
    assert np.allclose(sizes[1], [0.02, 0.04, 0.02])
    assert np.allclose(places[0, 1], -5.0)


@pytest.mark.parametrize(
    ("span", "most", "step"), [(10, 10, 1), (10, 8, 2), (0.5, 10, 0.05), (60, 8, 10), (300, 8, 60), (5400, 8, 900)]
)
def test_steps_are_round(span: float, most: int, step: float) -> None:
    assert nice_step(span, most) == pytest.approx(step)
    assert span / nice_step(span, most) <= most + 1e-9


def test_every_span_has_a_step() -> None:
    assert nice_step(0.0, 8) > 0
    assert nice_step(1e9, 8) >= 1e9 / 8


def test_the_surface_follows_the_table_and_faces_upwards() -> None:
    table = np.random.default_rng(1).random((16, 24))
    vertices, faces = surface(table, width=8.0, depth=4.0, height=2.0, every=1)
    assert len(vertices) == table.size
    assert np.allclose(vertices[:, 2].reshape(table.shape), 2 * table)
    assert vertices[0, 1] > vertices[-1, 1], "the upper edge of the picture lies far away"
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    assert np.array_equal(np.unique(faces), np.arange(table.size))


def test_a_thinned_surface_reaches_the_last_row_and_column() -> None:
    vertices, _ = surface(np.zeros((128, 128)), 1.0, 1.0, 1.0, every=5)
    assert vertices[:, 0].max() == pytest.approx(127.5 / 128 - 0.5)
    assert vertices[:, 1].min() == pytest.approx(0.5 - 127.5 / 128)


def test_the_cloth_lies_on_the_surface() -> None:
    table = np.random.default_rng(2).random((16, 16))
    lines, values = grid_lines(table, 8.0, 4.0, 2.0, every=4, lift=0.5, bends=1)
    assert lines.shape[1:] == (2, 3)
    assert values.shape == lines.shape[:2]
    assert np.allclose(lines[..., 2], values * 2 + 0.5)


def test_a_sign_of_known_size_is_at_distance_f_d_over_w() -> None:
    camera = Camera(1000, 500, focal=800.0)
    boxes = [[480, 230, 520, 270], [880, 130, 920, 170]]
    ahead, aside = metric_positions(camera, boxes, 0.6)
    assert np.allclose(ahead, [0.0, 800 * 0.6 / 40, 0.0])
    assert np.allclose(aside, [400 * 12 / 800, 12.0, 100 * 12 / 800])
    assert np.isfinite(metric_positions(camera, [[5, 5, 5, 5]], 0.6)).all()


def test_projection_reproduces_the_box() -> None:
    rng = np.random.default_rng(3)
    camera = Camera(1280, 720, focal_length(1280, 60.0))
    centre, wide = rng.uniform([0, 0], [1280, 720], (50, 2)), rng.uniform(8, 90, 50)
    size = rng.choice([0.6, 0.9], 50)
    boxes = np.concatenate([centre - wide[:, None] / 2, centre + wide[:, None] / 2], axis=1)
    right, ahead, up = metric_positions(camera, boxes, size).T
    assert np.allclose(right / ahead * camera.focal + 640, centre[:, 0])
    assert np.allclose(360 - up / ahead * camera.focal, centre[:, 1])
    assert np.allclose(size / ahead * camera.focal, wide)


def test_the_focal_length_fits_the_field_of_view() -> None:
    assert focal_length(1280, 90.0) == pytest.approx(640.0)
    camera = Camera(1280, 720, focal_length(1280, 60.0))
    assert math.tan(camera.vertical_view / 2) * camera.focal == pytest.approx(360.0)


def test_the_frustum_ends_at_the_given_distance() -> None:
    camera = Camera(1280, 720, 900.0)
    # viser's own normalisation, see CameraFrustumVariants.tsx
    y = math.tan(camera.vertical_view / 2)
    volume = ((y * 1280 / 720) * y / 3) ** (1 / 3)
    assert frustum_scale(camera, 5.0) / volume == pytest.approx(5.0)
