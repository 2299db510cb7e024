"""The pinhole camera: w = f D / Z, rays against projection, how the axes lie."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sample_videos.camera import Shake, look


@settings(deadline=None, max_examples=25)
@given(st.floats(3, 80), st.floats(0.3, 2.0), st.floats(-3, 3), st.floats(0, 4))
def test_width_is_focal_times_size_over_distance(z: float, wide: float, x: float, y: float) -> None:
    camera = look(1280, 720, 1100.0, np.array([0.0, 1.3, 0.0]), 0.0, 0.0, 0.0)
    ends = camera.project(np.array([[x - wide / 2, y, z], [x + wide / 2, y, z]]))
    assert ends[1, 0] - ends[0, 0] == pytest.approx(1100.0 * wide / z, rel=1e-9)
    assert ends[0, 1] == pytest.approx(camera.centre[1] + 1100.0 * (1.3 - y) / z)


@settings(deadline=None, max_examples=25)
@given(st.floats(-0.4, 0.4), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_rays_and_projection_agree(yaw: float, pitch: float, roll: float) -> None:
    camera = look(64, 40, 50.0, np.array([3.0, 1.3, -7.0]), yaw, pitch, roll)
    dx, dy, dz = camera.rays(0, 40)
    points = camera.position + 20 * np.stack([dx, dy, dz], axis=2).astype(np.float64)
    pixels = camera.project(points)
    v, u = np.mgrid[0:40, 0:64] + 0.5
    assert np.abs(pixels[..., 0] - u).max() < 1e-3
    assert np.abs(pixels[..., 1] - v).max() < 1e-3
    assert np.allclose(camera.axes @ camera.axes.T, np.eye(3), atol=1e-12)


def test_senses_of_rotation() -> None:
    ahead = np.array([0.0, 1.3, 50.0])
    still = look(1280, 720, 1000.0, np.array([0, 1.3, 0]), 0, 0, 0).project(ahead)
    right = look(1280, 720, 1000.0, np.array([0, 1.3, 0]), 0.1, 0, 0).project(ahead)
    up = look(1280, 720, 1000.0, np.array([0, 1.3, 0]), 0, 0.1, 0).project(ahead)
    assert right[0] < still[0]
    assert up[1] > still[1]
    aside = np.array([10.0, 1.3, 50.0])
    lean = look(1280, 720, 1000.0, np.array([0, 1.3, 0]), 0, 0, 0.1).project(aside)
    assert lean[1] < still[1]


def test_a_bump_shakes_and_dies_away() -> None:
    calm = Shake(np.random.default_rng(0), 0.0, [(1.0, 1.0)])
    assert np.abs(calm.at(0.9)).max() == 0
    assert abs(calm.at(1.07)[0]) > 0.006
    assert np.abs(calm.at(4.0)).max() < 1e-4
