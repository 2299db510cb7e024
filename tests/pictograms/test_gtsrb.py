"""The drawn signs are complete and distinct, and their silhouettes match the outlines."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.pictograms.gtsrb import N_CLASSES, drawing, nominal_width, outline


def draw(class_id: int, size: int) -> np.ndarray:
    return drawing(class_id).picture(size)


@pytest.fixture(scope="module")
def small() -> np.ndarray:
    """All signs at 48 pixels over grey, (43, 48, 48, 3) float."""
    out = []
    for class_id in range(N_CLASSES):
        picture = draw(class_id, 48).astype(float)
        alpha = picture[..., 3:] / 255
        out.append(picture[..., :3] * alpha + 128 * (1 - alpha))
    return np.array(out)


def test_every_pair_of_classes_differs_visibly(small: np.ndarray) -> None:
    flat = small.reshape(N_CLASSES, -1)
    for k in range(N_CLASSES):
        apart = np.abs(flat - flat[k]).mean(1)
        apart[k] = np.inf
        assert apart.min() > 1.5, (k, int(apart.argmin()), apart.min())


@pytest.mark.parametrize("class_id", range(N_CLASSES))
def test_silhouette_is_the_outline(class_id: int) -> None:
    size = 96
    alpha = draw(class_id, size)[..., 3] / 255
    polygon = (outline(class_id) + 1) * size / 2
    assert alpha.sum() == pytest.approx(cv2.contourArea(polygon.astype(np.float32)), rel=0.02)
    rows, columns = np.flatnonzero(alpha.max(1) > 0.5), np.flatnonzero(alpha.max(0) > 0.5)
    assert columns[0] == pytest.approx(polygon[:, 0].min(), abs=1)
    assert columns[-1] + 1 == pytest.approx(polygon[:, 0].max(), abs=1)
    assert rows[0] == pytest.approx(polygon[:, 1].min(), abs=1)
    assert rows[-1] + 1 == pytest.approx(polygon[:, 1].max(), abs=1)


def test_families_have_their_colours(small: np.ndarray) -> None:
    def middle_of_rim(class_id: int) -> np.ndarray:
        picture = draw(class_id, 200)[..., :3].astype(int)
        return np.asarray(picture[100, 17])

    for class_id in (0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 15, 16, 17):
        b, g, r = middle_of_rim(class_id)
        assert r > 150
        assert max(b, g) < 80
    for class_id in (33, 34, 35, 36, 37, 38, 39, 40):
        b, g, r = middle_of_rim(class_id)
        assert b > 120
        assert r < 60
    b, g, r = draw(12, 200)[100, 100, :3].astype(int)
    assert r > 200
    assert g > 150
    assert b < 80
    assert small.std() > 0


def test_left_and_right_are_mirrors() -> None:
    for left, right in ((34, 33), (39, 38), (37, 36), (19, 20)):
        mirrored = draw(left, 64)[:, ::-1].astype(int)
        assert np.abs(mirrored - draw(right, 64)).mean() < 1.0


def test_any_resolution() -> None:
    for size in (1, 7, 20, 333):
        assert draw(14, size).shape == (size, size, 4)
    coarse = cv2.resize(draw(2, 320), (40, 40), interpolation=cv2.INTER_AREA)[10:30, 10:30].astype(int)
    assert np.abs(coarse - draw(2, 40)[10:30, 10:30]).mean() < 6


@pytest.mark.parametrize("class_id", [-1, 43])
def test_unknown_class_is_refused(class_id: int) -> None:
    with pytest.raises(ValueError, match="class_id must be within 0 to 42"):
        outline(class_id)
    with pytest.raises(ValueError, match="class_id"):
        drawing(class_id)


def test_empty_picture_is_refused() -> None:
    with pytest.raises(ValueError, match="size must be at least 1"):
        draw(3, 0)


def test_true_sizes() -> None:
    for class_id in range(N_CLASSES):
        assert 0.6 <= nominal_width(class_id) <= 0.9
