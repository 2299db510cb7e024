"""The online detector on drawn pictures: search, detection, learning and forgetting."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.evidence.regions import FramePixels, StoredPixels
from tsr_engine.geometry.boxes import expand, non_overlap
from tsr_engine.online.features import (
    CELLS,
    FEATURES,
    PAD,
    cell_maps,
    describe,
    describe_with_neighbours,
    descriptor_at,
    make_grid,
    pixel_extent,
    score_windows,
)
from tsr_engine.online.incremental_svm import IncrementalSVC
from tsr_engine.online.online_detector import OnlineDetector, OnlineDetectorMaker
from tsr_engine.online.relocalisation import relocalise, search_extent
from tsr_engine.params.online import OnlineParams
from tsr_engine.records import FloatArray, Picture


def scene(cx: float, cy: float, side: float, seed: int = 0) -> tuple[Picture, FloatArray]:
    """A red-rimmed disc on smooth noise, and its box."""
    rng = np.random.default_rng(seed)
    picture = cv2.GaussianBlur(rng.integers(0, 255, (200, 260, 3), dtype=np.uint8), (0, 0), 4)
    centre, radius = (round(cx * 16 - 8), round(cy * 16 - 8)), round(side * 8)
    cv2.circle(picture, centre, radius, (40, 40, 200), -1, cv2.LINE_AA, 4)
    cv2.circle(picture, centre, round(radius * 0.7), (235, 235, 235), -1, cv2.LINE_AA, 4)
    return np.ascontiguousarray(picture, dtype=np.uint8), np.array(
        [cx - side / 2, cy - side / 2, cx + side / 2, cy + side / 2]
    )


def offline_samples() -> tuple[FloatArray, list[int]]:
    vectors, labels = [], []
    for seed in range(6):
        picture, box = scene(90 + seed, 80, 30, seed)
        pixels = FramePixels(picture)
        vectors += [describe(pixels, box), describe(pixels, box + np.array([40, 30, 40, 30]))]
        labels += [1, -1]
    return np.array(vectors), labels


def make_detector(params: OnlineParams) -> tuple[OnlineDetector, FloatArray]:
    picture, box = scene(120, 100, 30, seed=20)
    X, y = offline_samples()
    detector, samples = OnlineDetectorMaker(X, y, params)(FramePixels(picture), box, 0)
    assert len(samples) == len(detector.svm.y_) == len(detector.samples)
    return detector, box


def test_descriptor_has_unit_length_and_is_deterministic() -> None:
    picture, box = scene(120, 100, 30)
    one = describe(FramePixels(picture), box)
    assert one.shape == (FEATURES,) == (324,)
    assert np.linalg.norm(one) == pytest.approx(1.0)
    assert one.tobytes() == describe(FramePixels(picture.copy()), box).tobytes()


def test_the_response_of_each_window_is_the_svm_of_its_descriptor() -> None:
    picture, box = scene(120, 100, 24)
    X, y = offline_samples()
    svm = IncrementalSVC(C=1.0).partial_fit(X, y)
    place = make_grid(box, 12)
    x1, y1, x2, y2 = pixel_extent(place.extent)
    maps = cell_maps(FramePixels(picture).crop(x1, y1, x2, y2), (x1, y1), place)
    out = np.empty((2 * place.reach[1] + 1, 2 * place.reach[0] + 1), dtype=np.float32)
    score_windows(maps, svm.coef_.reshape(9, CELLS, CELLS).astype(np.float32), svm.intercept_, PAD, out)
    slow = np.array(
        [
            [svm.decision_function(descriptor_at(maps, row, column)[None])[0] for column in range(out.shape[1])]
            for row in range(out.shape[0])
        ]
    )
    np.testing.assert_allclose(out, slow, atol=1e-5)


@pytest.mark.parametrize("side", [16.0, 33.0, 70.0])
def test_windows_cover_the_radius_and_no_more(side: float) -> None:
    place = make_grid(np.array([50.0, 60.0, 50.0 + side, 60.0 + side]), 20)
    first, last = place.box(0, 0), place.box(2 * place.reach[0], 2 * place.reach[1])
    middle = place.box(*map(float, place.reach))
    np.testing.assert_allclose(middle, [50, 60, 50 + side, 60 + side])
    for corner in (first, last):
        moved = np.abs(corner - middle)
        assert (moved <= 20 + 1e-9).all()
        assert (moved > 20 - place.pitch.max()).all()


@pytest.mark.parametrize("scales", [(1.0,), (0.93, 1.0, 1.07)])
@pytest.mark.parametrize(("dx", "dy"), [(0, 0), (14, -9), (-17, 16)])
def test_finds_the_sign_beside_the_prediction(dx: float, dy: float, scales: tuple[float, ...]) -> None:
    detector, _ = make_detector(OnlineParams(search_scales=scales))
    picture, truth = scene(126.4, 97.2, 31, seed=21)
    found = detector.relocalise(FramePixels(picture), truth + np.array([dx, dy, dx, dy]))
    assert found is not None
    assert non_overlap(found.box, truth)[0, 0] < 0.15
    assert found.probability == pytest.approx(1 / (1 + np.exp(-found.decision)))
    assert found.runner_up_decision < found.decision
    assert found.windows > 300


def test_a_size_is_found_only_where_several_are_searched() -> None:
    picture, truth = scene(126.4, 97.2, 31, seed=21)
    wrong = expand(truth, 0.5 * (1 / 1.15 - 1))
    sides = {}
    for scales in ((1.0,), (1.0, 1.15)):
        detector, _ = make_detector(OnlineParams(search_scales=scales))
        found = detector.relocalise(FramePixels(picture), wrong)
        assert found is not None
        sides[scales] = found.box[2:] - found.box[:2]
    np.testing.assert_allclose(sides[1.0,], wrong[2:] - wrong[:2])
    np.testing.assert_allclose(sides[1.0, 1.15], truth[2:] - truth[:2])


@pytest.mark.parametrize("scales", [(1.0,), (0.93, 1.0, 1.07)])
def test_live_and_stored_pixels_give_the_same_bits(scales: tuple[float, ...]) -> None:
    params = OnlineParams(search_scales=scales)
    detector, _ = make_detector(params)
    picture, box = scene(12, 20, 30, seed=3)  # partly beyond the frame's edge
    live = FramePixels(picture)
    one = relocalise(live, box, detector.svm, params)
    regions = live.regions()
    assert len(regions) == 1
    x1, y1, x2, y2 = search_extent(box, params)
    assert (regions[0].x, regions[0].y) == (max(0, x1), max(0, y1))
    assert regions[0].pixels.shape[:2] == (min(200, y2) - max(0, y1), min(260, x2) - max(0, x1))
    two = relocalise(StoredPixels(260, 200, regions), box, detector.svm, params)
    assert one.box.tobytes() == two.box.tobytes()
    assert (one.decision, one.runner_up_decision) == (two.decision, two.runner_up_decision)


def test_the_extent_grows_with_the_radius() -> None:
    box = np.array([100.0, 100.0, 130.0, 130.0])
    small, large = search_extent(box, OnlineParams()), search_extent(box, OnlineParams(search_radius=40))
    assert large[0] < small[0] < 80
    assert large[3] > small[3] > 150


def test_samples_are_learned_and_unlearned_with_age() -> None:
    params = OnlineParams(sample_age=3, background_negatives=4, learn_rejected=True)
    detector, box = make_detector(params)
    offline = 12
    assert [s.origin for s in detector.samples[offline:]] == ["result"] + ["background"] * 4
    for frame in range(1, 8):
        picture, box = scene(120 + frame, 100, 30, seed=20 + frame)
        label = 1 if frame % 2 else -1
        changes = detector.learn(FramePixels(picture), box, label, frame)
        learned = [s for s in changes if s.transform == "learned"]
        assert [s.label for s in learned] == ([1, -1, -1, -1, -1] if label > 0 else [-1])
        assert all(s.frame < frame - 3 for s in changes if s.transform == "unlearned")
        assert [s.label for s in detector.samples] == detector.svm.y_.tolist()
        assert detector.svm.kkt_residual() <= 1e-8
    assert min(s.frame for s in detector.samples if s.frame >= 0) == 4
    assert sum(s.origin == "offline" for s in detector.samples) == offline


def test_without_learn_rejected_a_negative_has_no_effect() -> None:
    detector, box = make_detector(OnlineParams(learn_rejected=False))
    before = detector.svm.alpha_.tobytes()
    picture, _ = scene(120, 100, 30)
    assert detector.learn(FramePixels(picture), box, -1, 1) == ()
    assert detector.svm.alpha_.tobytes() == before


def test_tracks_do_not_share_their_model() -> None:
    X, y = offline_samples()
    maker = OnlineDetectorMaker(X, y, OnlineParams())
    picture, box = scene(120, 100, 30)
    one, _ = maker(FramePixels(picture), box, 0)
    two, _ = maker(FramePixels(picture), box, 0)
    one.learn(FramePixels(picture), box, 1, 1)
    assert len(one.svm.y_) > len(two.svm.y_)


def test_boxes_without_area_are_not_searched() -> None:
    detector, _ = make_detector(OnlineParams())
    picture, _ = scene(120, 100, 30)
    bad = np.array([10.0, 10.0, 10.0, 12.0])
    assert detector.relocalise(FramePixels(picture), bad) is None
    assert detector.learn(FramePixels(picture), np.full(4, np.nan), 1, 1) == ()
    with pytest.raises(ValueError, match="at least 1x1 px"):
        describe(FramePixels(picture), bad)


def test_positions_of_windows_around_a_box() -> None:
    picture, box = scene(120, 100, 24)
    vectors, boxes = describe_with_neighbours(FramePixels(picture), box, [(6, 0), (0, -12)])
    assert vectors.shape == (3, FEATURES)
    pitch = make_grid(box, 0).pitch[0]
    np.testing.assert_allclose(boxes[0] - box, [6 * pitch, 0, 6 * pitch, 0], atol=1e-9)
    np.testing.assert_allclose(boxes[1] - box, [0, -12 * pitch, 0, -12 * pitch], atol=1e-9)


def test_offline_samples_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match=r"shape \(m, 324\)"):
        OnlineDetectorMaker(np.zeros((3, 10)), [1, -1, 1], OnlineParams())
