"""Tracks a video frame by frame in flat memory, and writes evidence, result rows and an annotated video.

A run with an evidence folder can be killed at any time. The next call with the same folder replays the stored frames
since the last one without tracks, which rebuilds the tracker, and continues after the last stored frame.
"""

from __future__ import annotations

import time
from array import array
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import replace

from tsr_engine.errors import InputError, StorageError, VideoError
from tsr_engine.evidence import FramePixels, RunHeader, TableEntry, VideoIdentity, read_header
from tsr_engine.evidence.schema import RUN_FILE
from tsr_engine.io.read_ahead import read_ahead
from tsr_engine.io.video import Frame, Video, open_video
from tsr_engine.params import Params
from tsr_engine.pipeline import (
    Components,
    Detected,
    FrameInput,
    TrackingCore,
    VideoDetector,
    detect_in_parallel,
    replay_regions,
)
from tsr_engine.records import FrameEvidence
from tsr_engine.runs.calibration import with_focus
from tsr_engine.runs.outputs import RunOutputs, refuse_outputs
from tsr_engine.runs.report import Progress, RunReport, RunRequest
from tsr_engine.runs.run_evidence import RunEvidence
from tsr_engine.tracking.camera_shift import CameraShift
from tsr_engine.tracking.focus_of_expansion import Focus

__all__ = ["Progress", "RunReport", "RunRequest", "track_video"]

READ_AHEAD_FRAMES = 4
"""Frames that are decoded ahead of the engine."""


def track_video(
    request: RunRequest,
    components: Components,
    *,
    progress: Callable[[Progress], None] | None = None,
    focus_progress: Callable[[int, int | None], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> RunReport:
    """Track one video.

    Args:
        request: what to do.
        components: detector and trained parts.
        progress: called after each frame.
        focus_progress: called while the camera is estimated from the drive, before the first frame, with the number of
            frames done and the largest number to do.
        stop: called before each frame; if it returns true, the run ends as interrupted and its outputs are complete up
            to then.

    Returns:
        The report. Outputs of an interrupted or failed run hold the frames up to then. A run that is stopped while its
        camera is estimated has no outputs.

    Raises:
        VideoError: the video cannot be opened or decoded.
        EvidenceError: the evidence folder belongs to something else.
        StorageError: an output cannot be written.
        ExportError: the annotated video cannot be encoded.
        UsageError: an output is the input or has a name of another kind, or the range lies beyond the end.
    """
    refuse_outputs(request)
    stop = stop or (lambda: False)
    with open_video(request.video, limits=request.limits) as video:
        started = time.perf_counter()
        params, focus = _with_focus(request, stop, focus_progress)
        run = _Run(replace(request, params=params), components, video, progress, stop)
        run.report.focus, run.report.focus_seconds = focus, time.perf_counter() - started
        if stop():
            run.report.interrupted = True
            return run.report
        return run.execute()


def _with_focus(
    request: RunRequest, stop: Callable[[], bool], focus_progress: Callable[[int, int | None], None] | None
) -> tuple[Params, Focus | None]:
    """Parameters with the camera's focus, and the estimate if this call made one.

    The focus is that of the parameters, else the estimate of the resumed run, else the estimate from the drive. A run
    whose focus was set is resumed only with the same setting, as with every other parameter.
    """
    params, folder = request.params, request.evidence
    if params.tracking.coast_foe_y is not None or request.restart or folder is None or not (folder / RUN_FILE).exists():
        return with_focus(params, request.video, stop, limits=request.limits, progress=focus_progress)
    header = read_header(folder)
    if not header.frame_table.get("focus_estimated", True):  # runs of earlier versions do not say
        return params, None
    stored = header.parameters.get("tracking", {})
    return params.with_settings([("coast_foe_y", stored.get("coast_foe_y"))]), None


class _Run:
    """The state of one call of ``track_video``."""

    def __init__(
        self,
        request: RunRequest,
        components: Components,
        video: Video,
        progress: Callable[[Progress], None] | None,
        stop: Callable[[], bool],
    ) -> None:
        self.request = request
        self.components = components
        self.detector = VideoDetector(components.detector, single_core=request.cores > 1)
        self.video = video
        self.progress = progress
        self.stop = stop
        self.report = RunReport(
            video.path.name,
            video.width,
            video.height,
            first_frame=request.start,
            params=request.params,
            class_names=components.parts.names,
        )
        self.outputs = RunOutputs(request, video, components.parts.names)
        # The interval comes from the packets even if a decoded table is given, so that it does not depend on the table.
        table = video.table
        self.frames, self.interval, self.time_base = len(table), float(table.interval()), table.time_base
        if request.table is not None and not video.adopt(request.table):
            raise VideoError(f"{request.video} does not match its frame table. Add the video again.")
        self.evidence: RunEvidence | None = None

    def execute(self) -> RunReport:
        started = time.perf_counter()
        failure: BaseException | None = None
        with ExitStack() as stack:
            self._open_outputs(stack)
            try:
                last = None if self.evidence is None else self.evidence.last_frame
                for frame in () if self.evidence is None else self.evidence.earlier_frames(self.video):
                    self._record(frame)
                self.report.resumed_at = None if last is None else last + 1
                self._compute(last, started)
            except BaseException as error:
                if not self.report.frames:
                    raise
                failure = error
            failure = self._finish(failure)
        self.report.seconds = time.perf_counter() - started
        if failure is not None:
            raise failure
        return self.report

    def _open_outputs(self, stack: ExitStack) -> None:
        """Open the outputs; evidence last, so that an error of another output leaves an earlier run untouched."""
        if start := self.request.start:  # reading its frame raises an error if the range begins behind the last frame
            next(self.video.frames(start, start + 1), None)
        self.outputs.open(stack)
        if self.request.evidence is not None:
            self.evidence = RunEvidence(self.request.evidence, self.request, self._header())
            self.interval = self.evidence.interval
            stack.callback(self.evidence.writer.abandon)

    def _header(self) -> RunHeader:
        """The evidence's header of the run."""
        file = self.video.file
        return RunHeader(
            video=VideoIdentity(file.path.name, file.sha256(), file.status.st_size),
            parameters=self.request.params.model_dump(mode="json"),
            models=dict(self.components.models),
            labels=self.components.labels,
            frame_table={
                "time_base": str(self.time_base),
                "frames": self.frames,
                "width": self.video.width,
                "height": self.video.height,
                "rotation": self.video.rotation,
                "interval": self.interval,
                "learned_lambda": self.components.learned_lambda,
                "focus_estimated": self.report.focus is not None,
            },
        )

    def _core(self, last: int | None) -> TrackingCore:
        """A new core, or that of the resumed run after frame ``last``."""
        params, parts = self.request.params, self.components.parts
        if last is None or self.evidence is None:
            return TrackingCore(params, parts, self.video.width, self.video.height, interval=self.interval)
        return self.evidence.core(params, parts, last)

    def _compute(self, last: int | None, started: float) -> None:
        """Process all frames after the last stored one."""
        request = self.request
        core = self._core(last)
        tracking = request.params.tracking
        shift = CameraShift(tracking.shift_scale, (tracking.foe_x, tracking.foe_y))
        stored = self.evidence.frames() if self.evidence is not None and self.outputs.has_video else None
        first = request.start if last is None or self.outputs.has_video else last
        if request.stop is not None and last is not None and last + 1 >= request.stop and not self.outputs.has_video:
            return
        total = self._total()
        frames = self.video.frames(first, request.stop)
        decoded = read_ahead(lambda: _timed_frames(frames), READ_AHEAD_FRAMES)
        source = detect_in_parallel(
            decoded, self.detector.detect, request.cores, lambda f: last is None or f.ordinal > last
        )
        try:
            for frame, decode_seconds, detected in source:
                if self.stop():
                    self.report.interrupted = True
                    break
                if detected is None:  # an earlier call has computed it
                    if frame.ordinal == last:
                        shift.step(frame.picture)
                    if stored is not None:
                        self._annotate(frame, next(stored))
                    continue
                evidence = self._process_frame(core, shift, frame, decode_seconds, detected)
                self._record(evidence)
                self._annotate(frame, evidence)
                if self.report.computed == 1:
                    self.report.first_seconds = time.perf_counter() - started
                self._show_progress(total, started)
        finally:
            source.close()  # type: ignore[attr-defined]
            decoded.close()  # type: ignore[attr-defined]
        if not self.report.frames and not self.report.interrupted:
            raise InputError(f"{request.video} has no frame {request.start}. Choose a smaller start of --frames.")

    def _process_frame(
        self, core: TrackingCore, shift: CameraShift, frame: Frame, decode_seconds: float, detected: Detected
    ) -> FrameEvidence:
        clock = time.perf_counter
        detections, detect_seconds = detected
        seconds = {"decode": decode_seconds, "detect": detect_seconds}
        shift_start = clock()
        camera_shift = shift.step(frame.picture) if self.request.params.tracking.use_camera_shift else (0.0, 0.0)
        step_start = clock()
        seconds["shift"] = step_start - shift_start
        pixels = FramePixels(frame.picture)
        revisit = self.detector.revisit(frame.picture, detections)
        evidence = core.step(FrameInput(frame.ordinal, frame.seconds, detections, camera_shift, pixels, revisit))
        seconds |= evidence.timings
        evidence_start = clock()
        if self.evidence is not None:
            regions = replay_regions(evidence, pixels, self.request.params)
            evidence = replace(evidence, regions=regions, timings=seconds)
            entry = TableEntry(int(frame.time / self.time_base), frame.key, frame.corrupt)
            self.evidence.writer.append(evidence, entry)
            seconds["evidence"] = clock() - evidence_start
        for stage, value in seconds.items():
            self.report.stages.setdefault(stage, array("d")).append(value)
        total = clock() - shift_start + (detect_seconds if self.request.cores == 1 else 0.0)
        self.report.stages.setdefault("whole frame", array("d")).append(total)
        self.report.computed += 1
        return replace(evidence, timings=seconds)

    def _record(self, frame: FrameEvidence) -> None:
        """Count a frame and write the rows that are final with it."""
        self.report.frames += 1
        self.report.events.update(event.kind for event in frame.events)
        self.outputs.add(frame)

    def _annotate(self, frame: Frame, evidence: FrameEvidence) -> None:
        if self.outputs.has_video:
            started = time.perf_counter()
            self.outputs.draw(frame, evidence)
            self.report.stages.setdefault("annotate", array("d")).append(time.perf_counter() - started)

    def _total(self) -> int | None:
        expected = self.video.expected
        end = expected if self.request.stop is None else min(self.request.stop, expected or self.request.stop)
        return None if end is None else max(0, end - self.request.start)

    def _show_progress(self, total: int | None, started: float) -> None:
        if self.progress is None:
            return
        rate = self.report.rate(time.perf_counter() - started)
        remaining = None if total is None or rate is None else max(0, total - self.report.frames) / rate
        self.progress(Progress(self.report.frames, total, rate, remaining))

    def _finish(self, failure: BaseException | None) -> BaseException | None:
        """Close the outputs with the frames up to now; they are readable after a failure, too.

        Returns:
            The given failure, or else that of writing the last rows, which does not keep other outputs from closing.
        """
        try:
            self.outputs.finish()
        except StorageError as error:
            failure = failure or error
        self.report.tracks = self.outputs.tracks
        self.report.warnings = self.video.warnings + self.outputs.warnings
        if self.evidence is not None:
            with suppress(*(() if failure is None else (StorageError,))):
                self.evidence.close(self.report, failure)
        self.outputs.close_video(failed=failure is not None)
        return failure


def _timed_frames(frames: Iterator[Frame]) -> Iterator[tuple[Frame, float]]:
    """Each frame with its decoding time, s."""
    while True:
        started = time.perf_counter()
        frame = next(frames, None)
        if frame is None:
            return
        yield frame, time.perf_counter() - started
