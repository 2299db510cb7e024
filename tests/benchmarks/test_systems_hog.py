"""The HOG cascade: its histograms, its scan against a plain loop, and a training on drawn scenes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from benchmarks.systems import hog_training
from benchmarks.systems.hog import BINS, integral, orientation_cells, patch_cells
from benchmarks.systems.hog_blocks import FEATURES, RECTS, WINDOW, window_bytes
from benchmarks.systems.hog_cascade import HogCascade, HogCascadeDetector, merged
from benchmarks.systems.hog_scan import HogLevel, levels, scales_of, scan
from benchmarks.systems.hog_training import HogPlan, train_hog_cascade
from tests.benchmarks.drawn_scenes import SIZE, drawn_scenes
from tsr_engine.detection.trees import NEVER, TreeEnsemble
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.pictures import read_picture
from tsr_engine.params.detector import DetectorParams
from tsr_engine.protocols import OfflineDetector
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.public.mining import MIN_WIDTH


def _ensemble(trees: int, seed: int = 0) -> TreeEnsemble:
    rng = np.random.default_rng(seed)
    return TreeEnsemble(
        rng.integers(0, FEATURES, (trees, 3)).astype(np.int32),
        rng.integers(5, 60, (trees, 3)).astype(np.uint8),
        rng.integers(-200, 200, (trees, 4)).astype(np.int16),
        np.full(trees, NEVER, np.int32),
        WINDOW.cells,
    )


@pytest.mark.parametrize(("turned", "orientation"), [(False, 0), (True, 4)])
def test_an_edge_votes_for_its_own_orientation(turned: bool, orientation: int) -> None:
    grey = np.zeros((8, 8), np.uint8)
    grey[:, 4:] = 100
    cells = orientation_cells(grey.T.copy() if turned else grey, 4)
    total = cells[:BINS].sum(axis=(1, 2))
    assert total.sum() == cells[BINS].sum() == 2 * 16 * 100  # two pixels a row see the step, votes are doubled
    # upright edges fall into bin 0; level ones, at 90 degrees, half and half into 80 and 100
    expected = {orientation, orientation + 1} if turned else {orientation}
    assert set(np.flatnonzero(total)) == expected


def test_patches_do_not_depend_on_their_neighbours() -> None:
    rng = np.random.default_rng(1)
    patches = rng.integers(0, 255, (3, 12, 12, 3)).astype(np.uint8)
    for patch, cells in zip(patches, patch_cells(patches, 6), strict=True):
        np.testing.assert_array_equal(cells, orientation_cells(patch, 6))


def test_invalid_pictures_are_refused() -> None:
    with pytest.raises(ValueError, match="at least 4 px"):
        orientation_cells(np.zeros((3, 9), np.uint8), 4)


def test_integral_planes_hold_the_sums() -> None:
    cells = np.random.default_rng(2).integers(0, 1000, (10, 7, 9)).astype(np.int32)
    planes = integral(cells)
    assert planes[3, 5, 8] - planes[3, 2, 8] - planes[3, 5, 1] + planes[3, 2, 1] == cells[3, 2:5, 1:8].sum()


def test_features_are_shares_of_their_block() -> None:
    rng = np.random.default_rng(3)
    planes = integral(orientation_cells(rng.integers(0, 255, (28, 28)).astype(np.uint8), WINDOW.shrink))
    first = np.zeros(1, np.int64)
    row = window_bytes(planes, first, first)[0].astype(float)
    assert (RECTS.block >= 0).all()
    assert (RECTS.block <= WINDOW.cells).all()
    of_block = row[:36].sum() / 900  # the 36 features of one block sum to its whole gradient
    assert of_block == pytest.approx(1.0, abs=36 / 900 + 0.01)


@pytest.mark.parametrize("floor", [NEVER, -150])
def test_the_scan_equals_a_plain_loop(floor: int) -> None:
    picture = np.random.default_rng(4).integers(0, 255, (60, 76, 3)).astype(np.uint8)
    cascade = _ensemble(20).with_rejection(np.full(20, floor, np.int32))
    for level in levels(picture, [1.0, 0.8]):
        down, across = level.windows
        y, x = (g.ravel() for g in np.mgrid[0:down, 0:across])
        sums = cascade.partial_sums(window_bytes(level.planes, y, x))
        alive = (sums[:, 5:] >= floor).all(axis=1)  # the first six trees are evaluated together
        rows, columns, scores = scan(level, cascade)
        np.testing.assert_array_equal(np.stack([rows, columns, scores]), np.stack([y, x, sums[:, -1]])[:, alive])


def test_trees_of_another_depth_are_refused() -> None:
    level = HogLevel(0, np.zeros((10, 20, 20), np.int32), 1.0, 1.0)
    nodes, leaves = np.zeros((1, 7), np.int32), np.zeros((1, 8), np.int16)
    deep = TreeEnsemble(nodes, nodes.astype(np.uint8), leaves, np.zeros(1, np.int32), WINDOW.cells)
    with pytest.raises(ValueError, match="depth 2"):
        scan(level, deep)


def test_windows_around_a_sign_are_averaged() -> None:
    boxes = np.array([[10.0, 10, 30, 30], [12, 10, 32, 30], [80, 80, 100, 100]])
    out = merged(boxes, np.array([2.0, 2.0, 1.0]), boxes[[0, 2]])
    np.testing.assert_allclose(out, [[11, 10, 31, 30], [80, 80, 100, 100]])


def test_levels_outside_the_size_range_are_skipped(tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    scene = drawn_scenes(tmp_path, 1)[0]
    every = scales_of(*SIZE, MIN_WIDTH)
    requests: list[int] = []

    def few(picture: Picture, scales: FloatArray) -> Iterator[HogLevel]:
        requests.append(len(scales))
        return levels(picture, scales)

    monkeypatch.setattr(hog_training, "levels", few)
    found = hog_training.windows_on_signs(scene)
    monkeypatch.setattr(hog_training, "levels", lambda picture, _: levels(picture, every))
    assert requests[0] < len(every)
    assert len(found) == len(scene.boxes)
    for windows, same in zip(found, hog_training.windows_on_signs(scene), strict=True):
        np.testing.assert_array_equal(windows, same)


def test_a_trained_cascade_finds_a_sign_it_has_not_seen(tmp_path) -> None:  # type: ignore[no-untyped-def]
    scenes = drawn_scenes(tmp_path, 9)
    plan = HogPlan(rounds=(12, 40), mining_share=(0.5,), jittered=8, random_per_scene=150, per_scene=20, slack=4.0)
    model, record = train_hog_cascade(scenes[:6], scenes[6:8], [], 0, lambda _: None, plan)
    assert record["signs"] == 18
    again = HogCascade.from_arrays(*model.to_arrays())
    detector = HogCascadeDetector(again, DetectorParams(keep_score=-20.0, far_top=0.0, far_bottom=1.0))
    assert isinstance(detector, OfflineDetector)
    found = detector.detect(read_picture(scenes[8].path))
    assert (np.diff(found.scores) <= 0).all()
    assert (iou(found.boxes[:6], scenes[8].boxes).max(axis=0) >= 0.5).sum() >= 2  # of three
