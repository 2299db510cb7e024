"""Trains the component ``network_classifier``: machines on the features of a network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.io.gtsrb import read_items, split_by_track
from tsr_engine.io.models import Component
from tsr_engine.recognition.classifier import NETWORK_COMPONENT, SignClassifier
from tsr_engine.recognition.network import NETWORK_GEOMETRY, NetworkMap
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.classifier import load_all, require_all_classes
from tsr_engine.training.public.classifier_figures import held_out_figures
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop, plain_view

__all__ = ["classifier_of", "component_of", "train_network"]

_HELD_OUT: Final = 0.25
"""Share of each class's tracks for figures and temperature."""
_MAX_SCALING_CROPS: Final = 1000
"""Number of crops by which the machines are shifted and scaled."""


def train_network(folder: Path, seed: int, device: str, progress: Progress) -> Component:
    """Train on GTSRB class folders: once without the held-out tracks, for figures and temperature, then on all.

    Args:
        folder: the folder of the class folders 00000 to 00042.
        seed: seed of split, weights and views.
        device: as PyTorch names it.
        progress: called with stage, number done and total.

    Raises:
        InputError: missing or damaged data, or a class without pictures.
        UsageError: PyTorch cannot use the device here.
    """
    from tsr_engine.training.public.network import NetworkPlan, fit_network, require_device
    from tsr_engine.training.public.network_crops import bank_of

    require_device(device)
    plan = NetworkPlan()
    items = [item for item in read_items(folder) if item.track is not None]
    require_all_classes(items, folder)
    parts = split_by_track(items, _HELD_OUT, seed)
    training, held = (load_all(part, progress, "read pictures") for part in parts)

    def fitted(crops: Sequence[LoadedCrop], what: str) -> SignClassifier:
        fitted = fit_network(bank_of(crops, seed), plan, seed, device, lambda s, n, m: progress(f"{s} {what}", n, m))
        return classifier_of(*fitted, crops)

    trial = fitted(training, "of the split")
    temperature, figures = held_out_figures(trial, held, seed)
    whole = replace(fitted([*training, *held], "on all tracks"), temperature=temperature)
    data = {
        "name": "GTSRB training set and drawings of the label set vienna",
        "pictures": len(items),
        "tracks": len({item.track for item in items}),
        "weights_from": "all tracks",
        "figures_from": "held-out tracks of the split, weights of its training part",
        "held_out_tracks": len({item.track for item in parts[1]}),
    }
    made = component_of(whole, seed)
    return replace(made, data=data, figures=figures, params={**made.params, "training": plan.as_dict()})


def classifier_of(
    features: NetworkMap,
    weights: NDArray[np.float32],
    bias: NDArray[np.float32],
    crops: Sequence[LoadedCrop],
) -> SignClassifier:
    """Convert a network's outputs to machines: average margins are 1 for the sign and -1 for others; temperature 1.

    Args:
        features: the network.
        weights: weights of its outputs, shape (256, 43).
        bias: shape (43,).
        crops: crops that the network was trained on.
    """
    looked = crops[:: max(1, len(crops) // _MAX_SCALING_CROPS)]
    labels = np.array([crop.class_id for crop in looked])
    margins = features.of_patches(np.stack([plain_view(crop) for crop in looked])) @ weights + bias
    own = float(margins[np.arange(len(labels)), labels].mean())
    other = (float(margins.sum(axis=1).mean()) - own) / (len(bias) - 1)
    scale, middle = (own - other) / 2, (own + other) / 2
    planes = (weights / scale).astype(np.float16).astype(np.float32)
    return SignClassifier(features, planes, ((bias - middle) / scale).astype(np.float32), 1.0)


def component_of(classifier: SignClassifier, seed: int) -> Component:
    """The component for :meth:`SignClassifier.from_component`, without data and figures."""
    arrays = {
        **classifier.features.to_arrays(),
        "weights": classifier.weights.astype(np.float16),
        "bias": classifier.bias,
    }
    params = {**NETWORK_GEOMETRY, "temperature": classifier.temperature}
    return Component(NETWORK_COMPONENT, arrays, params, {}, {}, seed)
