from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tsr_engine.errors import InputError
from tsr_engine.io.gtsrb import CropItem, read_items
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.descriptor import LENGTH, SIDE
from tsr_engine.training.public.classifier import (
    ClassifierSettings,
    _views,
    train_classifier,
)
from tsr_engine.training.public.classifier_network import Network, NetworkSettings, _cross_entropy, _hinge
from tsr_engine.training.synthetic.classifier_augmentation import (
    LoadedCrop,
    box_view,
    jittered_view,
    load_crop,
    plain_view,
    shaken_box,
    view_strength,
)
from tsr_engine.training.synthetic.drawn_signs import DRAWN_CLASSES, drawn_crops
from tsr_engine.training.synthetic.inset_signs import inset_crops


def glyph(class_id: int, shade: int) -> np.ndarray:
    """A disc whose colour and large blocks encode the class."""
    picture = np.full((40, 40, 3), 60 + shade, np.uint8)
    colour = [(40, 40, 190), (190, 60, 40), (40, 170, 170), (90, 90, 90)][class_id % 4]
    cv2.circle(picture, (20, 20), 15, colour, -1, cv2.LINE_AA)
    for bit in range(4):
        if class_id // 4 >> bit & 1:
            x, y = 10 + 11 * (bit % 2), 10 + 11 * (bit // 2)
            cv2.rectangle(picture, (x, y), (x + 8, y + 8), (250, 250, 250), -1)
    return picture


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("gtsrb")
    for c in range(43):
        place = root / f"{c:05d}"
        place.mkdir()
        rows = ["Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2;ClassId"]
        for track in range(4):
            rows.append(f"{track:05d}_00000.png;40;40;5;5;35;35;{c}")
            assert cv2.imwrite(str(place / f"{track:05d}_00000.png"), glyph(c, 20 * track))
        (place / f"GT-{c:05d}.csv").write_text("\n".join(rows) + "\n")
    return root


SMALL = ClassifierSettings(
    drawn=0.0, steps=160, batch=48, refit_steps=5, network=NetworkSettings(filters=16, hidden=48, rate=4e-3, warm_up=5)
)


def test_training_reduces_the_error(folder: Path) -> None:
    stages: list[tuple[str, int, int]] = []
    trained = train_classifier(folder, 5, SMALL, lambda *report: stages.append(report))
    assert trained.figures["accuracy"] > 0.25  # of 43 classes; chance is 0.02
    assert trained.figures["crops"] == 43
    assert trained.data["held_out_tracks"] == 43
    assert {stage for stage, _, _ in stages} == {
        "read training pictures",
        "read held-out pictures",
        "train on the split",
        "train on all tracks",
    }
    assert stages[-1][1] == stages[-1][2]
    answers = SignClassifier.from_component(trained).probabilities([glyph(c, 30)[2:38, 2:38] for c in range(43)])
    assert (answers.argmax(1) == np.arange(43)).mean() > 0.25


def test_training_is_reproducible(folder: Path) -> None:
    short = replace(SMALL, steps=6, refit_steps=3)
    first, again, other = (train_classifier(folder, seed, short) for seed in (1, 1, 2))
    assert (first.figures, first.params) == (again.figures, again.params)
    for key, array in first.arrays.items():
        np.testing.assert_array_equal(array, again.arrays[key])
    assert not np.array_equal(first.arrays["hidden"], other.arrays["hidden"])


def test_a_missing_class_is_named(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "00003").symlink_to(folder / "00003")
    with pytest.raises(InputError, match="found none of class 0, 1, 2, 4"):
        train_classifier(tmp_path)


class TestNetwork:
    settings = NetworkSettings(filters=3, hidden=5, drop_hidden=0.0)

    @pytest.mark.parametrize("loss", [_hinge, _cross_entropy])
    def test_slopes_are_the_finite_differences(self, loss: object) -> None:
        assert callable(loss)
        generator = np.random.default_rng(0)
        margins = generator.normal(0, 1, (3, 43)).astype(np.float64)
        labels = np.array([0, 42, 7])
        _, slope = loss(margins, labels)
        for i, j in ((0, 0), (1, 5), (2, 7)):
            step = np.zeros_like(margins)
            step[i, j] = 1e-5
            difference = (loss(margins + step, labels)[0] - loss(margins - step, labels)[0]) / 2e-5
            assert slope[i, j] == pytest.approx(difference, abs=1e-5)

    def test_every_weight_follows_its_gradient(self) -> None:
        # Adam's first step moves each weight by the step size against the gradient's sign.
        generator = np.random.default_rng(1)
        x = generator.random((4, LENGTH), dtype=np.float32)
        labels = np.array([1, 2, 3, 4])

        def loss(weights: dict[str, np.ndarray]) -> float:
            probe = Network(self.settings, 0)
            probe.weights = {key: value.copy() for key, value in weights.items()}
            return probe.train_step(x, labels, 0.0)

        start = Network(self.settings, 0)
        before = {key: value.copy() for key, value in start.weights.items()}
        start.settings = NetworkSettings(filters=3, hidden=5, drop_hidden=0.0, decay=0.0, warm_up=1)
        start.train_step(x, labels, 0.0)
        checked = 0
        for key in before:
            moved = start.weights[key] - before[key]
            for index in (0, before[key].size // 2):
                h = 1e-2
                up, down = ({k: v.copy() for k, v in before.items()} for _ in range(2))
                up[key].flat[index] += h
                down[key].flat[index] -= h
                slope = (loss(up) - loss(down)) / (2 * h)
                if abs(slope) > 1e-3:
                    assert np.sign(moved.flat[index]) == -np.sign(slope)
                    checked += 1
        assert checked >= 6

    def test_weights_have_the_variance_of_he(self) -> None:
        w = Network(NetworkSettings(), 0).weights["hidden"]
        assert w.std() == pytest.approx(np.sqrt(2 / len(w)), rel=0.01)


def test_augmentation_weakens_at_the_end() -> None:
    assert [view_strength(p, 0.5, 0.4) for p in (0.0, 0.5, 0.75, 1.0, 1.1)] == pytest.approx([1, 1, 0.7, 0.4, 0.4])
    assert view_strength(1.0, 0.0, 0.4) == 1


class TestViews:
    def crop(self, class_id: int = 2) -> LoadedCrop:
        return LoadedCrop(glyph(class_id, 0), np.array([5.0, 5, 35, 35]), class_id)

    def test_the_plain_view_is_the_resized_crop(self) -> None:
        expected = cv2.resize(glyph(2, 0)[2:38, 2:38], (SIDE, SIDE), interpolation=cv2.INTER_LINEAR)
        inner = slice(2, -2)
        difference = np.abs(plain_view(self.crop())[inner, inner].astype(int) - expected[inner, inner])
        assert difference.max() <= 2

    def test_a_shifted_box_shows_shifted_pixels(self) -> None:
        ramp = np.repeat(np.arange(0, 240, 4, dtype=np.uint8)[None, :, None], 60, axis=0).repeat(3, axis=2)
        crop = LoadedCrop(ramp, np.array([10.0, 10, 40, 40]), 1)
        shift = box_view(crop, crop.box + np.array([2.0, 0, 2, 0]))[:, :, 0].astype(int) - plain_view(crop)[:, :, 0]
        assert abs(shift - 8).max() <= 1

    def test_shaken_boxes_stay_within_their_limits(self) -> None:
        generator = np.random.default_rng(0)
        for _ in range(200):
            x1, y1, x2, y2 = shaken_box(np.array([0.0, 0, 100, 100]), generator)
            assert max(abs((x1 + x2) / 2 - 50), abs((y1 + y2) / 2 - 50)) <= 11.001
            assert 82 < x2 - x1 < 119
        np.testing.assert_allclose(shaken_box(np.array([1.0, 2, 31, 42]), generator, 0.0), [1, 2, 31, 42])

    def test_views_are_drawn_from_the_generator_alone(self) -> None:
        one, two = (
            [jittered_view(self.crop(), generator)[0] for _ in range(20)]
            for generator in (np.random.default_rng(9), np.random.default_rng(9))
        )
        np.testing.assert_array_equal(one, two)
        assert len({v.tobytes() for v in one}) == 20

    def test_views_of_no_strength_keep_the_box_and_the_sharpness(self) -> None:
        # Only light and a small rotation remain, so edges stay as steep as in the crop.
        def steepness(strength: float) -> float:
            generator = np.random.default_rng(4)
            views = [jittered_view(self.crop(), generator, strength)[0] for _ in range(200)]
            return float(np.mean([cv2.Laplacian(v, cv2.CV_32F).std() / max(v.std(), 1) for v in views]))

        assert steepness(0.0) > 1.1 * steepness(1.0)

    def test_mirror_images_change_the_class(self) -> None:
        generator = np.random.default_rng(0)
        assert {jittered_view(self.crop(38), generator)[1] for _ in range(40)} == {38, 39}
        assert {jittered_view(self.crop(2), generator)[1] for _ in range(40)} == {2}
        assert {jittered_view(self.crop(38), generator, unseen=(39,))[1] for _ in range(40)} == {38}

    def test_large_signs_are_downscaled(self, tmp_path: Path) -> None:
        path = tmp_path / "00000_00000.png"
        cv2.imwrite(str(path), np.zeros((240, 240, 3), np.uint8))
        crop = load_crop(CropItem(path, (20, 20, 220, 220), 4))
        assert crop.pixels.shape == (77, 77, 3)
        assert crop.box[2] - crop.box[0] == pytest.approx(64, abs=0.5)


def test_drawn_crops_join_the_real_ones() -> None:
    crops = drawn_crops(2, np.random.default_rng(0))
    assert [crop.class_id for crop in crops] == [c for c in DRAWN_CLASSES for _ in range(2)]
    assert drawn_crops(0, np.random.default_rng(0)) == []


def test_neither_drawings_nor_mirror_images_show_an_unseen_class() -> None:
    crops = [LoadedCrop(glyph(39, 0), np.array([5.0, 5, 35, 35]), 39)] * 4
    settings = ClassifierSettings(batch=64, drawn=0.5, drawn_crops=1, inset=0.0)

    def shown(unseen: set[int]) -> set[int]:
        return set(next(_views(crops, settings, 1, np.random.default_rng(0), unseen))[1].tolist())

    assert {33, 34, 38, 39} < shown(set())
    assert shown(set(range(39))) == {39}


def test_limits_with_smaller_digits_join_the_real_ones(folder: Path) -> None:
    crops = [load_crop(item) for item in read_items(folder) if item.class_id in (3, 6, 7)]
    made = inset_crops(crops, 5, np.random.default_rng(0))
    assert [crop.class_id for crop in made] == [3] * 5 + [7] * 5
    assert inset_crops([crop for crop in crops if crop.class_id == 6], 5, np.random.default_rng(0)) == []
