"""Painting from far to near, and the visible share of a sign."""

from __future__ import annotations

import numpy as np
import pytest

from sample_videos.linear_canvas import LinearCanvas, motion_blur_kernel


def _patch(h: int, w: int, alpha: float, colour: float = 1.0) -> np.ndarray:
    patch = np.zeros((h, w, 4), np.float32)
    patch[..., :3] = colour * alpha
    patch[..., 3] = alpha
    return patch


def test_nearer_objects_reduce_visibility() -> None:
    film = LinearCanvas(40, 30)
    face = _patch(10, 10, 1.0, 0.2)
    film.blend(face, 5, 5)
    film.watch(7, face[..., 3], 5, 5, 100.0)
    assert film.watched[0].visibility() == 1.0
    film.blend(_patch(10, 5, 1.0), 10, 5)
    assert film.watched[0].visibility() == pytest.approx(0.5)
    film.blend(_patch(10, 5, 0.4), 5, 5)
    assert film.watched[0].visibility() == pytest.approx(0.3)
    assert film.image[7, 12] == pytest.approx(1.0)
    assert film.image[7, 6] == pytest.approx(0.2 * 0.6 + 0.4)


def test_areas_outside_the_picture_are_not_visible() -> None:
    film = LinearCanvas(40, 30)
    face = _patch(10, 10, 1.0)
    film.blend(face, 36, -5)
    film.watch(1, face[..., 3], 36, -5, 100.0)
    assert film.watched[0].visibility() == pytest.approx(0.2)


def test_a_streak_keeps_its_brightness_and_follows_the_motion() -> None:
    assert motion_blur_kernel(0.5, 0.5) is None
    kernel = motion_blur_kernel(9.0, 0.0)
    assert kernel is not None
    assert kernel.sum() == pytest.approx(1.0)
    rows, columns = np.flatnonzero(kernel.sum(1) > 0.01), np.flatnonzero(kernel.sum(0) > 0.01)
    assert len(columns) >= 9
    assert len(rows) <= 3


def test_blur_spreads_a_patch_without_loss() -> None:
    film = LinearCanvas(60, 40)
    film.blend(_patch(6, 6, 1.0), 20, 20, motion_blur_kernel(8.0, 0.0))
    assert film.image[..., 0].sum() == pytest.approx(36.0, rel=1e-3)
    assert film.image[23, 17, 0] > 0.05
