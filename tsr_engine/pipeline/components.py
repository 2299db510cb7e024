"""The trained parts of a run, loaded from a model folder and recorded by their hashes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tsr_engine.detection.acf import AcfDetector
from tsr_engine.errors import ModelError
from tsr_engine.io.models import SHIPPED, Component, load_component, read_manifest
from tsr_engine.online.features import FEATURES
from tsr_engine.online.online_detector import OnlineDetectorMaker
from tsr_engine.params import Params
from tsr_engine.pipeline.companion import OnlineMaker, Parts
from tsr_engine.protocols import OfflineDetector
from tsr_engine.recognition.classifier import SignClassifier

__all__ = ["Components", "load_classifier", "load_components", "load_detector"]


@dataclass(frozen=True, slots=True)
class Components:
    """Everything trained that a run needs.

    Attributes:
        detector: the offline detector.
        parts: what the core needs.
        models: component name -> sha256, recorded with the run.
        learned_lambda: ``lambda`` of Eq. 2 as it was learned (Eq. 8).
    """

    detector: OfflineDetector
    parts: Parts
    models: Mapping[str, str] = field(default_factory=dict)
    learned_lambda: float = 0.0


def load_components(params: Params, folder: Path | None = None) -> Components:
    """All parts of a model folder; unset: the shipped one.

    Raises:
        ModelError: a component is missing, damaged, or of another version.
    """
    names = ("detector", "prior", "classifier", "online")
    present = read_manifest(SHIPPED if folder is None else folder)["components"]
    # The detector and the classifier are indispensable: asking for them raises the error that explains.
    found = {n: load_component(n, folder) for n in names if n in present or n in ("detector", "classifier")}
    detector = _detector(found["detector"], found.get("prior"), params)
    parts = Parts(SignClassifier.from_component(found["classifier"]), _online(params, found.get("online")))
    learned = 0.0 if detector.prior is None else detector.prior.weight
    return Components(detector, parts, {name: c.sha256 for name, c in found.items()}, learned)


def load_detector(params: Params, folder: Path | None = None) -> AcfDetector:
    """The offline detector of a model folder, with its prior if there is one; unset: the shipped one.

    Raises:
        ModelError: missing, damaged, or of another version.
    """
    present = read_manifest(SHIPPED if folder is None else folder)["components"]
    prior = load_component("prior", folder) if "prior" in present else None
    return _detector(load_component("detector", folder), prior, params)


def load_classifier(folder: Path | None = None) -> SignClassifier:
    """The classifier of a model folder; unset: the shipped one.

    Raises:
        ModelError: missing, damaged, or of another version.
    """
    return SignClassifier.from_component(load_component("classifier", folder))


def _detector(component: Component, prior: Component | None, params: Params) -> AcfDetector:
    try:
        return AcfDetector.from_components(component, prior, params.detector, params.prior)
    except (ValueError, TypeError, KeyError, IndexError) as error:
        raise ModelError(f"The detector component is damaged: {error} Train it again with `tsr train`.") from None


def _online(params: Params, component: Component | None) -> OnlineMaker:
    """The maker of online detectors; without offline samples they start from the track's first frame alone."""
    empty = np.zeros((0, FEATURES)), np.zeros(0)
    if component is None:
        return OnlineDetectorMaker(*empty, params.online)
    try:
        return OnlineDetectorMaker(component.arrays["X"], component.arrays["y"], params.online)
    except (KeyError, ValueError) as error:
        raise ModelError(f"The online component is damaged: {error}. Train it again with `tsr train`.") from None
