"""Runs our tracker on stored detections, with any parameters after detection, on the video's pixels."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from threading import Event
from typing import Any

from benchmarks.cache import Cache
from benchmarks.videos.stored_detections import DetectedFrame, DetectedVideo, pictures
from tsr_engine.evaluation.track_tables import result_table
from tsr_engine.evidence import FramePixels, ResultRow
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params import Params
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.pipeline import Components, FrameInput, Models, ResultStream, TrackingCore, one_blas_thread
from tsr_engine.records import Detections, FloatArray, Picture
from tsr_engine.track_table import TrackTable
from tsr_engine.tracking.track_status import TrackStatus
from tsr_engine.tracking.tracker import Tracker


@dataclass(slots=True)
class TrackingResult:
    """The result of one configuration on one video.

    Attributes:
        rows: all frames of confirmed tracks, as the product writes them.
        live: ``rows`` without the frames before a track was confirmed, as known during the drive.
        seconds: CPU time of all steps after detection, including classification.
    """

    rows: TrackTable
    live: TrackTable
    seconds: float

    def as_dict(self) -> JsonObject:
        """The result as exact JSON values."""
        return {"rows": _plain(self.rows), "live": _plain(self.live), "seconds": self.seconds}

    @classmethod
    def of(cls, record: JsonMapping) -> TrackingResult:
        """The reverse of ``as_dict``."""
        return cls(_results(record["rows"]), _results(record["live"]), float(record["seconds"]))


def filter_steps(
    frames: Sequence[DetectedFrame], params: TrackingParams, size: tuple[int, int], interval: float
) -> Iterator[tuple[DetectedFrame, Sequence[TrackStatus]]]:
    """Each frame with the tracks of the Kalman filter alone, without gate, online detector and classifier.

    Args:
        frames: frames with their detections.
        params: parameters of tracking.
        size: width and height of the pictures, px.
        interval: nominal time between two frames, s.
    """
    tracker = Tracker(params, *size)
    before: float | None = None
    for frame in frames:
        passed = 1.0 if before is None else max((frame.seconds - before) / interval, 1e-3)
        before = frame.seconds
        yield frame, tracker.step(frame.ordinal, frame.detections, passed, frame.shift).tracks


def filter_alone(seen: DetectedVideo, params: Params) -> TrackTable:
    """The Kalman filter without gate, online detector and classifier: rows of confirmed tracks, class 0.

    It reads no pixels.
    """
    rows: dict[int, list[tuple[int, int, FloatArray, int, float, str]]] = {}
    confirmed: set[int] = set()
    tracking = seen.with_focus(params).tracking
    for frame, tracks in filter_steps(seen.frames, tracking, (seen.width, seen.height), seen.interval):
        for t in tracks:
            rows.setdefault(t.track_id, []).append((frame.ordinal, t.track_id, t.box, 0, t.score, t.source))
            if t.state == "confirmed":
                confirmed.add(t.track_id)
    return TrackTable.of_rows(sorted((row for track in confirmed for row in rows[track]), key=lambda row: row[:2]))


_WARM = Event()
"""Set after the first video of this process, so that no time includes the compilation or loading of kernels."""


def _plain(rows: TrackTable) -> list[list[object]]:
    columns = (rows.frame, rows.track, rows.boxes, rows.class_id, rows.score)
    return [list(row) for row in zip(*(column.tolist() for column in columns), rows.source_words(), strict=True)]


def _results(rows: list[list[Any]]) -> TrackTable:  # Any: values of a JSON record
    return TrackTable.of_rows((f, t, box, c, s, source) for f, t, box, c, s, source in rows)


@dataclass(slots=True)
class _Run:
    """The state of one configuration during a video."""

    core: TrackingCore
    use_shift: bool
    stream: ResultStream = field(default_factory=ResultStream)
    settled: list[ResultRow] = field(default_factory=list)
    live: list[tuple[int, int, FloatArray, int, float, str]] = field(default_factory=list)
    seconds: float = 0.0

    def take(self, given: FrameInput) -> None:
        began = time.thread_time()
        frame = self.core.step(given)
        self.seconds += time.thread_time() - began
        self.settled.extend(self.stream.add(frame))
        for t in frame.tracks:
            if t.state == "confirmed":
                self.live.append((frame.ordinal, t.track_id, t.box, 0, float(t.score), t.source))

    def finish(self) -> TrackingResult:
        self.settled.extend(self.stream.finish())
        return TrackingResult(result_table(self.settled), TrackTable.of_rows(self.live), self.seconds)


def start(seen: DetectedVideo, params: Params, parts: Models) -> TrackingCore:
    """A new core for a video."""
    return TrackingCore(seen.with_focus(params), parts, seen.width, seen.height, interval=seen.interval)


def frame_input(
    frame: DetectedFrame, picture: Picture, *, use_shift: bool, detections: Detections | None = None
) -> FrameInput:
    """The core's input for one frame, as in a live run.

    Args:
        frame: the frame with its detections.
        picture: its pixels.
        use_shift: whether the parameters use the camera shift.
        detections: detections to use; unset: the stored ones.
    """
    return FrameInput(
        frame.ordinal,
        frame.seconds,
        frame.detections if detections is None else detections,
        frame.shift if use_shift else (0.0, 0.0),
        FramePixels(picture),
    )


def track_with_engine(
    seen: DetectedVideo, configurations: Mapping[str, tuple[Params, Components]], cache: Cache
) -> dict[str, TrackingResult]:
    """Track one video with several configurations; it is decoded once.

    All configurations use the detections of ``seen``.

    Args:
        seen: the video with its detections.
        configurations: parameters and trained parts by name.
        cache: store of earlier results.

    Returns:
        The result of each configuration by its name.
    """
    inputs = ["followed", seen.video.digests(), configuration_inputs(configurations)]
    records = cache.get(inputs, lambda: {n: f.as_dict() for n, f in _follow(seen, configurations).items()})
    return {name: TrackingResult.of(record) for name, record in records.items()}


def configuration_inputs(configurations: Mapping[str, tuple[Params, Components]]) -> JsonObject:
    """All inputs of the results of configurations, besides the code."""
    return {
        name: [params.model_dump(mode="json"), dict(components.models)]
        for name, (params, components) in configurations.items()
    }


def _follow(seen: DetectedVideo, configurations: Mapping[str, tuple[Params, Components]]) -> dict[str, TrackingResult]:
    if not _WARM.is_set():
        _WARM.set()
        _follow(seen, configurations)
    runs = {
        name: _Run(start(seen, params, components.parts), params.tracking.use_camera_shift)
        for name, (params, components) in configurations.items()
    }
    with one_blas_thread():
        for frame, picture in pictures(seen):
            for run in runs.values():
                run.take(frame_input(frame, picture, use_shift=run.use_shift))
    return {name: run.finish() for name, run in runs.items()}
