"""Offline samples: balanced, reproducible, from drawn scenes."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from tsr_engine.errors import InputError
from tsr_engine.io.gtsdb import Scene
from tsr_engine.training.public.online_samples import train_online


def drawn_scenes(folder: Path) -> list[Scene]:
    rng = np.random.default_rng(0)
    scenes = []
    for k in range(4):
        picture = cv2.GaussianBlur(rng.integers(0, 255, (150, 220, 3), dtype=np.uint8), (0, 0), 3)
        cv2.circle(picture, (60 + 10 * k, 70), 15, (40, 40, 220), -1)
        path = folder / f"{k}.png"
        assert cv2.imwrite(str(path), picture)
        box = np.array([[45.0 + 10 * k, 55.0, 76.0 + 10 * k, 86.0]])
        scenes.append(Scene(path.name, path, box, np.array([k % 2])))
    return scenes


def test_samples_are_balanced_and_reproducible(tmp_path: Path) -> None:
    scenes = drawn_scenes(tmp_path)
    one, two, other = (train_online(scenes, seed, positives=6) for seed in (1, 1, 2))
    assert one.arrays["X"].shape == (12, 324)
    assert one.arrays["X"].dtype == np.float32
    assert one.arrays["y"].tolist() == [1, -1] * 6
    assert one.arrays["X"].tobytes() == two.arrays["X"].tobytes()
    assert one.arrays["X"].tobytes() != other.arrays["X"].tobytes()
    assert one.seed == 1


@pytest.mark.timeout(60)
def test_a_sign_that_fills_its_scene_gives_no_sample(tmp_path: Path) -> None:
    """No background window of its size exists; samples of other signs are unchanged."""
    scenes = drawn_scenes(tmp_path)
    full = Scene("full", scenes[0].path, np.array([[0.0, 0.0, 220.0, 150.0]]), np.array([5]))
    found = train_online([*scenes, full], 1, positives=12)
    assert found.arrays["y"].tolist() == [1, -1] * (len(found.arrays["y"]) // 2)
    assert 8 <= len(found.arrays["y"]) // 2 < 12
    assert found.data["samples"] == len(found.arrays["y"])
    shifts = [np.array([220 * x, 150 * y] * 2) for x in np.arange(-1, 1.1, 0.2) for y in np.arange(-1, 1.1, 0.2)]
    crowded = Scene("crowded", full.path, full.boxes, full.class_ids, np.array([full.boxes[0] + s for s in shifts]))
    with pytest.raises(InputError, match="room beside their signs, got 1 that"):
        train_online([crowded], 1, positives=2)


def test_a_region_to_ignore_gives_no_sample(tmp_path: Path) -> None:
    scene = drawn_scenes(tmp_path)[0]
    marked = Scene("marked", scene.path, scene.boxes, scene.class_ids, np.array([[0.0, 0.0, 220.0, 150.0]]))
    with pytest.raises(InputError, match="room beside their signs, got 1 that"):
        train_online([marked], 1, positives=2)


def test_scenes_without_signs_are_refused(tmp_path: Path) -> None:
    empty = Scene("a.png", tmp_path / "a.png", np.zeros((0, 4)), np.zeros(0, dtype=np.int64))
    with pytest.raises(InputError, match="Expected scenes with signs"):
        train_online([empty])
