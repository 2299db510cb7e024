from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tsr_engine.errors import ModelError
from tsr_engine.io.models import SHIPPED, Component, load_component, save_component
from tsr_engine.labels.classes import default_keys
from tsr_engine.params import Params
from tsr_engine.params.fusion import FusionParams
from tsr_engine.pipeline import load_components
from tsr_engine.recognition.classifier import GEOMETRY, SignClassifier, softmax
from tsr_engine.recognition.descriptor import CHANNELS, GRID, describe
from tsr_engine.recognition.features import FeatureMap, windows
from tsr_engine.recognition.fusion import Fusion
from tsr_engine.recognition.gtsrb_classes import CLASS_NAMES


def component(seed: int = 0, temperature: float = 1.5) -> Component:
    generator = np.random.default_rng(seed)
    f, h = 6, 10
    shapes = {"filters": (480, f), "hidden": (25 * f, h), "weights": (h, 43)}
    matrices = {key: generator.normal(0, 0.1, shape).astype(np.float16) for key, shape in shapes.items()}
    biases = {
        key: generator.normal(0, 0.1, n).astype(np.float32)
        for key, n in (("filter_bias", f), ("hidden_bias", h), ("bias", 43))
    }
    return Component("classifier", matrices | biases, {**GEOMETRY, "temperature": temperature})


def crops(seed: int = 1) -> list[np.ndarray]:
    generator = np.random.default_rng(seed)
    return [generator.integers(0, 256, (h, w, 3)).astype(np.uint8) for h, w in ((17, 16), (48, 48), (90, 70))]


def test_margins_equal_the_formula() -> None:
    made = component()
    a = {key: value.astype(np.float64) for key, value in made.arrays.items()}
    for crop, margins in zip(crops(), SignClassifier.from_component(made).margins(crops()), strict=True):
        grid = describe([crop])[0].astype(np.float64).reshape(GRID, GRID, CHANNELS)
        found = [
            np.maximum(grid[y : y + 4, x : x + 4].ravel() @ a["filters"] + a["filter_bias"], 0)
            for y in range(0, 9, 2)
            for x in range(0, 9, 2)
        ]
        features = np.maximum(np.concatenate(found) @ a["hidden"] + a["hidden_bias"], 0)
        np.testing.assert_allclose(margins, features @ a["weights"] + a["bias"], atol=1e-4)


def test_a_crop_does_not_depend_on_its_batch() -> None:
    classifier = SignClassifier.from_component(component())
    batch = classifier.probabilities(crops() * 3)
    for i, crop in enumerate(crops() * 3):
        np.testing.assert_array_equal(classifier.probabilities([crop])[0], batch[i])


def test_probabilities_are_the_softmax_of_margins_over_temperature() -> None:
    classifier = SignClassifier.from_component(component(temperature=2.0))
    m = classifier.margins(crops()).astype(np.float64)
    expected = np.exp(m / 2) / np.exp(m / 2).sum(1, keepdims=True)
    np.testing.assert_allclose(classifier.probabilities(crops()), expected, rtol=1e-5)
    assert classifier.probabilities(crops()).dtype == np.float32


def test_an_empty_batch() -> None:
    assert SignClassifier.from_component(component()).probabilities([]).shape == (0, 43)


def test_a_written_classifier_reads_back_equal(tmp_path: Any) -> None:
    made = component()
    save_component(made, tmp_path)
    before, after = (SignClassifier.from_component(c) for c in (made, load_component("classifier", tmp_path)))
    np.testing.assert_array_equal(before.probabilities(crops()), after.probabilities(crops()))


@settings(deadline=None, max_examples=40)
@given(arrays(np.float64, (3, 43), elements=st.floats(-1e4, 1e4)), st.floats(0.01, 100))
def test_softmax_sums_to_one_without_overflow(margins: np.ndarray, temperature: float) -> None:
    p = softmax(margins, temperature)
    np.testing.assert_allclose(p.sum(1), 1, atol=1e-5)
    assert (p >= 0).all()
    assert (np.take_along_axis(p, margins.argmax(1)[:, None], 1)[:, 0] == p.max(1)).all()


def test_windows_are_read_row_by_row() -> None:
    descriptor = np.arange(GRID * GRID * CHANNELS, dtype=np.float32)[None]
    rows = windows(descriptor)
    grid = descriptor.reshape(GRID, GRID, CHANNELS)
    assert rows.shape == (25, 480)
    np.testing.assert_array_equal(rows[7], grid[2:6, 4:8].ravel())


def test_the_feature_map_equals_its_two_layers_for_any_batch() -> None:
    generator = np.random.default_rng(4)
    shapes = ((480, 8), (8,), (200, 7), (7,))
    layers = [generator.normal(0, 0.3, shape).astype(np.float32) for shape in shapes]
    filters, filter_bias, hidden, hidden_bias = layers
    descriptors = generator.random((6, 4320), dtype=np.float32)
    found = np.maximum(windows(descriptors) @ filters + filter_bias, 0).reshape(6, -1)
    assert 0.2 < (found == 0).mean() < 0.8, "both kinds of rows are there"
    expected = np.maximum(found @ hidden + hidden_bias, 0)
    features = FeatureMap(*layers)
    np.testing.assert_allclose(features(descriptors), expected, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(features(descriptors, together=2), expected, rtol=1e-4, atol=1e-4)
    assert features(descriptors[:0]).shape == (0, 7)


def damaged(change: str) -> Any:
    good = component()
    arrays, params = dict(good.arrays), dict(good.params)
    if change == "missing":
        del arrays["hidden"]
    elif change == "shape":
        arrays["weights"] = arrays["weights"][:, :42]
    elif change == "flat":
        arrays["filters"] = arrays["filters"].ravel()
    elif change == "temperature":
        params["temperature"] = -1.0
    elif change == "other descriptor":
        params["cell"] = 6
    return SimpleNamespace(arrays=arrays, params=params)


@pytest.mark.parametrize("change", ["missing", "shape", "flat", "temperature", "other descriptor"])
def test_a_damaged_component_is_refused(change: str) -> None:
    with pytest.raises(ModelError, match="Train it again"):
        SignClassifier.from_component(damaged(change))


def test_a_feature_map_refuses_other_shapes() -> None:
    good = FeatureMap(*(np.zeros(s, np.float32) for s in ((480, 4), (4,), (100, 5), (5,))))
    assert good.length == 5
    with pytest.raises(ValueError, match=r"hidden must have shape \(100, 5\)"):
        FeatureMap(good.filters, good.filter_bias, np.zeros((99, 5), np.float32), good.hidden_bias)


def labelled(labels: Any, count: int = 3) -> Any:
    good = component()
    arrays = {**good.arrays, "weights": good.arrays["weights"][:, :count], "bias": good.arrays["bias"][:count]}
    return SimpleNamespace(arrays=arrays, params={**good.params, "labels": labels})


def test_a_component_lists_its_labels() -> None:
    classifier = SignClassifier.from_component(labelled(["stop", "bus-stop", "C,3a"]))
    assert classifier.labels == ("stop", "bus-stop", "C,3a")
    found = classifier.probabilities(crops())
    assert found.shape == (3, 3)
    np.testing.assert_allclose(found.sum(axis=1), 1, rtol=1e-6)
    np.testing.assert_array_equal(
        classifier.margins(crops()), SignClassifier.from_component(component()).margins(crops())[:, :3]
    )
    _, record = Fusion.start(FusionParams(), 3).update(found[0], 40)
    assert record.votes.shape == (3,)


@pytest.mark.parametrize("labels", [["stop", "Stop", "a"], ["stop", "a"], "abc", ["stop", "", "a"], ["a", 3, "b"], []])
def test_invalid_labels_are_refused(labels: Any) -> None:
    with pytest.raises(ModelError, match="Train it again"):
        SignClassifier.from_component(labelled(labels))


def test_a_single_label_is_refused() -> None:
    with pytest.raises(ModelError, match="two labels or more"):
        SignClassifier.from_component(labelled(["stop"], 1))


def test_models_without_labels_have_the_classes_of_the_catalogue(tmp_path: Path) -> None:
    shipped = load_components(Params())
    assert shipped.labels is None
    assert shipped.parts.names == CLASS_NAMES
    for name in ("detector", "classifier"):
        one = load_component(name, SHIPPED)
        if name == "classifier":
            arrays = {**one.arrays, "weights": one.arrays["weights"][:, :2], "bias": one.arrays["bias"][:2]}
            one = type(one)(name, arrays, {**one.params, "labels": ["stop", "bus-stop"]})
        save_component(one, tmp_path)
    other = load_components(Params(), tmp_path)
    assert (other.labels, other.parts.names) == (("stop", "bus-stop"), ("stop", "bus-stop"))
    same = load_component("classifier", SHIPPED)
    save_component(type(same)("classifier", same.arrays, {**same.params, "labels": list(default_keys())}), tmp_path)
    assert load_components(Params(), tmp_path).labels is None
