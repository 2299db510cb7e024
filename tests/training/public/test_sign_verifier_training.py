"""Training of the sign verifier score and its weights, on drawn shapes."""

import cv2
import numpy as np
import pytest

from tsr_engine.recognition.crops import cut
from tsr_engine.training.public.candidates import fit_calibration
from tsr_engine.training.public.classifier_network import NetworkSettings, _hinge
from tsr_engine.training.public.sign_verifier import SignVerifierPlan, train_sign_verifier
from tsr_engine.training.synthetic.classifier_augmentation import BACKGROUND, MAX_CROP_PX, LoadedCrop, surrounded_crop

BOX = np.array([20.0, 20, 60, 60])


def disc(bar: str, shade: int) -> np.ndarray:
    """A red disc with a vertical, a horizontal or no bar: equal outlines, different contents."""
    picture = np.full((80, 80, 3), 90 + shade, np.uint8)
    cv2.circle(picture, (40, 40), 20, (40, 40, 190), -1, cv2.LINE_AA)
    if bar:
        x, y = (4, 14) if bar == "upright" else (14, 4)
        cv2.rectangle(picture, (40 - x, 40 - y), (40 + x, 40 + y), (250, 250, 250), -1)
    return picture


def crops(bar: str, class_id: int, count: int = 12) -> list[LoadedCrop]:
    return [surrounded_crop(disc(bar, 4 * k), BOX, class_id) for k in range(count)]


@pytest.mark.parametrize(("from_scenes", "common"), [(False, False), (True, False), (False, True)])
def test_signs_differ_from_shapes_with_their_outline(from_scenes: bool, common: bool) -> None:
    signs = crops("upright", 5) + crops("lying", 9)
    network = NetworkSettings(filters=12, hidden=24, warm_up=20, common=common)
    plan = SignVerifierPlan(steps=160, batch=48, drawn_crops=8, rings=8, yellow=0, network=network)
    first, second = ([], signs) if from_scenes else (signs, [])
    reported: list[int] = []
    sign_verifier = train_sign_verifier(
        first,
        second,
        crops("", BACKGROUND),
        plan,
        np.random.default_rng(1),
        lambda what, done, of: reported.append(done),
    )
    assert reported[-1] == 160
    upright, lying, bare = (sign_verifier.scores(disc(bar, 50), BOX[None])[0] for bar in ("upright", "lying", ""))
    assert min(upright, lying) > bare + 0.5
    margins = sign_verifier.machines.margins([cut(disc("lying", 50), BOX, sign_verifier.machines.margin)])
    assert margins[0].argmax() == 9


def test_background_matches_no_class() -> None:
    margins = np.zeros((2, 43))
    loss, slope = _hinge(margins, np.array([BACKGROUND, 7]))
    assert loss == pytest.approx(43.0)
    assert (slope[0] > 0).all()
    assert (slope[1] < 0).nonzero()[0].tolist() == [7]


def test_a_common_machine_covers_every_class() -> None:
    loss, slope = _hinge(np.zeros((2, 44)), np.array([BACKGROUND, 7]))
    assert loss == pytest.approx(44.0)
    assert (slope[0] > 0).all()
    assert (slope[1] < 0).nonzero()[0].tolist() == [7, 43]
    with pytest.raises(ValueError, match="needs the loss 'hinge'"):
        NetworkSettings(common=True, loss="cross_entropy")


def test_large_crops_are_downscaled_with_their_box() -> None:
    picture = np.zeros((400, 400, 3), np.uint8)
    crop = surrounded_crop(picture, np.array([100.0, 120, 260, 250]), 3)
    assert crop.box[2] - crop.box[0] == pytest.approx(MAX_CROP_PX, abs=1)
    assert crop.pixels.shape[1] == pytest.approx(2 * MAX_CROP_PX, abs=4)
    at_edge = surrounded_crop(picture, np.array([-5.0, 380, 25, 410]), 3)
    assert at_edge.box.tolist() == [-5.0, at_edge.box[1], 25.0, at_edge.box[1] + 30]


def test_the_regression_finds_the_weights_and_refuses_negative_ones() -> None:
    rng = np.random.default_rng(3)
    scores = rng.normal(0, 1, (6000, 3))
    odds = scores @ [1.5, 0.0, 0.7] - 0.5

    def drawn(odds: np.ndarray) -> np.ndarray:
        return np.where(rng.random(6000) < 1 / (1 + np.exp(-odds)), 1.0, -1.0)

    np.testing.assert_allclose(fit_calibration(scores[:, [0, 2]], drawn(odds), 0.0), [1.5, 0.7, -0.5], atol=0.12)
    against = fit_calibration(scores, drawn(odds - 0.8 * scores[:, 1]), 0.0)
    assert against[1] == 0.0, "a score is never held against a candidate"
