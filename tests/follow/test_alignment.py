"""Templates are aligned to a fraction of a pixel, in changed light and with a part covered."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tests.follow.synthetic_drives import draw_backdrop
from tsr_engine.follow.alignment import align
from tsr_engine.follow.confidence import WEIGHTS, Evidence
from tsr_engine.follow.template import LEVELS, Template, level_below, size_of


def moved_template(scale: float, dx: float, dy: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A region, a template of it at half the scene's size, and the true position of the template."""
    scene = cv2.resize(draw_backdrop(4), None, fx=0.4, fy=0.4, interpolation=cv2.INTER_AREA).astype(np.float32)[
        :200, :200
    ]
    template = np.ascontiguousarray(scene[80:112, 80:112])
    matrix = np.array([[scale, 0.0, dx], [0.0, scale, dy]])
    region = cv2.warpAffine(scene, matrix, (240, 240), flags=cv2.INTER_LINEAR)
    return region, template, np.array([95.5 * scale + dx, 95.5 * scale + dy, scale])


@pytest.mark.parametrize("scale", [0.92, 1.0, 1.07])
@pytest.mark.parametrize("light", [(1.0, 0.0), (0.5, 20.0), (1.4, -10.0)])
def test_position_and_scale_are_found(scale: float, light: tuple[float, float]) -> None:
    region, template, truth = moved_template(scale, 12.3, 9.8)
    lit = np.ascontiguousarray(region * light[0] + light[1])
    found = align(lit, template, np.ones((32, 32), np.float32), truth + np.array([1.4, -1.2, -0.05]))
    assert found[:2] == pytest.approx(truth[:2], abs=0.15)
    assert found[2] == pytest.approx(truth[2], rel=0.01)
    assert found[3] > 0.97


def test_a_covered_part_has_little_weight() -> None:
    region, template, truth = moved_template(1.0, 10.0, 10.0)
    x, y = (round(v) for v in truth[:2])
    region[y + 10 : y + 20, x - 20 : x + 20] = 130.0
    found = align(region, template, np.ones((32, 32), np.float32), truth + np.array([1.0, 1.0, 0.03]))
    assert found[:2] == pytest.approx(truth[:2], abs=0.3)
    assert found[2] == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("shape", [(40.0, 40.0), (90.0, 30.0), (31.0, 77.0)])
def test_a_template_is_centred(level: float, shape: tuple[float, float]) -> None:
    picture = np.zeros((300, 300, 3), np.uint8)
    x1, y1 = 120.0, 110.0
    x2, y2 = x1 + shape[0], y1 + shape[1]
    picture[int(y1) : int(y2), int(x1) : int(x2)] = 200
    box = np.array([x1, y1, x2, y2])
    pixels, weights = Template.cut(picture, box, 0.0, True).at_level(level)
    h, w = weights.shape
    assert (h - w) % 2 == 0
    mass = pixels[..., 0] / pixels[..., 0].sum()
    assert float((mass.sum(axis=0) * np.arange(w)).sum()) == pytest.approx((w - 1) / 2, abs=0.15)
    assert float((mass.sum(axis=1) * np.arange(h)).sum()) == pytest.approx((h - 1) / 2, abs=0.15)
    assert float(pixels[..., 0].sum()) / 200 == pytest.approx(level**2, rel=0.2)
    assert size_of(box) == pytest.approx(np.sqrt(shape[0] * shape[1]))


def test_pixels_beyond_the_picture_have_no_weight() -> None:
    picture = np.full((100, 100, 3), 90, np.uint8)
    _, weights = Template.cut(picture, np.array([-10.0, 40.0, 10.0, 60.0]), 0.0, True).at_level(16.0)
    half = weights.shape[1] // 2
    assert weights[:, : half - 1].max() == 0.0
    assert weights[:, half + 1 :].max() == 1.0


def test_the_level_below_a_size_is_found() -> None:
    assert level_below(3.0) == LEVELS[0]
    assert level_below(16.5) == 16.0
    assert level_below(500.0) == LEVELS[-1]


def test_confidence_rises_with_the_evidence() -> None:
    poor = Evidence(0.3, 0.2, 4.0, 4.0, -1.0, None)
    good = Evidence(0.95, 0.9, 0.5, 0.3, 1.2, None)
    known = Evidence(0.95, 0.9, 0.5, 0.3, 1.2, 6.0)
    assert poor.confidence < 0.1 < 0.9 < good.confidence < known.confidence < 1.0
    assert set(good.terms()) == set(WEIGHTS)
