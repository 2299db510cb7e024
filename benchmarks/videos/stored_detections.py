"""Stores one run of our detector over a video, so that every tracker gets the same boxes."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.cache import code, file_digest, table_digest
from tsr_engine.errors import TsrError
from tsr_engine.evaluation.track_tables import every_nth_frame
from tsr_engine.evidence import EvidenceReader
from tsr_engine.io.video import open_video
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, load_components
from tsr_engine.records import Detections, Picture
from tsr_engine.runs.track_video import RunRequest, track_video
from tsr_engine.track_table import TrackTable

STEPS = (
    "channels", "detection", "geometry", "io", "tracking/camera_shift.py", "tracking/focus_of_expansion.py",
    "runs/calibration.py",
)  # fmt: skip
"""Parts of the engine's code that detections depend on."""


@dataclass(frozen=True, slots=True)
class AnnotatedVideo:
    """A video with ground truth.

    Attributes:
        name: name of the clip.
        group: ``chosen on``, ``held out``, or the stress of a simulated approach.
        path: the file.
        truth: annotated boxes.
    """

    name: str
    group: str
    path: Path
    truth: TrackTable

    def digests(self) -> list[str]:
        """Digests of the file and of its ground truth."""
        return [file_digest(self.path), table_digest(self.truth)]


@dataclass(frozen=True, slots=True)
class DetectedFrame:
    """The input of a tracker for one frame.

    Attributes:
        ordinal: 0-based position in the video.
        seconds: presentation time.
        detections: detections of our detector, best first, with the score after the spatial prior.
        shift: global camera shift since the last frame, px (only our tracker uses it).
    """

    ordinal: int
    seconds: float
    detections: Detections
    shift: tuple[float, float]


@dataclass(frozen=True, slots=True)
class DetectedVideo:
    """A video with our detections.

    Attributes:
        video: the video and its ground truth.
        width: width of the pictures, px.
        height: height of the pictures, px.
        interval: nominal time between two frames, s.
        frames: every frame, in order.
        coast_foe_y: height of the camera's focus of expansion, estimated from the video, share of the picture's height;
            None: no estimate.
    """

    video: AnnotatedVideo
    width: int
    height: int
    interval: float
    frames: tuple[DetectedFrame, ...]
    coast_foe_y: float | None = None

    def with_focus(self, params: Params) -> Params:
        """Parameters with the camera's focus of expansion, as in a live run over the video."""
        if params.tracking.coast_foe_y is not None:
            return params
        return params.with_settings([("coast_foe_y", self.coast_foe_y)])


def detect_videos(
    videos: Sequence[AnnotatedVideo], store: Path, components: Components | None = None
) -> Iterator[DetectedVideo]:
    """Detect in each video once, with the shipped detector and the ``default`` preset.

    The result of an earlier call is reused if video, models, parameters and detection code are the same.

    Args:
        videos: videos to detect in.
        store: folder of the evidence, one run for each video.
        components: the engine's parts; unset: the shipped ones.
    """
    params = Params.preset("default")
    parts = load_components(params) if components is None else components
    for video in videos:
        folder = store / f"{file_digest(video.path)[:16]}-{code(STEPS)[:16]}"
        if not _is_current(folder, video.path, params, parts.models):
            track_video(RunRequest(video.path, params, evidence=folder, restart=True), parts)
        with EvidenceReader(folder) as reader:
            table, coast_foe_y = reader.header.frame_table, reader.header.parameters["tracking"]["coast_foe_y"]
            frames = tuple(
                DetectedFrame(f.ordinal, f.seconds, f.detections, (float(f.shift[0]), float(f.shift[1])))
                for f in reader.frames(pixels=False)
            )
        yield DetectedVideo(
            video, int(table["width"]), int(table["height"]), float(table["interval"]), frames, coast_foe_y
        )


def every_nth_frame_of(seen: DetectedVideo, step: int) -> DetectedVideo:
    """A video with only every ``step``-th frame, as from a camera of that rate.

    Detections stay the same. The camera shift is summed over the frames that are left out. Frames are renumbered, so
    the video's pixels do not belong to them.
    """
    frames, shift = [], np.zeros(2)
    for number, frame in enumerate(seen.frames):
        shift += frame.shift
        if number % step == 0:
            total = (float(shift[0]), float(shift[1]))
            frames.append(DetectedFrame(number // step, frame.seconds, frame.detections, total))
            shift = np.zeros(2)
    video = replace(seen.video, truth=every_nth_frame(seen.video.truth, step))
    return replace(seen, interval=seen.interval * step, frames=tuple(frames), video=video)


def pictures(seen: DetectedVideo) -> Iterator[tuple[DetectedFrame, Picture]]:
    """The frames with their pixels, decoded again."""
    with open_video(seen.video.path) as video:
        for frame, known in zip(video.frames(), seen.frames, strict=True):
            yield known, frame.picture


def _detection_parameters(parameters: JsonMapping) -> str:
    """The parameters that detections and camera shift depend on, without those of tracking."""
    tracking = parameters["tracking"]
    used = {name: tracking.get(name) for name in ("use_camera_shift", "shift_scale", "foe_x", "foe_y")}
    return json.dumps([parameters["detector"], parameters["prior"], used], sort_keys=True)


def _is_current(folder: Path, video: Path, params: Params, models: Mapping[str, str]) -> bool:
    """Whether the folder holds a finished run with the same inputs."""
    try:
        with EvidenceReader(folder) as reader:
            header = reader.header
            same = header.video.sha256 == file_digest(video) and dict(header.models) == dict(models)
            return (
                same
                and reader.state == "complete"
                and _detection_parameters(header.parameters) == _detection_parameters(params.model_dump())
            )
    except TsrError:  # a new store replaces any faulty one
        return False
