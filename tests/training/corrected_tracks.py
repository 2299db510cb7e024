"""Corrected tracks over drawn pictures."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from tests.training.toy_scenes import backdrop, draw_sign
from tsr_engine.exchange.dataset import DatasetVideo, Track
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene


def make_track(
    uid: str = "m1", frames: int = 20, first: int = 0, side: float = 20.0, grow: float = 1.0, **given: Any
) -> Track:
    """A sign that grows and moves right."""
    sides = side + grow * np.arange(frames)
    x, y = 60.0 + np.arange(frames), 50.0
    boxes = np.stack([x, np.full(frames, y), x + sides, y + sides], axis=1)
    values: dict[str, Any] = {
        "uid": uid, "label": 2, "frames": first + np.arange(frames), "boxes": boxes, "key": np.ones(frames, bool),
        "occluded": np.zeros(frames, bool), "score": np.full(frames, 0.9), "state": "accepted",
    }  # fmt: skip
    return Track(**(values | given))


def make_video(tracks: list[Track], path: Path | None = None, frames: int = 40, name: str = "toy.mp4") -> DatasetVideo:
    return DatasetVideo(name, "", 260, 200, frames, Fraction(25), None, True, lambda: iter(tracks), path, 0, frames)


def write_video(path: Path, tracks: list[Track], frames: int = 40, kind: int = 0) -> Path:
    """A video that shows the tracks."""
    ground = backdrop(np.random.default_rng(5), 200, 260)
    with VideoWriter(path, 260, 200, Fraction(25)) as writer:
        for k in range(frames):
            picture = ground.copy()
            for each in tracks:
                for box in each.boxes[each.frames == k]:
                    draw_sign(picture, (box[0] + box[2]) / 2, (box[1] + box[3]) / 2, box[2] - box[0], kind)
            writer.write(picture)
    return path


def draw_corrected_scenes(folder: Path, seeds: range, kind: int = 0, label: int = 14) -> list[CorrectedScene]:
    """Scenes with one drawn sign and tight boxes; every scene is from a video of its own."""
    out = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        picture = backdrop(rng, 200, 260)
        side = float(rng.uniform(24, 48))
        cx, cy = rng.uniform(60, 200), rng.uniform(60, 140)
        draw_sign(picture, cx, cy, side, kind)
        path = folder / f"{seed}.png"
        cv2.imwrite(str(path), picture)
        box = np.array([[cx - side / 2, cy - side / 2, cx + side / 2, cy + side / 2]])
        out.append(CorrectedScene(Scene(path.name, path, box, np.array([label])), f"v{seed}", (f"v{seed}/1",)))
    return out
