"""Converts GTSRB crops to training windows of the detector.

A crop's border is a tenth of the sign, but the detector's filters need more. So the crop is blended into a random part
of a scene of similar brightness, with a soft edge across its border.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.detection.patch import cut_patch
from tsr_engine.detection.window import Window
from tsr_engine.geometry.boxes import area, to_cxcywh
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.gtsrb import CropItem, read_picture, tracks_of
from tsr_engine.io.pictures import read_picture as read_scene
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.patches import PATCH, jitter, window_features
from tsr_engine.training.synthetic.augment import relight, soften
from tsr_engine.training.synthetic.yellow_grounds import sometimes_yellow


def crop_windows(
    crops: Sequence[CropItem],
    scenes: Sequence[Scene],
    window: Window,
    frames: int,
    rng: np.random.Generator,
    progress: Progress,
    yellow: float = 0.0,
) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """Windows from a few frames of every track.

    Args:
        crops: GTSRB items with region of interest, class and track.
        scenes: where backgrounds come from.
        window: the detector's window.
        frames: windows a track.
        rng: randomness.
        progress: progress.
        yellow: share of the windows with a yellow ground, of signs that have one.

    Returns:
        Features (n, features), uint8, and class ids (n,).
    """
    backgrounds = [read_scene(scenes[i].path) for i in rng.permutation(len(scenes))[:12]]
    features, classes = [], []
    tracks = tracks_of(crops)
    for number, (_, items) in enumerate(sorted(tracks.items())):
        progress("crops", number, len(tracks))
        for i in rng.choice(len(items), min(frames, len(items)), replace=False):
            item = items[i]
            if item.roi is None or item.class_id is None:
                continue
            backdrop = backgrounds[rng.integers(len(backgrounds))]
            box = np.array(item.roi, np.float64)
            crop = sometimes_yellow(read_picture(item), box, item.class_id, yellow, rng)
            patch = over_background(crop, box, backdrop, window.sign, rng)
            if rng.random() < 0.4:
                patch = relight(patch, rng)
            if rng.random() < 0.25:
                patch = soften(patch, rng)
            if rng.random() < 0.5:
                patch = np.ascontiguousarray(patch[:, ::-1])
            features.append(window_features(patch, window))
            classes.append(item.class_id)
    return np.stack(features), np.array(classes, np.int64)


def over_background(crop: Picture, box: FloatArray, scene: Picture, sign: float, rng: np.random.Generator) -> Picture:
    """A patch with the crop's sign, jittered, in the middle of a piece of a scene, soft-edged; BGR uint8."""
    target = jitter(box, rng, 0.04, 0.06)
    front = cut_patch(crop, target, sign, PATCH)
    side = float(rng.uniform(20, 60))
    x, y = rng.uniform(0, scene.shape[1] - side), rng.uniform(0, scene.shape[0] - side)
    back = cut_patch(scene, np.array([x, y, x + side, y + side]), sign, PATCH).astype(np.float32)
    scale = sign / np.sqrt(area(target))
    cx, cy, _, _ = to_cxcywh(target)
    low_x, high_x = PATCH / 2 - cx * scale, PATCH / 2 + (crop.shape[1] - cx) * scale
    low_y, high_y = PATCH / 2 - cy * scale, PATCH / 2 + (crop.shape[0] - cy) * scale
    grid = np.arange(PATCH) + 0.5
    inside_x = np.clip(np.minimum(grid - low_x, high_x - grid) / 1.5, 0, 1)
    inside_y = np.clip(np.minimum(grid - low_y, high_y - grid) / 1.5, 0, 1)
    alpha = np.outer(inside_y, inside_x).astype(np.float32)[..., None]
    border = front[(alpha[..., 0] > 0.5) & (alpha[..., 0] < 1)]
    if len(border):  # the backdrop takes the brightness that the crop has at its rim
        back *= np.clip(border.mean() / max(1.0, back.mean()), 0.2, 4.0)
    mixed = alpha * front + (1 - alpha) * np.clip(back, 0, 255)
    return np.asarray(cv2.convertScaleAbs(mixed), dtype=np.uint8)
