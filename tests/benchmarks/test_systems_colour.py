"""Colour probability model, proposals and HOG SVM, on drawn scenes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.systems.colour_model import COLOURS, fit_colours, ohta
from benchmarks.systems.colour_mser import ColourMser, ColourMserDetector
from benchmarks.systems.colour_mser_training import SvmPlan, train_colour_mser
from benchmarks.systems.hog_svm import FAMILIES, LENGTH, describe_boxes
from benchmarks.systems.proposals import ProposalPlan, propose
from tests.benchmarks.drawn_scenes import drawn_scenes
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.gtsdb import CLASSES, Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.params.detector import DetectorParams
from tsr_engine.protocols import OfflineDetector

ANYWHERE = DetectorParams(keep_score=-20.0, far_top=0.0, far_bottom=1.0)


def test_light_and_shade_cancel() -> None:
    bright = np.array([[40, 60, 240]], np.uint8)
    np.testing.assert_allclose(ohta(bright // 2), ohta(bright), atol=0.06)
    np.testing.assert_allclose(ohta(np.array([[90, 90, 90]], np.uint8)), 0)


def test_every_class_has_one_colour_family() -> None:
    assert sorted(c for classes in FAMILIES.values() for c in classes) == list(range(CLASSES))
    coloured = set().union(*COLOURS.values())
    assert set(range(CLASSES)) - coloured == {6, 32, 41, 42}


def test_colours_are_learned_from_boxes_alone(tmp_path: Path) -> None:
    model = fit_colours(drawn_scenes(tmp_path, 6), np.random.default_rng(0))
    pixels = np.array([[[40, 30, 190], [170, 80, 20], [20, 180, 230], [100, 100, 100], [235, 235, 235]]], np.uint8)
    maps = model.maps(pixels)[:, 0]
    assert maps.shape == (3, 5)
    for colour in range(3):
        assert maps[colour, colour] > 200
        assert (np.delete(maps[colour], colour) < 60).all()


def test_a_colour_without_signs_is_named(tmp_path: Path) -> None:
    scenes = [Scene(s.name, s.path, s.boxes[:2], s.class_ids[:2]) for s in drawn_scenes(tmp_path, 2)]
    with pytest.raises(ValueError, match="yellow"):
        fit_colours(scenes, np.random.default_rng(0))


def test_signs_are_proposed(tmp_path: Path) -> None:
    scenes = drawn_scenes(tmp_path, 4)
    model = fit_colours(scenes, np.random.default_rng(0))
    for scene in scenes:
        found = propose(read_picture(scene.path), model, ProposalPlan(), ANYWHERE)
        assert (iou(scene.boxes, found.boxes).max(axis=1) >= 0.6).all()


def test_an_empty_picture_proposes_nothing(tmp_path: Path) -> None:
    model = fit_colours(drawn_scenes(tmp_path, 2), np.random.default_rng(0))
    assert len(propose(np.full((60, 80, 3), 90, np.uint8), model, ProposalPlan(), ANYWHERE).boxes) == 0
    assert describe_boxes(np.zeros((9, 9, 3), np.uint8), np.zeros((3, 9, 9), np.uint8), np.zeros((0, 4))).shape == (
        0,
        LENGTH,
    )


def test_boxes_beyond_the_picture_have_descriptors(tmp_path: Path) -> None:
    picture = np.random.default_rng(0).integers(0, 255, (60, 80, 3)).astype(np.uint8)
    maps = np.zeros((3, 60, 80), np.uint8)
    rows = describe_boxes(picture, maps, np.array([[-6.0, -4, 20, 22], [60, 40, 84, 66], [10, 10, 34, 34]]))
    assert rows.shape == (3, LENGTH)
    assert np.isfinite(rows).all()
    assert 0 <= rows.min() <= rows.max() <= 0.3 + 1e-6


def test_a_trained_system_finds_signs_it_has_not_seen(tmp_path: Path) -> None:
    scenes = drawn_scenes(tmp_path, 9)
    model, record = train_colour_mser(scenes[:6], scenes[6:8], [], 0, lambda _: None, SvmPlan(searched=1.0, relit=0.0))
    assert record["calibration_proposal_recall"] == 1.0
    again = ColourMser.from_arrays(*model.to_arrays())
    detector = ColourMserDetector(again, ANYWHERE)
    assert isinstance(detector, OfflineDetector)
    found = detector.detect(read_picture(scenes[8].path))
    assert (iou(found.boxes[:5], scenes[8].boxes).max(axis=0) >= 0.5).all()
