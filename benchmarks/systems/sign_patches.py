"""Training patches of signs, with the jitter, light and loss of detail of the ACF detector's training."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tsr_engine.detection.patch import cut_patch
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.gtsrb import CropItem, tracks_of
from tsr_engine.io.gtsrb import read_picture as read_crop
from tsr_engine.io.pictures import read_picture
from tsr_engine.records import Picture
from tsr_engine.training.public.crop_windows import over_background
from tsr_engine.training.public.patches import PATCH, jitter
from tsr_engine.training.synthetic.augment import relight, soften


@dataclass(frozen=True, slots=True)
class SignPatch:
    """A patch with a sign in its middle.

    Attributes:
        picture: BGR, ``PATCH`` px a side.
        class_id: in 0..42.
    """

    picture: Picture
    class_id: int


def scene_patches(scenes: Sequence[Scene], count: int, sign: float, rng: np.random.Generator) -> Iterator[SignPatch]:
    """Patches of every annotated sign.

    Args:
        scenes: annotated scenes.
        count: number of patches per sign; the first keeps its light and detail.
        sign: side of the sign in the patch, px.
        rng: random generator.
    """
    for scene in scenes:
        if not len(scene.boxes):
            continue
        picture = read_picture(scene.path)
        for box, class_id in zip(scene.boxes, scene.class_ids.tolist(), strict=True):
            for number in range(count):
                patch = cut_patch(picture, jitter(box, rng, 0.045, 0.06), sign, PATCH)
                yield SignPatch(_varied(patch, rng, 0.5 if number else 0.0, 0.3 if number else 0.0), class_id)


def crop_patches(
    crops: Sequence[CropItem], scenes: Sequence[Scene], frames: int, sign: float, rng: np.random.Generator
) -> Iterator[SignPatch]:
    """Patches of a few frames of every GTSRB track over pieces of scenes.

    Args:
        crops: items with region of interest, class and track.
        scenes: scenes for the backgrounds.
        frames: number of patches per track.
        sign: side of the sign in the patch, px.
        rng: random generator.
    """
    backgrounds = [read_picture(scenes[i].path) for i in rng.permutation(len(scenes))[:12]]
    for _, items in sorted(tracks_of(crops).items()):
        for i in rng.choice(len(items), min(frames, len(items)), replace=False):
            item = items[i]
            if item.roi is None or item.class_id is None:
                continue
            backdrop = backgrounds[rng.integers(len(backgrounds))]
            patch = over_background(read_crop(item), np.array(item.roi, np.float64), backdrop, sign, rng)
            yield SignPatch(_varied(patch, rng, 0.4, 0.25), item.class_id)


def _varied(patch: Picture, rng: np.random.Generator, relit: float, softened: float) -> Picture:
    """Change light and detail with these probabilities, and mirror half of the patches."""
    if rng.random() < relit:
        patch = relight(patch, rng)
    if rng.random() < softened:
        patch = soften(patch, rng)
    return np.ascontiguousarray(patch[:, ::-1]) if rng.random() < 0.5 else patch
