"""The network's training on toy data; tests without PyTorch cover the rest."""

from __future__ import annotations

import numpy as np
import pytest

from tests.recognition.test_network import network
from tsr_engine.labels.classes import default_keys
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.training.public import network_crops
from tsr_engine.training.public.network_classifier import classifier_of, component_of
from tsr_engine.training.public.network_crops import CropBank, bank_of, network_keys
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop, plain_view


def toy_crops() -> list[LoadedCrop]:
    """Three classes that differ in the position of a bar."""
    rng = np.random.default_rng(0)
    crops = []
    for number in range(36):
        pixels = rng.integers(0, 40, (60, 60, 3), dtype=np.uint8)
        pixels[12 + 12 * (number % 3) :][:8, 10:50] = 200
        crops.append(LoadedCrop(pixels, np.array([10.0, 10, 50, 50]), (1, 4, 7)[number % 3]))
    return crops


def test_the_bank_contains_every_sign(monkeypatch: pytest.MonkeyPatch) -> None:
    keys = network_keys()
    assert keys[:43] == default_keys()
    assert len(keys) > 200
    monkeypatch.setattr(network_crops, "network_keys", lambda: keys[:46])
    for name, value in (("_EACH", 1), ("_EACH_LIMIT", 1), ("_DRAWN", 48)):
        monkeypatch.setattr(network_crops, name, value)
    bank = bank_of(toy_crops(), 0)
    assert set(bank.classes.tolist()) == set(range(46))
    assert bank.chances.sum() == pytest.approx(1)
    assert ((bank.boxes >= 0) & (bank.boxes <= 1)).all()
    assert (bank.boxes[:, 2:] > bank.boxes[:, :2]).all()


def test_machines_equal_the_network_and_are_centred() -> None:
    crops, features = toy_crops(), network()
    views = [plain_view(crop) for crop in crops]
    labels = np.array([crop.class_id for crop in crops])
    seen = features.of_patches(np.stack(views))
    weights = np.random.default_rng(1).normal(0, 0.01, (256, 43)).astype(np.float32)
    for label in (1, 4, 7):
        weights[:, label] += seen[labels == label].mean(axis=0) - seen.mean(axis=0)
    bias = np.linspace(-1, 1, 43, dtype=np.float32)
    made = classifier_of(features, weights, bias, crops)
    own, margins = seen @ weights + bias, made.margins(views)
    assert (margins.argmax(axis=1) == own.argmax(axis=1)).all()
    right = margins[np.arange(len(crops)), labels]
    assert right.mean() == pytest.approx(1, abs=0.02)
    assert (margins.sum() - right.sum()) / (42 * len(crops)) == pytest.approx(-1, abs=0.02)
    again = SignClassifier.from_component(component_of(made, 0))
    np.testing.assert_allclose(again.margins(views), margins, atol=2e-3)


def test_the_seed_decides_the_network_and_its_export_is_equal() -> None:
    torch = pytest.importorskip("torch")
    from tsr_engine.training.public import network as module

    crops = toy_crops()
    bank = CropBank(
        np.stack([np.pad(crop.pixels, ((0, 12), (0, 12), (0, 0))) for crop in crops]),
        np.tile(np.float32([0.14, 0.14, 0.7, 0.7]), (len(crops), 1)),
        np.array([crop.class_id for crop in crops]),
        np.full(len(crops), 0.02, np.float32),
        np.full(len(crops), 1 / len(crops)),
    )
    plan = module.NetworkPlan(module.Stage(2, 2e-3, 0.1), module.Stage(2, 3e-3, 0.1), batch=16, pool=1)
    one, same, other = (module.fit_network(bank, plan, seed, "cpu", lambda *told: None) for seed in (1, 1, 2))
    for first, second in zip(one[0].kernels, same[0].kernels, strict=True):
        np.testing.assert_array_equal(first, second)
    assert not np.array_equal(one[1], other[1])
    assert (one[1].shape, one[2].shape) == ((256, 43), (43,))
    made = module._Network(module.LAYERS[:-1], module.FEATURES, 0.1).eval()
    views = np.stack([plain_view(crop) for crop in crops[:3]])
    with torch.no_grad():
        found = made.features(torch.from_numpy(views).permute(0, 3, 1, 2).float()).numpy()
    np.testing.assert_allclose(made.exported().of_patches(views), found, atol=2e-3)
