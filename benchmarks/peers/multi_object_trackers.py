"""Trackers of the package ``trackers`` (Roboflow, Apache-2.0): SORT, ByteTrack, OC-SORT, C-BIoU.

They get only boxes and confidences, and return the detections to which they gave an identity.
"""

from __future__ import annotations

import importlib
import itertools
import time
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.experiment import version
from benchmarks.videos.stored_detections import DetectedVideo
from tsr_engine.records import Detections, FloatArray
from tsr_engine.track_table import TrackTable

PACKAGE = "trackers"
MIN_SCORE_SETTING = "least_score"
"""Name of our own setting: a peer does not get detections below this score."""


class Missing(Exception):
    """A peer cannot be run here; the sentence says why."""


@dataclass(frozen=True, slots=True)
class Peer:
    """One tracker and the grid of its settings.

    Attributes:
        name: name in its paper.
        class_name: name in the package ``trackers``.
        grid: values of each setting; names that end in ``_score`` are scores of our detector.
        scored: settings of the tracker that are confidences -> their names in the grid.
    """

    name: str
    class_name: str
    grid: Mapping[str, tuple[float, ...]]
    scored: Mapping[str, str]

    def settings(self) -> Iterator[dict[str, float]]:
        """Every combination of the grid, in order."""
        for values in itertools.product(*self.grid.values()):
            yield dict(zip(self.grid, values, strict=True))

    def make(self, rate: float, settings: Mapping[str, float]) -> Any:  # Any: the package may be missing
        """Make a new tracker.

        Args:
            rate: frames per second.
            settings: a combination of the grid.

        Raises:
            Missing: the package is not installed, or does not have the tracker or a setting.
        """
        package = load(PACKAGE)
        kind = getattr(package, self.class_name, None)
        if kind is None:
            raise Missing(f"the package {PACKAGE} {version(PACKAGE)} has no {self.class_name}.")
        own = {self.scored.get(name, name): value for name, value in settings.items() if name != MIN_SCORE_SETTING}
        own |= {self.scored[name]: float(confidence(settings[name])) for name in self.scored if name in settings}
        try:
            return kind(frame_rate=rate, **own)
        except TypeError as error:
            raise Missing(f"{self.class_name} of {PACKAGE} {version(PACKAGE)} takes other settings: {error}.") from None


def load(package: str) -> ModuleType:
    """Import a package that is not part of the product.

    Raises:
        Missing: the package is not installed, or cannot be imported.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return importlib.import_module(package)
    except ImportError as error:
        raise Missing(
            f"the package {package} cannot be imported ({error}); `pip install -e '.[bench]'` brings it."
        ) from None


def confidence(score: ArrayLike) -> FloatArray:
    """Convert scores of our detector to confidences in (0, 1), which the peers expect; the order stays."""
    return 1.0 / (1.0 + np.exp(-np.asarray(score, dtype=np.float64)))


def track_with_peer(peer: Peer, seen: DetectedVideo, settings: Mapping[str, float]) -> tuple[TrackTable, float]:
    """Run a peer over a video.

    Returns:
        Its rows, which are the detections with an identity; and its CPU seconds.

    Raises:
        Missing: see :meth:`Peer.make`.
    """
    tracker = peer.make(1.0 / seen.interval, settings)
    boxes_of = load("supervision").Detections
    rows: list[tuple[int, int, FloatArray, int, float, str]] = []
    seconds = 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for frame in seen.frames:
            given = _handed(frame.detections, settings)
            began = time.thread_time()
            # All have class 0, since the comparison is about places, not classes.
            found = tracker.update(
                boxes_of(
                    xyxy=given.boxes.astype(np.float64),
                    confidence=confidence(given.scores),
                    class_id=np.zeros(len(given), dtype=int),
                )
            )
            seconds += time.thread_time() - began
            if found.tracker_id is None:
                continue
            for box, identity, score in zip(found.xyxy, found.tracker_id, found.confidence, strict=True):
                if identity >= 0:
                    rows.append((frame.ordinal, int(identity), np.asarray(box), 0, float(score), "detected"))
    return TrackTable.of_rows(rows), seconds


def _handed(detections: Detections, settings: Mapping[str, float]) -> Detections:
    least = settings.get(MIN_SCORE_SETTING)
    return detections if least is None else detections.select(detections.scores >= least)


PEERS: tuple[Peer, ...] = (
    Peer(
        "SORT",
        "SORTTracker",
        {
            MIN_SCORE_SETTING: (-2.0, 0.0),
            "activation_score": (-1.0, 0.0, 1.0),
            "minimum_consecutive_frames": (1, 3),
            "minimum_iou_threshold": (0.1, 0.3),
        },
        {"activation_score": "track_activation_threshold"},
    ),
    Peer(
        "ByteTrack",
        "ByteTrackTracker",
        {
            "activation_score": (-1.0, 0.0, 1.0),
            "high_score": (-1.0, 0.0),
            "minimum_consecutive_frames": (1, 3),
            "minimum_iou_threshold": (0.1, 0.3),
        },
        {"activation_score": "track_activation_threshold", "high_score": "high_conf_det_threshold"},
    ),
    Peer(
        "OC-SORT",
        "OCSORTTracker",
        {
            "high_score": (-1.0, 0.0, 1.0),
            "minimum_consecutive_frames": (1, 3),
            "minimum_iou_threshold": (0.1, 0.3),
            "direction_consistency_weight": (0.0, 0.2),
        },
        {"high_score": "high_conf_det_threshold"},
    ),
    Peer(
        "C-BIoU",
        "CBIoUTracker",
        {
            "activation_score": (-1.0, 0.0),
            "high_score": (-1.0, 0.0),
            "minimum_consecutive_frames": (1, 2),
            "buffer_ratio_first": (0.3, 0.5),
            "buffer_ratio_second": (0.5, 1.0),
        },
        {"activation_score": "track_activation_threshold", "high_score": "high_conf_det_threshold"},
    ),
)
"""The peers and their grids, within the ranges that the package itself searches; other settings keep its defaults."""
