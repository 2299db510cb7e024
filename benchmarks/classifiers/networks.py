"""Classifiers on networks that were trained without some crops, by PyTorch on a GPU, once for each scratch folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.classifiers.stored import stored_classifier, training_digest
from benchmarks.experiment import Data, Skip
from tsr_engine.io.gtsrb import CropItem
from tsr_engine.io.models import Component
from tsr_engine.recognition.classifier import NETWORK_COMPONENT, SignClassifier
from tsr_engine.training.public.classifier_figures import fit_temperature
from tsr_engine.training.public.network_classifier import classifier_of, component_of
from tsr_engine.training.synthetic.classifier_augmentation import load_crop, plain_view

_NETWORK_CODE = (
    "recognition/network.py", "training/public/network.py", "training/public/network_classifier.py",
    "training/public/network_crops.py", "training/synthetic/network_augmentation.py",
)  # fmt: skip
"""Code that a network depends on; a change makes stored networks invalid."""


def trained_on(items: Sequence[CropItem], held: Sequence[CropItem], data: Data, name: str) -> SignClassifier:
    """The classifier as ``tsr train network`` trains it, but on some tracks only.

    Args:
        items: crops to train on.
        held: crops of other tracks, for the fit of the temperature.
        data: seed and scratch folder.
        name: name of the classifier's folder in the scratch folder.

    Raises:
        Skip: there is no stored classifier, and PyTorch or a GPU is missing.
    """

    def component() -> Component:
        network = _trained(items, data.seed)
        crops = [load_crop(item) for item in held]
        margins = network.margins([plain_view(crop) for crop in crops])
        temperature = fit_temperature(margins, np.array([crop.class_id for crop in crops]))
        return component_of(replace(network, temperature=temperature), data.seed)

    folder = data.scratch / f"{name}-{data.seed}-{training_digest(_NETWORK_CODE)}"
    return stored_classifier(folder, NETWORK_COMPONENT, component)


def _trained(items: Sequence[CropItem], seed: int) -> SignClassifier:
    try:
        import torch
    except ModuleNotFoundError:
        raise Skip("no PyTorch to train a network with: pip install 'tsr[network]'.") from None
    if not torch.cuda.is_available():
        raise Skip("no GPU: a network takes minutes there and days here.")
    from tsr_engine.training.public.network import NetworkPlan, fit_network
    from tsr_engine.training.public.network_crops import bank_of

    crops = [load_crop(item) for item in items]
    return classifier_of(*fit_network(bank_of(crops, seed), NetworkPlan(), seed, "cuda", lambda *_: None), crops)
