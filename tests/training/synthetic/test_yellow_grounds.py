"""Yellow backgrounds in training views: only the sign's background, in a share of the views, of signs that have one."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.training.synthetic.drawn_signs import EMPTY
from tsr_engine.training.synthetic.yellow_grounds import EMPTY_RING_FACTOR, GROUNDED, sometimes_yellow, yellow_ground

BOX = np.array([40.0, 30.0, 120.0, 110.0])
RED, WHITE, BLACK, SKY = (40, 30, 190), (230, 230, 230), (30, 30, 30), (240, 235, 225)
GIVE_WAY, DANGER, KEEP_RIGHT = 13, 18, 38


def disc(light: float = 1.0) -> np.ndarray:
    """A red ring with a white ground and a black bar, before a bright sky."""
    picture = np.full((140, 160, 3), SKY, np.uint8)
    cv2.circle(picture, (80, 70), 38, RED, -1, cv2.LINE_AA)
    cv2.circle(picture, (80, 70), 29, WHITE, -1, cv2.LINE_AA)
    cv2.rectangle(picture, (74, 55), (86, 85), BLACK, -1)
    return (picture * light).astype(np.uint8)


def triangle(inverted: bool) -> np.ndarray:
    picture = np.full((140, 160, 3), SKY, np.uint8)
    for ink, share in ((RED, 0.96), (WHITE, 0.6)):
        middle = np.array([80, 70 + 40 / 3])
        points = middle + share * (np.array([[40.0, 110], [120, 110], [80, 30]]) - middle)
        cv2.fillPoly(picture, [np.round(points).astype(np.int32)], ink, cv2.LINE_AA)
    return picture[::-1].copy() if inverted else picture


@pytest.mark.parametrize("light", [1.0, 0.3])
def test_only_the_background_turns_yellow(light: float) -> None:
    white = disc(light)
    for seed in range(20):
        yellow = yellow_ground(white, BOX, EMPTY, np.random.default_rng(seed))
        blue, green, red = yellow[70, 62].astype(float) / white[70, 62]
        assert blue < 0.7
        assert blue < green < 1
        assert red > 0.9
        for y, x in ((70, 46), (70, 80), (35, 45), (5, 5), (70, 121)):
            assert np.abs(yellow[y, x].astype(int) - white[y, x]).max() <= 12 * light
    assert np.array_equal(white, disc(light))


@pytest.mark.parametrize(("class_id", "inverted", "middle"), [(GIVE_WAY, True, 57), (DANGER, False, 83)])
def test_corners_outside_a_triangle_are_unchanged(class_id: int, inverted: bool, middle: int) -> None:
    white = triangle(inverted)
    yellow = yellow_ground(white, BOX, class_id, np.random.default_rng(0))
    assert yellow[middle, 80, 0] < 0.7 * white[middle, 80, 0]
    changed = np.abs(yellow.astype(int) - white).max(axis=2) > 12
    sky = (white == SKY).all(axis=2)
    assert not (changed & sky).any()


def test_blue_signs_and_signs_without_contrast_are_unchanged() -> None:
    rng = np.random.default_rng(0)
    assert KEEP_RIGHT not in GROUNDED
    assert yellow_ground(disc(), BOX, KEEP_RIGHT, rng) is not None
    assert np.array_equal(yellow_ground(disc(), BOX, KEEP_RIGHT, rng), disc())
    night = disc(0.05)
    assert np.array_equal(yellow_ground(night, BOX, EMPTY, rng), night)


def test_a_sign_at_the_edge_of_the_picture_is_painted_as_well() -> None:
    cut = disc()[:, 70:]
    yellow = yellow_ground(cut, BOX - [70, 0, 70, 0], EMPTY, np.random.default_rng(0))
    assert yellow.shape == cut.shape
    assert (yellow[70, 25] < cut[70, 25]).any()


def test_shares_of_yellow_views() -> None:
    rng = np.random.default_rng(0)

    def painted(class_id: int, share: float) -> int:
        white = disc()
        return sum(sometimes_yellow(white, BOX, class_id, share, rng) is not white for _ in range(400))

    assert painted(1, 0.0) == painted(-1, 1.0) == painted(KEEP_RIGHT, 1.0) == 0
    assert 20 <= painted(1, 0.1) <= 60
    assert painted(EMPTY, 1 / EMPTY_RING_FACTOR) == 400
    assert 85 <= painted(EMPTY, 0.1) <= 155
