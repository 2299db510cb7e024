"""One step of Algorithm 3: from detections and pixels to all decisions about a frame. No input or output.

::

    predict -> associate -> gate each predicted crop -> learn, correct or relocalise -> births and deaths
            -> classify each result -> fuse the votes of its track

Live runs and replays use the same code, because it reads pixels only through ``PixelSource.crop``.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from tsr_engine.gating.gate import Gate
from tsr_engine.geometry.boxes import MIN_SIDE, area, clip, to_cxcywh
from tsr_engine.linear_algebra import dot, solve
from tsr_engine.params import Params
from tsr_engine.pipeline.event_texts import (
    rejected_event,
    relabelled_event,
    relocalised_event,
    search_event,
    too_far_event,
)
from tsr_engine.pipeline.frame_input import FrameInput
from tsr_engine.pipeline.track_context import Models, TrackContext
from tsr_engine.protocols import FULL_QUALITY, MeasurementQuality, PixelSource
from tsr_engine.recognition.crops import cut_pixels
from tsr_engine.records import (
    Event,
    FloatArray,
    FrameEvidence,
    GateVerdict,
    Prediction,
    Recognition,
    Relocalisation,
    Sample,
    Source,
    TrackFrame,
)
from tsr_engine.tracking.track_status import TrackedFrame, TrackStatus
from tsr_engine.tracking.tracker import Tracker

_MIN_STEP, _MAX_STEP = 1e-3, 250.0
"""Limits on the time between two frames, in nominal intervals."""


class TrackingCore:
    """The engine's decisions for one video; deterministic.

    Args:
        params: all parameters of the run.
        parts: the trained parts.
        width: width of the pictures, px.
        height: height of the pictures, px.
        interval: nominal time between two frames, seconds.
        first_id: id of the first track; a resumed run continues the count.
    """

    def __init__(
        self, params: Params, parts: Models, width: int, height: int, *, interval: float, first_id: int = 1
    ) -> None:
        self.params = params
        self._models = parts
        self._width, self._height = width, height
        self._interval = interval
        self._tracker = Tracker(params.tracking, width, height, first_id=first_id)
        self._gate = Gate(params.gate)
        self._track_contexts: dict[int, TrackContext] = {}
        self._clock: float | None = None

    def step(self, frame: FrameInput) -> FrameEvidence:
        """Process the next frame in presentation order.

        Returns:
            The frame's evidence, with timings of the stages and without regions.
        """
        seconds: dict[str, float] = {}
        decisions: dict[int, _Decision] = {}
        events: list[Event] = []
        with _timed(seconds, "track"):
            predictions = self._tracker.predict(self._advance(frame.seconds), frame.shift)
        if frame.revisit is not None and predictions:
            with _timed(seconds, "revisit"):
                expected = [p.box for p in predictions.values() if self._visible(p.box)]
                completed = frame.revisit(np.array(expected).reshape(-1, 4))
            frame = replace(frame, detections=completed, revisit=None)
        with _timed(seconds, "track"):
            matches = self._tracker.associate(frame.detections)
        for track_id, prediction in predictions.items():
            detection = matches.get(track_id)
            detected = None if detection is None else frame.detections.boxes[detection]
            decisions[track_id] = self._update_track(frame, track_id, prediction, detected, seconds, events)
        with _timed(seconds, "track"):
            tracked = self._tracker.finish(frame.ordinal)
        live_ids = {status.track_id for status in tracked.tracks}
        for status in tracked.tracks:
            decision = decisions.setdefault(status.track_id, _Decision(None, None, ()))
            self._remember(frame, status, decision, seconds)
        recognitions = self._recognise(frame, tracked, seconds, events)
        tracks = [_track_frame(status, decisions[status.track_id], recognitions) for status in tracked.tracks]
        for track_id, prediction in predictions.items():
            if track_id not in live_ids:
                tracks.append(_last_frame(track_id, prediction, matches.get(track_id), decisions[track_id]))
                self._track_contexts.pop(track_id, None)
        return FrameEvidence(
            ordinal=frame.ordinal,
            seconds=frame.seconds,
            width=self._width,
            height=self._height,
            detections=frame.detections,
            shift=frame.shift,
            tracks=tuple(tracks),
            events=(*events, *tracked.events),
            regions=(),
            timings=seconds,
        )

    def skip(self, seconds: float) -> None:
        """Set the clock to the time of a frame without tracks, which is not processed again."""
        self._clock = seconds

    def _advance(self, seconds: float) -> float:
        """Nominal frame intervals since the previous frame."""
        before, self._clock = self._clock, seconds
        if before is None:
            return 1.0
        return min(max((seconds - before) / self._interval, _MIN_STEP), _MAX_STEP)

    def _update_track(
        self,
        frame: FrameInput,
        track_id: int,
        prediction: Prediction,
        detected: FloatArray | None,
        seconds: dict[str, float],
        events: list[Event],
    ) -> _Decision:
        """Gate one prediction; learn, correct or relocalise (steps 4 to 6).

        Predictions without detections move smoothly, so the gate hardly ever rejects them. After ``relocalise_after``
        such frames the online detector searches regardless of the gate.
        """
        track_context = self._track_contexts[track_id]
        verdict: GateVerdict | None = None
        if self._visible(prediction.box) and track_context.memory.count:
            with _timed(seconds, "gate"):
                verdict = self._judge(frame, prediction.box, track_context)
        if verdict is None or track_context.online is None:
            if detected is not None:
                self._tracker.correct(track_id, detected)
            return _Decision(verdict, None, ())
        undetected = 0 if detected is not None else self._tracker.undetected(track_id)
        samples: tuple[Sample, ...] = ()
        # A prediction without a detection would teach the detector its own drift. Old samples stay then, too.
        if not (undetected and verdict.confident) or self.params.online.learn_undetected:
            with _timed(seconds, "learn"):
                label = 1 if verdict.confident else -1
                samples = track_context.online.learn(frame.pixels, prediction.box, label, frame.ordinal)
        use_detection = verdict.confident or self.params.pipeline.rejected_measurement == "detection"
        if detected is not None and use_detection:
            self._tracker.correct(track_id, detected)
            if not verdict.confident:
                events.append(rejected_event(track_id, verdict, self.params.gate, "its detection counts"))
            return _Decision(verdict, None, samples)
        search_after = self.params.pipeline.relocalise_after
        if verdict.confident and (search_after is None or undetected < search_after):
            return _Decision(verdict, None, samples)
        with _timed(seconds, "relocalise"):
            window = track_context.online.relocalise(frame.pixels, prediction.box)
        is_sure = window is not None and window.probability >= self.params.pipeline.sure_probability
        if verdict.confident:
            if window is not None and window.probability >= self.params.pipeline.search_probability:
                with _timed(seconds, "relocalise"):
                    events.append(self._correct_by_window(frame.pixels, track_id, undetected, prediction, window))
        elif window is None or window.probability < self.params.pipeline.relocalise_probability:
            events.append(
                rejected_event(track_id, verdict, self.params.gate, "no window around it looks like the sign")
            )
            if detected is not None:
                self._tracker.correct(track_id, detected)
        else:
            self._tracker.correct(track_id, window.box, source="relocalised", confident=is_sure, result=window.box)
            events.append(relocalised_event(track_id, verdict, self.params.gate, prediction.box, window))
        return _Decision(verdict, window, samples)

    def _correct_by_window(
        self, pixels: PixelSource, track_id: int, undetected: int, prediction: Prediction, window: Relocalisation
    ) -> Event:
        """Correct a confident prediction by a window of the search, unless the window is too far away.

        An object in front of the sign looks somewhat like it to a detector that has learned only a few views. So a
        window that would move the track far away probably shows such an object.
        """
        p = self.params.pipeline
        offset = to_cxcywh(window.box)[:2] - to_cxcywh(prediction.box)[:2]
        sigmas = float(np.sqrt(dot(offset, solve(prediction.covariance[:2, :2], offset[:, None])[:, 0])))
        if p.search_sigmas is not None and sigmas > p.search_sigmas:
            return too_far_event(track_id, undetected, prediction.box, window, sigmas)
        is_sure = window.probability >= p.sure_probability
        window_scorer = self._models.window_scorer if p.rescore_windows else None
        rescored = None if window_scorer is None else window_scorer(pixels, window.box)
        accepted = rescored if rescored is not None and rescored.score >= p.rescore_score else None
        # A hidden or blurred sign has a low score, and its window is a poor measurement of the place.
        rejected = rescored if accepted is None and p.inflate_rejected_noise else None
        scored = accepted or rejected
        noise_scale = 1.0 if scored is None else self.params.tracking.noise_scale(scored.score)
        if accepted is not None:
            box, quality = accepted.box, FULL_QUALITY.times(p.rescore_noise * noise_scale)
        else:
            quality = MeasurementQuality(p.search_noise, p.search_size_noise or p.search_noise)
            box, quality = window.box, quality.times(noise_scale)
        self._tracker.correct(track_id, box, source="relocalised", quality=quality, confident=is_sure)
        return search_event(track_id, undetected, prediction.box, window, accepted, rejected)

    def _judge(self, frame: FrameInput, box: FloatArray, track_context: TrackContext) -> GateVerdict:
        centre, previous = to_cxcywh(box), to_cxcywh(track_context.box)
        crop = cut_pixels(frame.pixels, box, self._gate.margin)
        side = float(centre[2:].mean())
        return self._gate.judge(crop, track_context.memory, centre[:2], previous[:2], side, frame.shift)

    def _remember(self, frame: FrameInput, status: TrackStatus, decision: _Decision, seconds: dict[str, float]) -> None:
        """Store in the track's context what the next frame needs; make the context of a new track."""
        track_context = self._track_contexts.get(status.track_id)
        if track_context is None:
            track_context = self._track_contexts[status.track_id] = TrackContext.start(
                self.params, status.box, len(self._models.names)
            )
        track_context.box = status.box
        if not self._visible(status.box):
            return
        if track_context.online is None and self.params.online.use_online and self._models.make_online is not None:
            with _timed(seconds, "learn"):
                track_context.online, first_samples = self._models.make_online(frame.pixels, status.box, frame.ordinal)
            decision.samples = (*decision.samples, *first_samples)
        if shows_sign(status.source, decision.gate):
            with _timed(seconds, "gate"):
                crop = cut_pixels(frame.pixels, status.box, self._gate.margin)
                track_context.memory = self._gate.remember(track_context.memory, crop)

    def _recognise(
        self, frame: FrameInput, tracked: TrackedFrame, seconds: dict[str, float], events: list[Event]
    ) -> dict[int, Recognition]:
        """Classify the frame's results together and add their votes (steps 7 and 8)."""
        usable = [status for status in tracked.tracks if self._visible(status.box)]
        if not usable:
            return {}
        classifier = self._models.classifier
        with _timed(seconds, "classify"):
            crops = [cut_pixels(frame.pixels, status.box, classifier.margin) for status in usable]
            probabilities = classifier.probabilities(crops)
        recognitions = {}
        with _timed(seconds, "fuse"):
            for status, row in zip(usable, probabilities, strict=True):
                track_context = self._track_contexts[status.track_id]
                width, height = to_cxcywh(status.box)[2:]
                recognition = track_context.vote(row, float(np.sqrt(width * height)))
                recognitions[status.track_id] = recognition
                if track_context.label is not None and track_context.label != recognition.class_id:
                    names = self._models.names[track_context.label], self._models.names[recognition.class_id]
                    events.append(relabelled_event(status.track_id, *names, recognition.share))
                track_context.label = recognition.class_id
        return recognitions

    def _visible(self, box: FloatArray) -> bool:
        return is_usable_box(box, self._width, self._height)


def is_usable_box(box: FloatArray, width: int, height: int) -> bool:
    """Whether a box (4,) has a plausible size and is at least partly in a picture of ``width`` x ``height`` px."""
    if not np.isfinite(box).all():
        return False
    across, down = box[2] - box[0], box[3] - box[1]
    if not (MIN_SIDE <= across <= width and MIN_SIDE <= down <= height):
        return False
    return float(area(clip(box, width, height))) >= 1.0


def shows_sign(source: Source, gate: GateVerdict | None) -> bool:
    """Whether a result shows the sign, so that its crop goes into the track's memory."""
    return source != "predicted" or (gate is not None and gate.confident)


@dataclass(slots=True)
class _Decision:
    """Results about one prediction."""

    gate: GateVerdict | None
    relocalisation: Relocalisation | None
    samples: tuple[Sample, ...]


def _track_frame(status: TrackStatus, decision: _Decision, recognitions: Mapping[int, Recognition]) -> TrackFrame:
    return TrackFrame(
        track_id=status.track_id,
        state=status.state,
        source=status.source,
        box=status.box,
        score=status.score,
        prediction=status.prediction,
        detection=status.detection,
        gate=decision.gate,
        relocalisation=decision.relocalisation,
        samples=decision.samples,
        recognition=recognitions.get(status.track_id),
    )


def _last_frame(track_id: int, prediction: Prediction, detection: int | None, decision: _Decision) -> TrackFrame:
    """The record of a track in the frame in which it ended, with the decisions that ended it."""
    return TrackFrame(
        track_id=track_id,
        state="dead",
        source="predicted",
        box=prediction.box,
        score=0.0,
        prediction=prediction,
        detection=detection,
        gate=decision.gate,
        relocalisation=decision.relocalisation,
        samples=decision.samples,
        recognition=None,
    )


@contextmanager
def _timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    started = time.perf_counter()
    try:
        yield
    finally:
        seconds[stage] = seconds.get(stage, 0.0) + time.perf_counter() - started
