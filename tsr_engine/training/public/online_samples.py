"""Draws the offline samples of the online detector: its data before a track's first frame (section III-D.1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from tsr_engine.errors import InputError
from tsr_engine.evidence.regions import FramePixels
from tsr_engine.geometry.boxes import covered_share, iou, to_cxcywh, to_xyxy
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.models import Component
from tsr_engine.io.pictures import read_picture
from tsr_engine.online.features import describe
from tsr_engine.records import FloatArray

__all__ = ["train_online"]

TRIES: Final = 1000
"""Number of windows tried for a negative sample; a scene with any room needs a few."""
MAX_OVERLAP: Final = 0.4
"""Largest IoU of a negative sample with a sign, and largest share of it in an ignored region."""


def train_online(scenes: Sequence[Scene], seed: int = 0, positives: int = 50) -> Component:
    """Draw balanced offline samples from annotated scenes.

    Signs are drawn evenly over their classes. Each gives one positive sample, its box, and one negative sample,
    alternately a window shifted off the sign by 0.4 to 1 sides and a random one of the same scene. A sign that
    fills its scene leaves no room for a random window, and gives neither.

    Args:
        scenes: scenes with at least one sign among them.
        seed: seed of the random choices.
        positives: largest number of positive samples, and of negative ones.

    Returns:
        Component ``online`` with arrays ``X`` (2 * positives, 324) float32 and ``y`` (2 * positives,) int8.

    Raises:
        InputError: there are no signs, none leaves room for a window beside it, or a picture cannot be read.
    """
    rng = np.random.default_rng(seed)
    signs = [(s, k) for s, scene in enumerate(scenes) for k in range(len(scene.boxes))]
    if not signs:
        raise InputError("Expected scenes with signs to draw offline samples from, got none. Name annotated scenes.")
    chosen = _balanced([int(scenes[s].class_ids[k]) for s, k in signs], positives, rng)
    vectors, labels = [], []
    for number, index in enumerate(chosen):
        s, k = signs[index]
        pixels = FramePixels(read_picture(scenes[s].path))
        box = scenes[s].boxes[k]
        window = _negative(box, scenes[s], pixels.width, pixels.height, number % 2 == 0, rng)
        if window is None:
            continue
        vectors += [describe(pixels, box), describe(pixels, window)]
        labels += [1, -1]
    if not labels:
        raise InputError(
            f"Expected scenes with room beside their signs, got {len(scenes)} that are filled by them. "
            "Name annotated scenes that show more than a sign."
        )
    return Component(
        "online",
        {"X": np.asarray(vectors, dtype=np.float32), "y": np.asarray(labels, dtype=np.int8)},
        params={"descriptor": "luv+6 orientations, 6x6 cells of 4 px, unit length"},
        data={"scenes": len(scenes), "signs": len(signs), "samples": len(labels)},
        seed=seed,
    )


def _balanced(classes: Sequence[int], count: int, rng: np.random.Generator) -> list[int]:
    """Indices drawn in rounds with one of each class; signs repeat only after all of a class were drawn."""
    queues = {c: list(rng.permutation([k for k, other in enumerate(classes) if other == c])) for c in set(classes)}
    chosen: list[int] = []
    while len(chosen) < count:
        for c in rng.permutation(sorted(queues)):
            queue = queues[int(c)]
            chosen.append(int(queue[0]))
            queues[int(c)] = [*queue[1:], queue[0]]
    return chosen[:count]


def _negative(
    box: FloatArray, scene: Scene, width: int, height: int, near: bool, rng: np.random.Generator
) -> FloatArray | None:
    """A window of the sign's size, away from signs and ignored regions; None: none was found."""
    cx, cy, w, h = to_cxcywh(box)
    for _ in range(TRIES):
        if near:
            angle, distance = rng.uniform(0, 2 * np.pi), rng.uniform(0.4, 1.0)
            centre = (cx + distance * w * np.cos(angle), cy + distance * h * np.sin(angle))
        else:
            centre = (rng.uniform(w / 2, width - w / 2), rng.uniform(h / 2, height - h / 2))
        window = to_xyxy(np.array([*centre, w, h]))
        is_clear = float(iou(window, scene.occupied).max()) <= MAX_OVERLAP
        if is_clear and covered_share(window, scene.ignored)[0] <= MAX_OVERLAP:
            return window
    return None
