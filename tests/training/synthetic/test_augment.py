"""Simulated cameras and shadows on signs keep the size, are reproducible, and change the right area."""

from __future__ import annotations

import numpy as np

from tsr_engine.training.synthetic.augment import other_camera, shade

BOX = np.array([60.0, 40.0, 100.0, 80.0])


def picture() -> np.ndarray:
    return np.random.default_rng(0).integers(30, 220, (120, 200, 3), dtype=np.uint8)


def test_the_seed_decides_the_camera() -> None:
    taken = picture()
    seen = [other_camera(taken, np.random.default_rng(seed)) for seed in range(12)]
    assert all(one.shape == taken.shape and one.dtype == np.uint8 for one in seen)
    assert np.array_equal(seen[3], other_camera(taken, np.random.default_rng(3)))
    assert sum(not np.array_equal(one, taken) for one in seen) >= 10
    assert len({one.tobytes() for one in seen}) >= 10
    assert np.array_equal(taken, picture())


def test_a_shadow_darkens_only_a_part_of_the_sign() -> None:
    taken = np.full((240, 300, 3), 200, np.uint8)
    box = BOX + 60
    partly = 0
    for seed in range(40):
        shaded = shade(taken, box, np.random.default_rng(seed))
        assert (shaded <= taken).all()
        x1, y1, x2, y2 = box.astype(int)
        far = np.ones(taken.shape[:2], bool)
        far[y1 - 61 : y2 + 61, x1 - 61 : x2 + 61] = False
        assert (shaded[far] == 200).all()
        dark = (shaded[y1:y2, x1:x2, 0] < 160).mean()
        partly += 0.02 < dark < 0.98
    assert partly >= 30


def test_a_sign_at_the_edge_of_the_picture_is_shaded_as_well() -> None:
    taken = picture()
    for seed in range(10):
        assert shade(taken, np.array([-10.0, -5.0, 25.0, 30.0]), np.random.default_rng(seed)).shape == taken.shape
