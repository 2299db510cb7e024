"""CPU time of the offline detector at 720x576, signs from 16 px, one thread, median over scenes.

    python -m benchmarks.timing.detection --gtsdb GTSDB [--scenes 40]

Scenes are reduced to 720x576. Models and parameters are the shipped ones, whose AP is reported.
"""

from __future__ import annotations

import argparse
from collections import deque
from collections.abc import Iterator, Mapping
from pathlib import Path

import cv2

from benchmarks.timing.alternating import Contender, scenes_in_turn
from tsr_engine.channels.pyramid import Level, build_pyramid
from tsr_engine.channels.scratch import Scratch
from tsr_engine.detection.acf import AcfDetector
from tsr_engine.detection.scan import scan_level
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.params import Params
from tsr_engine.pipeline import load_detector, one_opencv_thread
from tsr_engine.records import Picture

TURNS = 5
"""Number of runs on each picture; the shortest time counts."""


def shrunk_scenes(folder: Path, count: int) -> list[Picture]:
    """Scenes of a GTSDB folder shrunk to 720x576, evenly chosen."""
    scenes = read_gtsdb(folder)
    step = max(1, len(scenes) // count)
    return [
        cv2.resize(cv2.imread(str(scene.path)), (720, 576), interpolation=cv2.INTER_AREA)
        for scene in scenes[::step][:count]
    ]


class _Scan:
    """The cascade without the pyramid, whose levels :meth:`prepare` makes."""

    def __init__(self, detector: AcfDetector) -> None:
        self._detector = detector
        self._levels: list[Level] = []

    def prepare(self, picture: Picture) -> None:
        """Make the levels."""
        self._levels = list(_levels(self._detector, picture))

    def __call__(self, picture: Picture) -> None:
        """Scan them."""
        detector = self._detector
        for level in self._levels:
            scan_level(level.cells, detector.model.cascade, detector.params.dense_trees, detector.nodes_for(level))


def _levels(detector: AcfDetector, picture: Picture, scratch: Scratch | None = None) -> Iterator[Level]:
    scales, bands = detector.search(picture.shape[1], picture.shape[0])
    return build_pyramid(picture, scales, detector.model.plan, bands, border=detector.window.pad, scratch=scratch)


def time_stages(pictures: list[Picture]) -> dict[str, float]:
    """Median CPU ms of pyramid, cascade and whole detection with the shipped models and settings on one thread."""
    with one_opencv_thread():
        detector = load_detector(Params().with_settings([("second_core", False)]))
        scratch = Scratch()
        work: Mapping[str, Contender] = {
            "pyramid": lambda picture: deque(_levels(detector, picture, scratch), maxlen=0),
            "scan": _Scan(detector),
            "whole": detector.detect,
        }
        turns = scenes_in_turn(work, pictures, TURNS)
        return {name: turns.median(name) for name in turns.names}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gtsdb", type=Path, required=True)
    parser.add_argument("--scenes", type=int, default=40)
    args = parser.parse_args()
    pictures = shrunk_scenes(args.gtsdb, args.scenes)
    found = time_stages(pictures)
    print(f"{len(pictures)} scenes at 720x576, one thread, CPU ms: median of the least of {TURNS} turns")
    for name, ms in found.items():
        print(f"  {name:15} {ms:6.1f}")


if __name__ == "__main__":
    main()
