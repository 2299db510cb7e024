"""The trained systems: trained once on the scenes of the ACF detector's held-out model, then read from files."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from benchmarks.experiment import Data
from benchmarks.systems.colour_mser import ColourMser, ColourMserDetector
from benchmarks.systems.colour_mser_training import train_colour_mser
from benchmarks.systems.hog_cascade import HogCascade, HogCascadeDetector
from benchmarks.systems.hog_training import train_hog_cascade
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.io.gtsrb import CropItem, read_items
from tsr_engine.io.models import Component, load_component, save_component
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params.detector import DetectorParams
from tsr_engine.protocols import OfflineDetector
from tsr_engine.training.public.detector_components import split_scenes

__all__ = ["SYSTEMS", "System", "TrainedSystem", "split", "trained"]

Model = Any  # Any: each system has its own kind of model
_Scenes = Sequence[Scene]
Train = Callable[[_Scenes, _Scenes, Sequence[CropItem], int, Callable[[str], None]], tuple[Model, JsonObject]]


@dataclass(frozen=True, slots=True)
class System:
    """One system of the comparison.

    Attributes:
        name: name of its component, for files.
        title: name in the report.
        train: trains on training and calibration scenes, crops, seed and a callback; returns a model and a record.
        read: makes a model from arrays and settings.
        detector: makes a detector from a model and parameters.
    """

    name: str
    title: str
    train: Train
    read: Callable[[JsonMapping, JsonMapping], Model]
    detector: Callable[[Model, DetectorParams], OfflineDetector]


@dataclass(frozen=True, slots=True)
class TrainedSystem:
    """A trained system.

    Attributes:
        system: the system.
        model: its model.
        record: record of the training, with ``cpu_seconds`` and ``processor``.
        sha256: hash of the component.
    """

    system: System
    model: Model
    record: JsonMapping = field(default_factory=dict)
    sha256: str = ""

    def detector(self, params: DetectorParams | None = None) -> OfflineDetector:
        """The detector."""
        return self.system.detector(self.model, params or DetectorParams())


SYSTEMS: Final = (
    System("hog_cascade", "HOG cascade", train_hog_cascade, HogCascade.from_arrays, HogCascadeDetector),
    System(
        "colour_mser", "colour + MSER + HOG SVM [20]", train_colour_mser, ColourMser.from_arrays, ColourMserDetector
    ),
)


def split(data: Data) -> tuple[list[Scene], list[Scene], list[Scene]]:
    """Scenes for training, calibration and report, in the shipped detector's split of the same folder.

    Raises:
        Skip: there are no scenes.
    """
    seed = load_component("detector").seed or 0
    return split_scenes(read_gtsdb(data.need("gtsdb")), seed)


def trained(data: Data, only: Sequence[str] | None = None) -> list[TrainedSystem]:
    """The systems; those that the scratch folder lacks are trained and stored there.

    Args:
        data: scenes and crops.
        only: names of systems; unset: all.

    Raises:
        Skip: scenes or crops are missing.
    """
    train, calibrate, _ = split(data)
    gtsrb = data.need("gtsrb")
    out = []
    for system in SYSTEMS:
        if only is not None and system.name not in only:
            continue
        folder = data.scratch / f"system-{system.name}-{data.seed}"
        if not (folder / "manifest.json").is_file():
            crops = read_items(gtsrb)
            began = time.process_time()
            model, record = system.train(train, calibrate, crops, data.seed, _report(system.name, began))
            record["cpu_seconds"] = round(time.process_time() - began, 1)
            arrays, settings = model.to_arrays()
            save_component(Component(system.name, arrays, settings, record, {}, data.seed), folder)
        component = load_component(system.name, folder)
        model = system.read(component.arrays, component.params)
        out.append(TrainedSystem(system, model, component.data, component.sha256))
    return out


def _report(name: str, began: float) -> Callable[[str], None]:
    def progress(stage: str) -> None:
        sys.stderr.write(f"  {name}, {time.process_time() - began:.0f} s CPU: {stage}\n")
        sys.stderr.flush()

    return progress
