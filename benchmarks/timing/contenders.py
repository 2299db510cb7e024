"""The networks for comparison of times, each as a function of a picture."""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.deep.yolo import name_of
from benchmarks.experiment import ROOT, Skip
from benchmarks.timing.alternating import Contender
from tsr_engine.detection.onnx import OnnxDetector, letterbox
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.records import Picture

EQUAL: Final = "YOLO11n, 736x576"
ENLARGED: Final = "YOLO11n, 1440x1152"
SIZES: Final = {EQUAL: (736, 576), ENLARGED: (1440, 1152)}
SIGNS: Final = ROOT / "deep" / "signs.onnx"
"""The small deep detector of this report."""


@dataclass(frozen=True, slots=True)
class Networks:
    """Networks by name, and their description for the report."""

    run: Mapping[str, Contender]
    about: JsonMapping


def runtime() -> ModuleType:
    """The module `onnxruntime`.

    Raises:
        Skip: the module is not installed.
    """
    _need("onnxruntime")
    return importlib.import_module("onnxruntime")


def _need(package: str) -> None:
    if importlib.util.find_spec(package) is None:
        raise Skip(f"the package `{package}` is not installed here; `pip install -e '.[bench]'` brings it.")


def session(onnxruntime: ModuleType, network: Path | bytes) -> Any:  # Any: ONNX Runtime is optional
    """An inference session with one thread."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 3
    given = network if isinstance(network, bytes) else str(network)
    return onnxruntime.InferenceSession(given, options, providers=["CPUExecutionProvider"])


def yolo_networks(onnxruntime: ModuleType, folder: Path) -> Networks:
    """YOLO11n with random weights at both input sizes, exported to the folder if missing there.

    Raises:
        Skip: no available interpreter can export them.
    """
    files = {name: folder / name_of(size) for name, size in SIZES.items()}
    about = folder / "yolo11n.json"
    if not all(path.is_file() for path in (*files.values(), about)):
        _export(folder)
    run = {name: _answer(session(onnxruntime, path), SIZES[name]) for name, path in files.items()}
    return Networks(run, {f"YOLO11n {k}": v for k, v in json.loads(about.read_text(encoding="utf-8")).items()})


def _export(folder: Path) -> None:
    """Export with this interpreter, or with that of TSR_ORACLES, depending on which has the package."""
    message = ""
    for python in (sys.executable, os.environ.get("TSR_ORACLES", "")):
        if not python:
            continue
        sizes = [f"{w}x{h}" for w, h in SIZES.values()]
        command = [python, "-m", "benchmarks.deep.yolo", str(folder.resolve()), *sizes]
        done = subprocess.run(command, cwd=ROOT.parent, capture_output=True, text=True, timeout=900)  # noqa: S603
        if done.returncode == 0:
            return
        message = (done.stderr.strip().splitlines() or [""])[-1]
    raise Skip(
        f"the package `ultralytics` could not build the network ({message}). Install the extra `bench`, or name an "
        "interpreter that has `ultralytics`, `torch` and `onnx` in TSR_ORACLES."
    )


def deep_networks(onnxruntime: ModuleType) -> dict[str, Contender]:
    """The small deep detector at 736x576, with onnxruntime and with the engine's plug-in.

    Raises:
        Skip: the detector was not trained, or `onnx`, which sets its input size, is not installed.
    """
    if not SIGNS.is_file():
        raise Skip(f"there is no trained network at `{SIGNS.relative_to(ROOT.parent)}`.")
    _need("onnx")
    from benchmarks.deep.onnx_file import resized

    size = SIZES[EQUAL]
    network = resized(SIGNS.read_bytes(), size)
    return {
        "small deep detector, 736x576": _answer(session(onnxruntime, network), size),
        "small deep detector, 736x576, OpenCV": OnnxDetector(network, size).detect,
    }


def _answer(network: Any, size: tuple[int, int]) -> Contender:  # Any: of ONNX Runtime, see session
    """Runs a network on the picture enlarged to the input size; the tensor is made before the timing."""
    name = network.get_inputs()[0].name
    kept: dict[int, NDArray[np.float32]] = {}

    def prepare(picture: Picture) -> NDArray[np.float32]:
        tensor = kept.get(id(picture))
        if tensor is None:
            kept.clear()
            canvas, _, _ = letterbox(picture, size)
            tensor = kept[id(picture)] = np.ascontiguousarray(cv2.dnn.blobFromImage(canvas, 1 / 255.0, swapRB=True))
        return tensor

    def run(picture: Picture) -> object:
        return network.run(None, {name: prepare(picture)})

    run.prepare = prepare  # type: ignore[attr-defined]
    return run
