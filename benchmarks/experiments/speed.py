"""Time of the offline detector by stage at 720x576."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2

from benchmarks.detection_speed import median_ms
from benchmarks.experiment import Data, Experiment, Result, machine, table
from tsr_engine.channels.pyramid import build_pyramid
from tsr_engine.detection.scan import scan_level
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.params import Params
from tsr_engine.pipeline import load_detector
from tsr_engine.records import Picture

__all__ = ["EXPERIMENT", "shrunk_scenes"]

SCENES = 40


def shrunk_scenes(folder: Path, count: int) -> list[Picture]:
    """Scenes of a GTSDB folder shrunk to 720x576, evenly chosen."""
    scenes = read_gtsdb(folder)
    step = max(1, len(scenes) // count)
    return [
        cv2.resize(cv2.imread(str(scene.path)), (720, 576), interpolation=cv2.INTER_AREA)
        for scene in scenes[::step][:count]
    ]


def _run(data: Data) -> Result:
    pictures = shrunk_scenes(data.need("gtsdb"), SCENES)
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        detector = load_detector(Params().with_settings([("second_core", False)]))
        model, params = detector.model, detector.params
        scales, bands = detector.search(720, 576)

        def pyramid(picture: Any) -> list[Any]:
            return list(build_pyramid(picture, scales, model.plan, bands, border=model.window.pad))

        def scan(levels: list[Any]) -> None:
            for level in levels:
                scan_level(level.cells, model.cascade, params.dense_trees, detector.prepared(level))

        figures = {
            "pyramid": median_ms(pyramid, pictures),
            "scan": median_ms(scan, [pyramid(p) for p in pictures[:10]]),
            "whole": median_ms(detector.detect, pictures),
        }
    finally:
        cv2.setNumThreads(threads)
    return Result(
        "speed",
        data=f"{len(pictures)} GTSDB scenes shrunk to 720x576, signs from 16 px, one thread, median CPU ms, the "
        "shipped models and settings.",
        figures=figures,
        machine=machine(),
    )


def _tell(result: Result) -> str:
    f = result.figures
    return (
        table(
            [
                ["stage", "ms"],
                ["channel pyramid", f"{f['pyramid']:.1f}"],
                ["cascade", f"{f['scan']:.1f}"],
                ["whole detection", f"{f['whole']:.1f}"],
                ["*first bar, aim*", "*35, 15*"],
            ]
        )
        + "\nMilliseconds belong to this machine and to what else it did; *Time beside a deep network of today* has "
        "the ratios.\n"
    )


EXPERIMENT = Experiment(
    "speed",
    "Detection time",
    "How long does a picture take on one core?",
    _run,
    _tell,
)
