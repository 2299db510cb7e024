"""Classifier and network together: the mixture's definition, missing labels, and stable bits."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.recognition.test_classifier import component as classifier_component
from tests.recognition.test_classifier import crops, labelled
from tests.recognition.test_network import component as network_component
from tsr_engine.errors import ModelError
from tsr_engine.io.models import Component, load_component, save_component
from tsr_engine.labels.classes import default_keys
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components, load_reader, make_reader
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.mixture import Mixture, pool_probabilities
from tsr_engine.training.corrections.refine_classifier import with_labels

ALL = tuple(range(43))


def two() -> tuple[SignClassifier, SignClassifier]:
    return SignClassifier.from_component(classifier_component()), SignClassifier.from_component(network_component())


def test_common_labels_have_the_normalised_geometric_mean() -> None:
    classifier, network = two()
    p, q = (one.probabilities(crops()).astype(np.float64) for one in (classifier, network))
    wanted = np.sqrt(p * q)
    found = Mixture(classifier, network, ALL).probabilities(crops())
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, wanted / wanted.sum(axis=1, keepdims=True), rtol=1e-4, atol=1e-7)


def test_labels_missing_from_the_network_have_the_classifier_probability() -> None:
    classifier, network = two()
    grown = with_labels(classifier, ["parking", "one-way"])
    bias = grown.bias.copy()
    bias[43:] = classifier.margins(crops()).max()
    grown = replace(grown, bias=bias)
    p = grown.probabilities(crops())
    found = Mixture(grown, network, (*ALL, -1, -1)).probabilities(crops())
    np.testing.assert_allclose(found[:, 43:], p[:, 43:], rtol=1e-6)
    assert found[:, 43:].min() > 0.01
    np.testing.assert_allclose(found.sum(axis=1), 1, rtol=1e-6)
    pool = Mixture(classifier, network, ALL).probabilities(crops())
    np.testing.assert_allclose(found[:, :43] / found[:, :43].sum(axis=1, keepdims=True), pool, rtol=1e-4, atol=1e-7)


def test_the_networks_other_labels_drop_out() -> None:
    own, other = np.log([[0.6, 0.3, 0.1]]), np.log([[0.5, 0.2, 0.2, 0.1]])
    found = pool_probabilities(own, other, (3, -1, 1))
    pool = np.sqrt([0.6 * 0.1, 0.1 * 0.2])
    np.testing.assert_allclose(found, [[0.7 * pool[0] / pool.sum(), 0.3, 0.7 * pool[1] / pool.sum()]])
    np.testing.assert_allclose(pool_probabilities(own, other, (-1, -1, -1)), [[0.6, 0.3, 0.1]])


def test_contradictory_readers_still_give_probabilities() -> None:
    own, other = np.array([[0.0, -2000.0, -1500.0]]), np.array([[-2000.0, 0.0, -1500.0]])
    np.testing.assert_allclose(pool_probabilities(own, other, (0, 1, 2)), [[0.5, 0.5, 0.0]], atol=1e-12)


def test_a_row_does_not_depend_on_its_batch() -> None:
    classifier, network = two()
    reader = Mixture(with_labels(classifier, ["parking"]), network, (*ALL, -1))
    seen = [*crops(), *crops()[::-1]]
    together = reader.probabilities(seen)
    for crop, row in zip(seen, together, strict=True):
        np.testing.assert_array_equal(reader.probabilities([crop])[0], row)
    assert reader.probabilities([]).shape == (0, 44)


def test_mismatched_parts_are_refused() -> None:
    classifier, network = two()
    with pytest.raises(ValueError, match=r"one margin. Got 0.1 and 0.2"):
        Mixture(classifier, replace(network, margin=0.2), ALL)
    for known in (ALL[:-1], (*ALL[:-1], 0), (*ALL[:-1], 43)):
        with pytest.raises(ValueError, match="for each of 43 classes"):
            Mixture(classifier, network, known)


def test_labels_are_found_by_their_keys() -> None:
    keys = ["parking", *default_keys()[-2::-1]]
    rows = {"classifier": labelled([key.upper() for key in keys], 43), "network_classifier": network_component()}
    reader = make_reader(rows)
    assert isinstance(reader, Mixture)
    assert reader.known == (-1, *range(41, -1, -1))
    assert reader.labels == tuple(key.upper() for key in keys)
    with pytest.raises(ModelError, match="Expected a classifier or a network"):
        make_reader({})


def test_both_read_by_default_and_the_classifier_alone_without_a_network(tmp_path: Path) -> None:
    usual = load_components(Params())
    assert isinstance(usual.parts.classifier, Mixture)
    hashes = {name: load_component(name).sha256 for name in ("classifier", "network_classifier")}
    assert {name: usual.models[name] for name in hashes} == hashes
    assert "network_classifier" not in load_components(Params.preset("paper")).models
    for name in ("detector", "classifier"):
        save_component(load_component(name), tmp_path)
    alone = load_components(Params(), tmp_path)
    assert isinstance(alone.parts.classifier, SignClassifier)
    assert "network_classifier" not in alone.models
    assert isinstance(load_reader(tmp_path), SignClassifier)


def test_a_damaged_network_is_refused(tmp_path: Path) -> None:
    for name in ("detector", "classifier"):
        save_component(load_component(name), tmp_path)
    made = network_component()
    arrays = {name: array for name, array in made.arrays.items() if name != "kernel6"}
    save_component(Component("network_classifier", arrays, made.params), tmp_path)
    with pytest.raises(ModelError, match="damaged: 'kernel6'"):
        load_components(Params(), tmp_path)
