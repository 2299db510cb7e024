"""Runs the engine on annotated clips, with scores and times; shared by the experiments on clips.

A whole run of the shipped preset decodes and scans a video once, and its evidence is kept. Every other configuration
processes the same detections with the engine's core on the video's pixels, so that its results equal those of a
separate run.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.cache import Cache, file_digest, table_digest
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedFrame, DetectedVideo, detect_videos, pictures
from tsr_engine.detection.refine.box_inset import BoxInset
from tsr_engine.evaluation.track_tables import result_table
from tsr_engine.evaluation.tracking import SignReport, VideoReport, evaluate_video
from tsr_engine.evidence import FramePixels, ResultRow
from tsr_engine.geometry.boxes import clip
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, FrameInput, ResultStream, TrackingCore, load_components, one_blas_thread
from tsr_engine.records import Detections, FloatArray
from tsr_engine.track_table import TrackTable
from tsr_engine.tracking.camera_shift import CameraShift

Videos = Mapping[str, tuple[Path, TrackTable]]
"""Name of a video -> file and ground truth."""

_SHIPPED = Params.preset("default")
PAPER_KF = "the paper's KF alone"
CONFIGURATIONS: Mapping[str, Params] = {
    "default": _SHIPPED,
    "KF alone": _SHIPPED.with_settings([("use_online", False)]),
    PAPER_KF: Params.preset("paper")
    .model_copy(update={"detector": _SHIPPED.detector, "prior": _SHIPPED.prior})
    .with_settings([("use_online", False)]),
    "paper": Params.preset("paper"),
}
"""Configurations: as shipped; without the online detector; the paper's filter without it, on the same detections; the
paper's parameters."""

STAGES: Mapping[str, tuple[str, ...]] = {
    "detection": ("detect", "shift", "track", "gate", "learn", "relocalise"),
    "classification": ("classify", "fuse"),
}
"""The stages of the times of Tables I and II; decoding is not included."""

_INSET = ("inset_width", "inset_height", "inset_rise")
_TIMED = 10
"""Step between the frames in which the detector is timed."""


@dataclass(slots=True)
class Tracked:
    """One configuration over one video.

    Attributes:
        rows: result rows, as ``tsr track --csv`` writes them.
        stages: stage -> CPU seconds over all frames.
        frames: number of frames of the video.
    """

    rows: list[ResultRow] = field(default_factory=list)
    stages: dict[str, float] = field(default_factory=dict)
    frames: int = 0

    def spend(self, stage: str, seconds: float) -> None:
        """Add time to a stage."""
        self.stages[stage] = self.stages.get(stage, 0.0) + seconds


@dataclass(slots=True)
class Scored:
    """One configuration over all videos: a report for each, and the total times."""

    reports: list[VideoReport] = field(default_factory=list)
    stages: dict[str, float] = field(default_factory=dict)
    frames: int = 0

    def add(self, report: VideoReport, stages: Mapping[str, float]) -> None:
        """Add one video."""
        self.reports.append(report)
        self.frames += report.frames
        for stage, seconds in stages.items():
            self.stages[stage] = self.stages.get(stage, 0.0) + seconds

    def ms(self, module: str) -> float:
        """Mean CPU time per frame of one module of ``STAGES``, ms."""
        return 1e3 * sum(self.stages.get(stage, 0.0) for stage in STAGES[module]) / max(1, self.frames)


def score(videos: Videos, configurations: Mapping[str, Params], scratch: Path) -> dict[str, Scored]:
    """Track and score all videos with all configurations.

    Args:
        videos: name -> (file, ground truth).
        configurations: name -> parameters.
        scratch: folder for evidence and reports, which later calls use again.
    """
    cache = Cache(scratch / "tracked")
    components = {name: load_components(params) for name, params in configurations.items()}
    shipped = load_components(Params.preset("default"))
    scored = {name: Scored() for name in configurations}
    for title, (path, truth) in videos.items():
        video = AnnotatedVideo(title, "", path, truth)
        detect = partial(next, detect_videos([video], scratch / "detections", shipped))
        for name, found in reports_of(title, video, detect, configurations, components, cache).items():
            scored[name].add(*found)
    return scored


def reports_of(
    title: str,
    video: AnnotatedVideo,
    detect: Callable[[], DetectedVideo],
    configurations: Mapping[str, Params],
    components: Mapping[str, Components],
    cache: Cache,
) -> dict[str, tuple[VideoReport, Mapping[str, float]]]:
    """Report and stages of each configuration on a video; configurations without a stored report are tracked now.

    Args:
        title: name of these detections of the video.
        video: the video.
        detect: returns the detections; called only if a configuration must be tracked.
        configurations: name -> parameters.
        components: name -> models.
        cache: store of reports.
    """
    data = [title, file_digest(video.path), table_digest(video.truth)]
    inputs = {n: [*data, p.model_dump_json(), dict(components[n].models)] for n, p in configurations.items()}
    records = {name: cache.find(of) for name, of in inputs.items()}
    missing = {name: params for name, params in configurations.items() if records[name] is None}
    known = {name: (_report(record["report"]), record["stages"]) for name, record in records.items() if record}
    if missing:
        seen = detect()
        for name, run in track_together(seen, missing, components).items():
            known[name] = report_of(seen, run), run.stages
            cache.keep(inputs[name], {"report": asdict(known[name][0]), "stages": run.stages})
    return {name: known[name] for name in configurations}


def _report(record: JsonMapping) -> VideoReport:
    """The report of a record; JSON has no tuples."""
    signs = tuple(SignReport(**(sign | {"ids": tuple(sign["ids"])})) for sign in record["signs"])
    pairs = {name: tuple(map(tuple, record[name])) for name in ("errors", "matched")}
    lists = {name: tuple(record[name]) for name in ("followed_errors", "narrow_errors", "false_tracks")}
    return VideoReport(**{**record, **pairs, **lists, "signs": signs})


def report_of(seen: DetectedVideo, run: Tracked) -> VideoReport:
    """The report of a configuration on a video."""
    video = seen.video
    return evaluate_video(video.name, video.truth, result_table(run.rows), run.frames, size=(seen.width, seen.height))


def track_together(
    seen: DetectedVideo, configurations: Mapping[str, Params], components: Mapping[str, Components]
) -> dict[str, Tracked]:
    """Track one video with all configurations.

    Args:
        seen: the video with its detections.
        configurations: name -> parameters.
        components: name -> trained parts, loaded for those parameters.
    """
    clock = time.process_time  # wall time would include other work of the machine
    runs = {name: Tracked() for name in configurations}
    streams = {name: ResultStream() for name in configurations}
    cores = {
        name: TrackingCore(
            seen.with_focus(params), components[name].parts, seen.width, seen.height, interval=seen.interval
        )
        for name, params in configurations.items()
    }
    timed = next(iter(components.values())).detector
    tracking = Params.preset("default").tracking
    camera = CameraShift(tracking.shift_scale, (tracking.foe_x, tracking.foe_y))
    detect_seconds, shift_seconds, times = 0.0, 0.0, 0
    with one_blas_thread():
        timed.detect(np.zeros((seen.height, seen.width, 3), np.uint8))  # loads code, not timed
        for frame, picture in pictures(seen):
            if frame.ordinal % _TIMED == 0:
                began = clock()
                timed.detect(picture)
                detect_seconds, times = detect_seconds + clock() - began, times + 1
            began = clock()
            camera.step(picture)
            shift_seconds += clock() - began
            for name, params in configurations.items():
                began = clock()
                evidence = cores[name].step(_frame_input(frame, FramePixels(picture), params, seen))
                step_seconds = clock() - began
                run = runs[name]
                run.frames += 1
                run.rows.extend(streams[name].add(evidence))
                whole = sum(evidence.timings.values()) or 1.0
                for stage, seconds in evidence.timings.items():  # wall times; only their ratios count
                    run.spend(stage, step_seconds * seconds / whole)
    for name, run in runs.items():
        run.rows.extend(streams[name].finish())
        run.spend("shift", shift_seconds if configurations[name].tracking.use_camera_shift else 0.0)
        run.spend("detect", run.frames * detect_seconds / max(1, times))
    return runs


def with_other_inset(boxes: FloatArray, before: Params, now: Params, width: int, height: int) -> FloatArray:
    """Boxes of detections with another box inset.

    Args:
        boxes: shape (n, 4), with the box inset of ``before``.
        before: parameters of the run that found them.
        now: parameters with the wanted box inset.
        width: width of the picture, px.
        height: height of the picture, px.
    """
    drawn = BoxInset.of(now.detector).apply(BoxInset.of(before.detector).undo(boxes))
    return clip(drawn, width, height)


def _frame_input(frame: DetectedFrame, pixels: FramePixels, params: Params, seen: DetectedVideo) -> FrameInput:
    """The core's input for one frame in a run with these parameters.

    Raises:
        ValueError: the parameters would give other detections than the stored ones.
    """
    shipped = Params.preset("default")
    found = frame.detections
    if params.detector != shipped.detector or params.prior != shipped.prior:
        changed = {leaf for leaf, value in params.detector if value != getattr(shipped.detector, leaf)}
        if not changed <= set(_INSET) or params.prior != shipped.prior:
            raise ValueError(f"Expected the scan of the preset `default`, got other values of {sorted(changed)}.")
        boxes = with_other_inset(found.boxes, shipped, params, seen.width, seen.height)
        found = Detections(boxes, found.raw_scores, found.prior, found.scores)
    shift = frame.shift if params.tracking.use_camera_shift else (0.0, 0.0)
    return FrameInput(frame.ordinal, frame.seconds, found, shift, pixels)
