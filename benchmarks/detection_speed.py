"""CPU time of the offline detector at 720x576, signs from 16 px, one thread, median over scenes.

    python benchmarks/detection_speed.py --gtsdb GTSDB [--scenes 40]

Scenes are shrunk to 720x576; models and parameters are those that ship, the very ones whose AP is reported.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from tsr_engine.channels.pyramid import build_pyramid
from tsr_engine.detection.scan import scan_level
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.params import Params
from tsr_engine.pipeline import load_detector


def median_ms(work: Callable[[Any], object], inputs: list[Any]) -> float:
    """Median CPU time of this thread, ms; the first call, which may compile, is left out."""
    work(inputs[0])
    times = []
    for item in inputs:
        began = time.thread_time()
        work(item)
        times.append(time.thread_time() - began)
    return float(np.median(times)) * 1e3


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gtsdb", type=Path, required=True)
    parser.add_argument("--scenes", type=int, default=40)
    args = parser.parse_args()
    cv2.setNumThreads(1)
    scenes = read_gtsdb(args.gtsdb)
    step = max(1, len(scenes) // args.scenes)
    pictures = [
        cv2.resize(cv2.imread(str(scene.path)), (720, 576), interpolation=cv2.INTER_AREA)
        for scene in scenes[::step][: args.scenes]
    ]
    detector = load_detector(Params().with_settings([("second_core", False)]))
    model, params = detector.model, detector.params
    scales, bands = detector.search(720, 576)

    def pyramid(picture: Any) -> list[Any]:
        return list(build_pyramid(picture, scales, model.plan, bands, border=model.window.pad))

    def scan(levels: list[Any]) -> None:
        for level in levels:
            scan_level(level.cells, model.cascade, params.dense_trees, detector.prepared(level))

    print(f"{len(pictures)} scenes at 720x576, one thread, median CPU ms")
    print(f"  pyramid          {median_ms(pyramid, pictures):7.1f}")
    print(f"  scan             {median_ms(scan, [pyramid(p) for p in pictures[:10]]):7.1f}")
    print(f"  whole detection  {median_ms(detector.detect, pictures):7.1f}")


if __name__ == "__main__":
    main()
