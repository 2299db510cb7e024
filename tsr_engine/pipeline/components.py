"""The trained parts of a run, loaded from a model folder and recorded by their hashes."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

from tsr_engine.detection.acf import AcfDetector, AcfModel
from tsr_engine.detection.onnx import Layout, OnnxDetector
from tsr_engine.detection.other_shapes import COMPONENT as OTHER_SHAPES
from tsr_engine.detection.other_shapes import OtherShapes
from tsr_engine.detection.prior import SpatialPrior
from tsr_engine.detection.refine.window_rescoring import WindowRescoring
from tsr_engine.errors import ModelError
from tsr_engine.io.models import SHIPPED, Component, load_component, read_manifest
from tsr_engine.labels.classes import class_names_of, default_keys
from tsr_engine.online.features import FEATURES
from tsr_engine.online.online_detector import OnlineDetectorMaker
from tsr_engine.params import Params
from tsr_engine.pipeline.sign_readers import READER_COMPONENTS, make_reader, reader_components
from tsr_engine.pipeline.track_context import Models
from tsr_engine.protocols import OfflineDetector


@dataclass(frozen=True, slots=True)
class Components:
    """All trained parts that a run needs.

    Attributes:
        detector: the offline detector.
        parts: what the core needs.
        models: component name -> sha256, recorded with the run.
        learned_lambda: ``lambda`` of Eq. 2, learned by Eq. 8.
        labels: keys of the classifier's classes; None: those of ``gtsrb-43``.
    """

    detector: OfflineDetector
    parts: Models
    models: Mapping[str, str] = field(default_factory=dict)
    learned_lambda: float = 0.0
    labels: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True)
class Network:
    """An ONNX network that replaces the ACF detector.

    Attributes:
        path: the file.
        size: (width, height) of the network's input, px.
        layout: layout of its output, see :mod:`tsr_engine.detection.onnx`.
    """

    path: Path
    size: tuple[int, int] = (640, 640)
    layout: Layout = "v8"


def load_components(params: Params, folder: Path | None = None, network: Network | None = None) -> Components:
    """All parts of a model folder; unset: the shipped one.

    Args:
        params: all parameters.
        folder: the model folder; unset: the shipped one.
        network: replaces the folder's ACF component; its hash is recorded instead.

    Raises:
        ModelError: a component is missing, damaged, or of another version, or the network is none.
    """
    # The detector and what reads are indispensable: asking for them raises the error that explains.
    readers = reader_components(folder, params.pipeline.reader)
    needed = readers if network is not None else ("detector", *readers)
    loaded = {name: load_component(name, folder) for name in needed}
    loaded |= {name: part for name in ("prior", "online") if (part := _optional(name, folder)) is not None}
    models = {name: component.sha256 for name, component in loaded.items()}
    detector: AcfDetector | OnnxDetector
    if network is None:
        detector = _detector(loaded["detector"], loaded.get("prior"), params)
    else:
        detector, digest = load_network(network, params, loaded.get("prior"))
        models[f"onnx {network.size[0]}x{network.size[1]} {network.layout}"] = digest
    window_scorer = None
    if isinstance(detector, AcfDetector):
        window_scorer = WindowRescoring(detector.model, detector.box_inset, params.detector.refine_passes)
    classifier = make_reader({name: loaded[name] for name in READER_COMPONENTS if name in loaded})
    labels = classifier.labels if classifier.labels not in ((), default_keys()) else None
    parts = Models(classifier, _online(params, loaded.get("online")), window_scorer, class_names_of(labels))
    learned = 0.0 if detector.prior is None else detector.prior.weight
    return Components(detector, parts, models, learned, labels)


def load_network(network: Network, params: Params, prior: Component | None = None) -> tuple[OnnxDetector, str]:
    """An ONNX network as the detector, and the sha256 of its file.

    The network runs once on an empty picture, so that a wrong size or layout is found before any frame is decoded.

    Args:
        network: the file and how to use it.
        params: all parameters.
        prior: component ``prior``; unset: scores stay as the network gives them.

    Raises:
        ModelError: the file cannot be read, is no network, or does not take the size or give the layout.
    """
    try:
        content = network.path.read_bytes()
    except OSError as error:
        raise ModelError(f"Cannot read the network {network.path}: {error.strerror}. Check --onnx.") from None
    if not content:
        raise ModelError(f"The network {network.path} is empty. Expected an ONNX file; copy or export it again.")
    width, height = network.size
    try:
        spatial = None
        if prior is not None:
            spatial = SpatialPrior(prior.arrays["table"].astype(np.float32), float(prior.params["lambda"]))
    except (ValueError, TypeError, KeyError) as error:
        raise ModelError(f"The prior component is damaged: {error} Train it again with `tsr train`.") from None
    try:
        detector = OnnxDetector(content, network.size, network.layout, spatial, params.detector, params.prior)
    except (ValueError, cv2.error) as error:
        raise ModelError(
            f"{network.path} is not a network that can be run ({_reason(error)}). Expected an ONNX file; export it "
            "again."
        ) from None
    try:
        detector.detect(np.zeros((height, width, 3), np.uint8))
    except (ValueError, IndexError, cv2.error) as error:
        raise ModelError(
            f"The network {network.path} does not run with an input of {width}x{height} and an output of layout "
            f"{network.layout} ({_reason(error)}). Choose --onnx-size and --onnx-layout as it was exported."
        ) from None
    return detector, hashlib.sha256(content).hexdigest()


def _reason(error: Exception) -> str:
    """The first line of a library's explanation."""
    text = str(getattr(error, "err", "") or error).strip()
    return text.splitlines()[0] if text else type(error).__name__


def load_detector(params: Params, folder: Path | None = None) -> AcfDetector:
    """The offline detector of a model folder, with its prior if there is one; unset: the shipped one.

    Raises:
        ModelError: missing, damaged, or of another version.
    """
    prior = _optional("prior", folder)
    return _detector(load_component("detector", folder), prior, params)


def load_other_shapes(params: Params, folder: Path | None = None) -> OtherShapes:
    """The detector of signs outside the classes, from a model folder; unset: the shipped one.

    Raises:
        ModelError: missing, damaged, or of another version.
    """
    component, detector = load_component(OTHER_SHAPES, folder), load_component("detector", folder)
    try:
        known_signs = AcfModel.from_arrays(detector.arrays, detector.params)
        return OtherShapes.from_component(component, known_signs, params.detector)
    except (ValueError, TypeError, KeyError, IndexError) as error:
        raise ModelError(
            f"The component of other shapes is damaged: {error} Train it again with `tsr train other-shapes`."
        ) from None


def load_online(params: Params, folder: Path | None = None) -> OnlineDetectorMaker:
    """The maker of online detectors, with a model folder's offline samples if there are any; unset: the shipped one.

    Raises:
        ModelError: damaged, or of another version.
    """
    return _online(params, _optional("online", folder))


def _optional(name: str, folder: Path | None) -> Component | None:
    """A component of a model folder; None: the folder has none of this name."""
    present = read_manifest(SHIPPED if folder is None else folder)["components"]
    return load_component(name, folder) if name in present else None


def _detector(component: Component, prior: Component | None, params: Params) -> AcfDetector:
    try:
        return AcfDetector.from_components(component, prior, params.detector, params.prior)
    except (ValueError, TypeError, KeyError, IndexError) as error:
        raise ModelError(f"The detector component is damaged: {error} Train it again with `tsr train`.") from None


def _online(params: Params, component: Component | None) -> OnlineDetectorMaker:
    """The maker of online detectors; without offline samples they start from the track's first frame alone."""
    if component is None:
        return OnlineDetectorMaker(np.zeros((0, FEATURES)), np.zeros(0), params.online)
    try:
        return OnlineDetectorMaker(component.arrays["X"], component.arrays["y"], params.online)
    except (KeyError, ValueError) as error:
        raise ModelError(f"The online component is damaged: {error}. Train it again with `tsr train`.") from None
