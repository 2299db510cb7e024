"""Takes windows for the cascade's training from the same pyramid as in detection."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.compute import CHANNELS
from tsr_engine.channels.pyramid import Level, PyramidPlan, build_pyramid, level_scales
from tsr_engine.detection.nms import suppress
from tsr_engine.detection.scan import prepare, scan_level
from tsr_engine.detection.trees import UNIT, TreeEnsemble
from tsr_engine.detection.window import Window
from tsr_engine.detection.window_merging import merge_windows
from tsr_engine.geometry.boxes import area, iou
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.parallel import map_on_cores
from tsr_engine.training.synthetic.augment import other_camera, relight, soften

MIN_WIDTH = 16.0
"""Narrowest sign of the training pyramids, px."""
MAX_ALIGNED = 4
"""Largest number of scan windows on one sign in one level."""
DENSE_TREES = 24
"""Number of trees that a scan evaluates for every window."""
MAX_PASSED = 3000
"""Largest number of windows of one level that a scan returns; the best are taken."""
SIGN_OVERLAP = 0.35
"""A window with a lower overlap (IoU) with every sign is background."""


@dataclass(frozen=True, slots=True)
class PictureChanges:
    """Probabilities of changing a scene's picture before background is searched in it.

    Attributes:
        relit: another light, with compression in half of the cases.
        other_camera: as taken by another camera.
    """

    relit: float
    other_camera: float = 0.0


UNCHANGED: Final = PictureChanges(0.0)


def searched_picture(scene: Scene, rng: np.random.Generator, changed: PictureChanges) -> Picture:
    """The scene's picture for the search of background, unchanged or changed by one of ``changed``.

    Near darkness, strong compression and sharpening make sign-like blocks of road and sky that are missing in daylight
    scenes.
    """
    picture = read_picture(scene.path)
    drawn = rng.random()
    if drawn < changed.relit:
        picture = relight(picture, rng)
        return soften(picture, rng) if rng.random() < 0.5 else picture
    return other_camera(picture, rng) if drawn < changed.relit + changed.other_camera else picture


@dataclass(frozen=True, slots=True)
class CascadeScan:
    """A cascade with the window and the pyramid that it scans."""

    cascade: TreeEnsemble
    window: Window
    pyramid: PyramidPlan


def levels(picture: Picture, window: Window, plan: PyramidPlan) -> Iterator[Level]:
    """Levels of a picture for signs from ``MIN_WIDTH`` px."""
    scales = level_scales(window.sign / MIN_WIDTH, window.side / min(picture.shape[:2]), plan.per_octave)
    return build_pyramid(picture, scales, plan, border=window.pad)


def background_windows(
    scenes: Sequence[Scene],
    window: Window,
    plan: PyramidPlan,
    per_scene: int,
    rng: np.random.Generator,
    progress: Progress,
) -> NDArray[np.uint8]:
    """Random windows without a sign, spread over the levels by their size; shape (n, features)."""

    def drawn(scene: Scene, own: np.random.Generator) -> list[NDArray[np.uint8]]:
        taken = []
        found = list(levels(read_picture(scene.path), window, plan))
        sizes = [level.cells.shape[1] * level.cells.shape[2] for level in found]
        for level, size in zip(found, sizes, strict=True):
            ny, nx = (n - window.cells + 1 for n in level.cells.shape[1:])
            if ny < 1 or nx < 1:
                continue
            count = max(1, round(per_scene * size / sum(sizes)))
            y, x = own.integers(0, ny, count), own.integers(0, nx, count)
            clear = away_from_signs(window.to_boxes(y, x, level), scene.occupied)
            if clear.any():
                taken.append(window.gather(y[clear], x[clear], level))
        return taken

    found = map_on_cores(drawn, scenes, rng, progress, "random background")
    return np.concatenate([windows for taken in found for windows in taken])


def best_overlap(boxes: FloatArray, others: FloatArray) -> FloatArray:
    """Largest overlap (IoU) of each box with any other, in [0, 1], shape (n,); 0 without others."""
    return np.asarray(iou(boxes, others).max(axis=1, initial=0.0))


def away_from_signs(boxes: FloatArray, signs: FloatArray, overlap: float = SIGN_OVERLAP) -> NDArray[np.bool_]:
    """Which boxes overlap every sign by less than ``overlap`` (IoU); shape (n,)."""
    return np.asarray(best_overlap(boxes, signs) < overlap)


def aligned_windows(scene: Scene, window: Window, plan: PyramidPlan) -> NDArray[np.uint8]:
    """Windows of the scan on the scene's signs, including approximated levels; shape (n, features)."""
    out = [np.zeros((0, CHANNELS * window.cells**2), np.uint8)]
    for level in levels(read_picture(scene.path), window, plan):
        ny, nx = (n - window.cells + 1 for n in level.cells.shape[1:])
        for box in scene.boxes:
            if abs(np.log(window.sign / level.scale_x / np.sqrt(area(box)))) > 0.12:
                continue
            half = window.side / 2
            col = ((box[0] + box[2]) / 2 * level.scale_x - half) / window.shrink + window.pad
            row = ((box[1] + box[3]) / 2 * level.scale_y - half) / window.shrink + window.pad
            y, x = (g.ravel() for g in np.mgrid[int(row) - 1 : int(row) + 3, int(col) - 1 : int(col) + 3])
            inside = (y >= 0) & (y < ny) & (x >= 0) & (x < nx)
            y, x = y[inside], x[inside]
            overlap = iou(window.to_boxes(y, x, level), box[None])[:, 0]
            best = np.argsort(-overlap, kind="stable")[:MAX_ALIGNED]
            best = best[overlap[best] > 0.72]
            if len(best):
                out.append(window.gather(y[best], x[best], level))
    return np.concatenate(out)


def scan_scene(
    picture: Picture, scan: CascadeScan
) -> tuple[FloatArray, FloatArray, NDArray[np.int64], dict[int, Level]]:
    """All windows of a picture that pass a cascade.

    Returns:
        Boxes (n, 4), scores (n,), and per window its level, row and column (n, 3); the levels by index.
    """
    boxes, scores, places, kept = [np.zeros((0, 4))], [np.zeros(0)], [np.zeros((0, 3), np.int64)], {}
    for level in levels(picture, scan.window, scan.pyramid):
        nodes = prepare(scan.cascade, level.cells.shape[1], level.cells.shape[2], level.gains)
        y, x, score = scan_level(level.cells, scan.cascade, min(DENSE_TREES, len(scan.cascade)), nodes)
        if not len(y):
            continue
        if len(y) > MAX_PASSED:
            best = np.sort(np.argpartition(-score, MAX_PASSED)[:MAX_PASSED])
            y, x, score = y[best], x[best], score[best]
        kept[level.index] = level
        boxes.append(scan.window.to_boxes(y, x, level))
        scores.append(score / UNIT)
        places.append(np.stack([np.full(len(y), level.index), y, x], axis=1))
    return np.concatenate(boxes), np.concatenate(scores), np.concatenate(places), kept


def hard_windows(
    scenes: Sequence[Scene],
    scan: CascadeScan,
    per_scene: int,
    rng: np.random.Generator,
    changed: PictureChanges,
    progress: Progress,
) -> NDArray[np.uint8]:
    """The background windows with a cascade's highest scores after suppression; shape (n, features).

    A share of the scenes is changed by ``changed`` (:func:`searched_picture`).
    """

    def hardest(scene: Scene, own: np.random.Generator) -> list[NDArray[np.uint8]]:
        boxes, scores, places, kept = scan_scene(searched_picture(scene, own, changed), scan)
        clear = away_from_signs(boxes, scene.occupied)
        boxes, scores, places = boxes[clear], scores[clear], places[clear]
        chosen = places[suppress(boxes, scores, 0.6, per_scene)]
        taken = []
        for index in np.unique(chosen[:, 0]):
            level = kept[int(index)]
            picked = chosen[chosen[:, 0] == index]
            taken.append(scan.window.gather(picked[:, 1], picked[:, 2], level))
        return taken

    found = map_on_cores(hardest, scenes, rng, progress, "hard background")
    none = np.zeros((0, CHANNELS * scan.window.cells**2), np.uint8)
    return np.concatenate([none, *(windows for taken in found for windows in taken)])


def background_candidates(
    scenes: Sequence[Scene],
    scan: CascadeScan,
    most: int,
    again: float,
    changed: PictureChanges,
    rng: np.random.Generator,
    progress: Progress,
) -> Iterator[tuple[Scene, Picture, FloatArray]]:
    """Windows away from signs that pass a cascade, by scene; a share of the scenes is searched again with changes.

    Args:
        scenes: where to search.
        scan: the cascade.
        most: largest number of candidates per scene; the best are taken.
        again: share of scenes that are searched a second time.
        changed: changes in the second search.
        rng: source of that choice and of the changes.
        progress: progress.

    Yields:
        Scene, picture as searched, and candidates (n, 4); scenes without candidates are skipped.
    """
    views = [(scene, UNCHANGED) for scene in scenes]
    views += [(scenes[int(i)], changed) for i in np.flatnonzero(rng.random(len(scenes)) < again)]

    def searched(view: tuple[Scene, PictureChanges], own: np.random.Generator) -> tuple[Scene, Picture, FloatArray]:
        scene, picture = view[0], searched_picture(view[0], own, view[1])
        boxes, scores, _, _ = scan_scene(picture, scan)
        clear = away_from_signs(boxes, scene.occupied)
        boxes, _ = merge_windows(boxes[clear], scores[clear], 0.6, most)
        return scene, picture, boxes

    for found in map_on_cores(searched, views, rng, progress, "background candidates"):
        if len(found[2]):
            yield found
