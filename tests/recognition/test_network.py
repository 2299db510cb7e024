"""The network's layers against their definitions, and a classifier on its features."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.recognition.test_classifier import crops
from tsr_engine.errors import ModelError
from tsr_engine.io.models import Component, component_path, load_component, save_component
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components, load_reader
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.descriptor import resize_crops
from tsr_engine.recognition.features import FeatureMap
from tsr_engine.recognition.network import FEATURES, LAYERS, MIN_SPREAD, NETWORK_GEOMETRY, NetworkMap


def network(seed: int = 0) -> NetworkMap:
    rng = np.random.default_rng(seed)
    shapes = [(layer.size**2 * layer.inputs, layer.outputs) for layer in LAYERS]
    kernels = tuple(rng.normal(0, (2 / rows) ** 0.5, (rows, outputs)).astype(np.float32) for rows, outputs in shapes)
    return NetworkMap(kernels, tuple(rng.normal(0, 0.1, outputs).astype(np.float32) for _, outputs in shapes))


def component(seed: int = 0) -> Component:
    rng = np.random.default_rng(seed)
    planes = {"weights": rng.normal(0, 0.1, (FEATURES, 43)).astype(np.float16), "bias": np.zeros(43, np.float32)}
    return Component("network_classifier", network(seed).to_arrays() | planes, {**NETWORK_GEOMETRY, "temperature": 0.3})


def written_out(model: NetworkMap, patch: np.ndarray) -> np.ndarray:
    """The features by their definition, in double precision."""
    x = patch.astype(np.float64) - patch.mean()
    x /= max(patch.std(), MIN_SPREAD)
    for layer, kernel, bias in zip(LAYERS, model.kernels, model.biases, strict=True):
        wide = np.pad(x, ((layer.reach,) * 2, (layer.reach,) * 2, (0, 0)))
        windows = np.lib.stride_tricks.sliding_window_view(wide, (layer.size, layer.size), axis=(0, 1))
        windows = windows[:: layer.stride, :: layer.stride].transpose(0, 1, 3, 4, 2)
        found = windows.reshape(*windows.shape[:2], -1) @ kernel.astype(np.float64) + bias
        x = np.maximum(found + x if layer.is_residual else found, 0)
    return x.ravel()


def test_features_equal_the_definition() -> None:
    model = network()
    patches = resize_crops([*crops(), np.full((20, 20, 3), 90, np.uint8)])
    for patch, found in zip(patches, model.of_patches(patches), strict=True):
        np.testing.assert_allclose(found, written_out(model, patch), rtol=1e-4, atol=1e-4)
    assert model.of_patches(patches[:0]).shape == (0, model.length)


def test_a_crop_does_not_depend_on_its_batch_nor_on_its_light() -> None:
    model = network()
    patches = resize_crops(crops())
    both = model.of_patches(np.concatenate([patches, patches[::-1]]))
    np.testing.assert_array_equal(both[:3], both[3:][::-1])
    np.testing.assert_array_equal(model.of_patches(patches[1:2])[0], both[1])
    hazy = (patches // 2 + 60).astype(np.uint8)
    np.testing.assert_allclose(model.of_patches(hazy), model.of_patches(patches // 2), rtol=1e-3, atol=1e-3)


def test_a_stored_network_reads_back_equal() -> None:
    made = component()
    first = SignClassifier.from_component(made)
    again = SignClassifier.from_component(replace(made, arrays={**made.arrays, **first.features.to_arrays()}))
    assert isinstance(first.features, NetworkMap)
    np.testing.assert_array_equal(first.probabilities(crops()), again.probabilities(crops()))


@pytest.mark.parametrize(
    ("arrays", "params", "says"),
    [
        ({"kernel3": np.zeros((576, 64), np.float16)}, {}, "damaged: NetworkMap needs kernels"),
        ({"kernel5_bias": np.zeros(3, np.float32)}, {}, "damaged: NetworkMap needs kernels"),
        ({}, {"layers": [[3, 32, 5, 2]]}, "another descriptor"),
        ({}, {"margin": 0.2}, "another descriptor"),
    ],
)
def test_weights_of_other_layers_are_refused(
    arrays: dict[str, np.ndarray], params: dict[str, object], says: str
) -> None:
    made = component()
    with pytest.raises(ModelError, match=says):
        SignClassifier.from_component(replace(made, arrays=made.arrays | arrays, params=made.params | params))


def test_a_network_that_lacks_a_layer_is_refused() -> None:
    made = component()
    arrays = {name: array for name, array in made.arrays.items() if name != "kernel6"}
    with pytest.raises(ModelError, match="damaged: 'kernel6'"):
        SignClassifier.from_component(replace(made, arrays=arrays))


def test_the_network_of_a_model_folder_reads_on_request(tmp_path: Path) -> None:
    asking = Params().with_settings([("reader", "network")])
    usual, asked = load_components(Params.preset("paper")), load_components(asking)
    assert asked.models["network_classifier"] == load_component("network_classifier").sha256
    assert usual.models.keys() - asked.models.keys() == {"classifier"}
    kinds = [type(each.parts.classifier.features) for each in (usual, asked)]  # type: ignore[attr-defined]
    assert kinds == [FeatureMap, NetworkMap]
    for name in ("detector", "classifier"):
        save_component(load_component(name), tmp_path)
    for load in (lambda: load_components(asking, tmp_path), lambda: load_reader(tmp_path, "network")):
        with pytest.raises(ModelError, match="have no network that reads signs. Set reader to both or classifier"):
            load()


def test_the_shipped_network_reads_a_drawn_sign() -> None:
    y, x = np.mgrid[:60, :60]
    picture = np.full((60, 60, 3), (150, 140, 130), np.uint8)
    picture[np.hypot(x - 29.5, y - 29.5) < 25] = (30, 20, 190)
    picture[26:34, 11:49] = (235, 235, 235)
    (p,) = load_reader(reader="network").probabilities([picture])
    assert p.argmax() == 17
    shipped = load_component("network_classifier")
    assert shipped.figures["accuracy"] > load_component("classifier").figures["accuracy"]
    assert component_path("network_classifier").stat().st_size < 2_000_000
