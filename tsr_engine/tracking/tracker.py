"""The tracker: prediction, association, correction, birth and death, in separate steps.

The gate and the online detector act between prediction and update, so the frame's loop belongs to the pipeline::

    tracker = Tracker(params.tracking, width, height)
    for ordinal, picture in video:
        predictions = tracker.predict(dt, shift)             # track_id -> Prediction
        matches = tracker.associate(detections)              # track_id -> row of detections
        for track_id, prediction in predictions.items():     # gate, relocalisation, then:
            tracker.correct(track_id, box, source="detected")
        frame = tracker.finish(ordinal)                      # tracks of this frame and events

``step`` runs that loop without gate and online detector (the paper's "KF alone").
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tsr_engine.geometry.boxes import area, clip, intersection, iou, shorter_side, to_cxcywh, to_xyxy
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.plural import plural
from tsr_engine.protocols import FULL_QUALITY, NO_CUT_EDGES, Edges, MeasurementQuality, MotionModel
from tsr_engine.records import Detections, Event, FloatArray, Prediction, Source
from tsr_engine.tracking.assignment import Gates, associate
from tsr_engine.tracking.motion import make_motion
from tsr_engine.tracking.track import Track
from tsr_engine.tracking.track_status import TrackedFrame, TrackStatus
from tsr_engine.tracking.truncated_boxes import complete_box
from tsr_engine.tracking.vertical_drift import VerticalDriftFilter

_NESTED_OVERLAP = 0.65
"""Overlap with a detected track's box, as a share of the smaller box, from which a detection shows the same sign."""
_EDGE_DISTANCE = 0.05
"""Distance from the picture's edge, in sides of the box, within which the box counts as cut off."""
_MAX_REPEATS = 2
"""Largest number of repeated pictures in a row that count as dropped frames."""


class Tracker:
    """Follows signs through one video. Deterministic; ids count from 1 in each instance.

    Args:
        params: parameters of tracking.
        width: width of the pictures, px.
        height: height of the pictures, px.
        motion: motion model; unset: that of ``params.motion``.
        first_id: id of the first track, >= 1.
    """

    def __init__(
        self, params: TrackingParams, width: int, height: int, motion: MotionModel | None = None, *, first_id: int = 1
    ) -> None:
        self._params = params
        self._width = width
        self._height = height
        self._motion = motion or make_motion(params)
        self._gates = Gates.of(params)
        self._tracks: dict[int, Track] = {}
        self._next_id = first_id
        self._detections = Detections.empty()
        self._matched_rows: set[int] = set()
        self._skipped_time = 0.0
        self._repeats = 0
        self._drift_filter = VerticalDriftFilter(params.level_frames)
        self._focus_y = None if params.coast_foe_y is None else params.coast_foe_y * height

    def undetected(self, track_id: int) -> int:
        """Number of frames without a detection of a living track up to now, this frame included."""
        return self._tracks[track_id].undetected

    def predict(self, dt: float = 1.0, shift: tuple[float, float] | None = None) -> dict[int, Prediction]:
        """Time update of all tracks; starts a frame.

        Args:
            dt: time since the previous frame in nominal frame intervals, > 0.
            shift: global camera shift of the picture since the previous frame, px; None: unknown. Exactly (0, 0) means
                that the picture repeats the last one: tracks stand still and catch up in the next frame. Ignored
                without ``use_camera_shift``.

        Returns:
            Prediction of each living track by id, ascending.
        """
        if not self._params.use_camera_shift:
            shift = None
        dt = self._elapsed(dt, repeated=shift is not None and shift[0] == 0.0 and shift[1] == 0.0)
        if not self._tracks:
            self._drift_filter.reset()  # a run that resumes after this frame has no earlier frames either
        shift = self._drift_filter.remove_drift(shift or (0.0, 0.0), dt)
        for track in self._tracks.values():
            # A detected sign follows its own path; an undetected one moves away from the camera's known FOE.
            motion = self._motion.predict(track.motion, dt, shift, self._focus_y if track.undetected > 0 else None)
            box = to_xyxy(self._motion.box_of(motion))
            track.begin_frame(Prediction(box, self._motion.innovation(motion)), motion)
        self._detections = Detections.empty()
        self._matched_rows = set()
        return {track.track_id: track.prediction for track in self._tracks.values() if track.prediction is not None}

    def associate(self, detections: Detections) -> dict[int, int]:
        """Assigns detections to the predicted tracks and counts them for their life cycle.

        Boxes do not change yet: only ``correct`` updates the filter. Detections below ``low_score``, and those without
        area, are not assigned.

        Returns:
            Row of ``detections`` by track id; tracks without a detection are absent.
        """
        tracks = [track for track in self._tracks.values() if track.prediction is not None]
        predictions = [self._in_view(track.prediction) for track in tracks if track.prediction is not None]
        p = self._params
        pairs = associate(predictions, detections.boxes, detections.scores, p.high_score, p.low_score, self._gates)
        self._detections = detections
        self._matched_rows = set(pairs.values())
        for index, row in pairs.items():
            tracks[index].detected(row, float(detections.scores[row]), p)
        return {tracks[index].track_id: row for index, row in sorted(pairs.items())}

    def correct(
        self,
        track_id: int,
        box: FloatArray,
        *,
        source: Source = "detected",
        quality: MeasurementQuality = FULL_QUALITY,
        confident: bool = True,
        result: FloatArray | None = None,
    ) -> FloatArray:
        """Measurement update of one track in this frame.

        Args:
            track_id: a living track.
            box: the measurement, shape (4,), with area.
            source: source of the measurement and of the frame's result.
            quality: quality of the measurement; its cut edges are set here.
            confident: whether the measurement proves that the sign is still there; resets the count of missed frames.
            result: the frame's result, shape (4,); unset: the filter's estimate with ``result_noise`` times the
                measurement noise.

        Returns:
            The frame's result, shape (4,); may reach beyond the picture.

        Raises:
            ValueError: the box has no area.
        """
        if not shorter_side(box) > 0:
            raise ValueError(f"A track must be corrected by a box with area. Got {[float(v) for v in box]} instead.")
        track = self._tracks[track_id]
        predicted = track.motion
        expected = to_xyxy(self._motion.box_of(predicted))
        complete, cut = complete_box(box, expected, self._truncated_edges(box, expected))
        measurement, measured_quality = to_cxcywh(complete), replace(quality, cut=cut)
        if source == "detected":
            measured_quality = measured_quality.times(self._params.noise_scale(track.score))
        track.motion = self._motion.update(predicted, measurement, measured_quality)
        if result is not None:
            track.box = np.array(result, dtype=np.float64)
        elif self._params.result_noise == 1.0:
            track.box = to_xyxy(self._motion.box_of(track.motion))
        else:
            # The state must not follow each detection's error, or it predicts badly; the frame's result may.
            displayed = self._motion.update(predicted, measurement, measured_quality.times(self._params.result_noise))
            track.box = to_xyxy(self._motion.box_of(displayed))
        track.source = source
        track.measured = True
        if confident:
            track.missed = 0
        return track.box

    def finish(self, ordinal: int) -> TrackedFrame:
        """Confirms, ends, merges and starts tracks; ends a frame."""
        events: list[Event] = []
        for track in self._tracks.values():
            if track.undetected > 0:
                low_score = self._params.low_score
                track.score = low_score + (track.score - low_score) * self._params.score_decay
            if track.state == "tentative" and track.may_confirm(self._params):
                track.state = "confirmed"
                events.append(confirmed_event(track, self._params.confirm_window))
            elif track.missed == 1 and track.state == "confirmed":
                text = f"Track {track.track_id} has neither a detection nor a sure relocalisation and is predicted."
                events.append(Event("missed", track.track_id, text))
        events += self._end_tracks()
        events += self._merge_tracks()
        events += self._start_tracks(ordinal)
        statuses = tuple(
            TrackStatus(t.track_id, t.state, t.source, t.box, t.score, t.prediction, t.detection, t.missed)
            for t in self._tracks.values()
        )
        return TrackedFrame(statuses, tuple(events))

    def step(
        self, ordinal: int, detections: Detections, dt: float = 1.0, shift: tuple[float, float] | None = None
    ) -> TrackedFrame:
        """A whole frame with the Kalman filter alone: every associated detection is a measurement."""
        self.predict(dt, shift)
        for track_id, row in self.associate(detections).items():
            self.correct(track_id, detections.boxes[row])
        return self.finish(ordinal)

    def _in_view(self, prediction: Prediction) -> Prediction:
        """The part of a prediction that is in the picture; all of it if no part is."""
        visible = clip(prediction.box, self._width, self._height)
        if not self._params.open_edges or float((visible[2:] - visible[:2]).min()) < 1.0:
            return prediction
        return Prediction(visible, prediction.covariance)

    def _truncated_edges(self, box: FloatArray, expected: FloatArray) -> Edges:
        """Edges of a measured box, shape (4,), that lie at the picture's edge.

        A sign that leaves the view is measured only up to the picture's edge. As an edge of the sign, it would make
        the sign shrink and move inwards.
        """
        if not self._params.open_edges:
            return NO_CUT_EDGES
        limits = np.array([0.0, 0.0, self._width, self._height])
        outward = np.array([-1.0, -1.0, 1.0, 1.0])
        sides = np.tile(box[2:] - box[:2], 2)
        left, top, right, bottom = (outward * (box - limits) > -_EDGE_DISTANCE * sides) & (
            outward * (expected - limits) > 0.0
        )
        return bool(left), bool(top), bool(right), bool(bottom)

    def _elapsed(self, dt: float, *, repeated: bool) -> float:
        """Time by which the picture's content advances, nominal frame intervals.

        Cameras and converters repeat a picture in place of a dropped one, so that the next picture is two intervals
        later. More repeats in a row mean a scene that stands still; time then passes as usual.
        """
        if not self._tracks:
            self._skipped_time, self._repeats = 0.0, 0
            return dt
        if not repeated:
            dt, self._skipped_time, self._repeats = dt + self._skipped_time, 0.0, 0
            return dt
        self._repeats += 1
        if self._repeats > _MAX_REPEATS:
            self._skipped_time = 0.0
            return dt
        self._skipped_time += dt
        return 0.0

    def _end_tracks(self) -> list[Event]:
        """Ends tracks that left the view or had no evidence for too long."""
        events = []
        for track in list(self._tracks.values()):
            share = float(area(clip(track.box, self._width, self._height)) / max(float(area(track.box)), 1e-9))
            values: Mapping[str, float | int] = {"missed": track.missed, "undetected": track.undetected, "view": share}
            may_leave = track.undetected > 0 or not self._params.open_edges
            if share < self._params.view_share and may_leave:
                reason = f"only {100 * share:.0f} % of its box is in view"
            elif track.undetected > track.undetected_limit(self._params):
                reason = f"{track.undetected} frames without a detection"
            elif track.missed > track.missed_limit(self._params):
                reason = f"{track.missed} frames without a detection or a sure relocalisation"
            else:
                continue
            suffix = " before it was confirmed" if track.state == "tentative" else ""
            events.append(Event("died", track.track_id, f"Track {track.track_id} ended{suffix}: {reason}.", values))
            del self._tracks[track.track_id]
        return events

    def _merge_tracks(self) -> list[Event]:
        """Ends the weaker of two tracks on the same sign."""
        if len(self._tracks) < 2:
            return []
        events = []
        tracks = sorted(self._tracks.values(), key=_strength)
        boxes = np.array([track.box for track in tracks])
        overlaps = iou(boxes, boxes)
        for i, weak in enumerate(tracks):
            stronger = np.flatnonzero(overlaps[i, i + 1 :] >= self._params.merge_iou)
            if len(stronger):
                strong = tracks[i + 1 + int(stronger[0])]
                text = f"Track {weak.track_id} ended: it lies on the same sign as track {strong.track_id}."
                values = {"into": strong.track_id, "iou": float(overlaps[i, i + 1 + int(stronger[0])])}
                events.append(Event("died", weak.track_id, text, values))
                del self._tracks[weak.track_id]
        return events

    def _start_tracks(self, ordinal: int) -> list[Event]:
        """Starts a track for every good detection without a track."""
        events = []
        detections = self._detections
        for row in range(len(detections)):
            score = float(detections.scores[row])
            box = np.array(detections.boxes[row], dtype=np.float64)
            if row in self._matched_rows or score < self._params.birth_score or not shorter_side(box) > 0:
                continue
            if self._is_second_view(box):
                continue
            motion = self._motion.initiate(to_cxcywh(box), self._width, self._height)
            track = Track(self._next_id, motion, box, score, ordinal)
            track.detected(row, score, self._params)
            self._next_id += 1
            self._tracks[track.track_id] = track
            text = f"Track {track.track_id} starts from a detection with score {score:.2f}."
            events.append(Event("born", track.track_id, text, {"score": score, "frame": ordinal}))
            if track.may_confirm(self._params):
                track.state = "confirmed"
                events.append(confirmed_event(track, self._params.confirm_window))
        return events

    def _is_second_view(self, box: FloatArray) -> bool:
        """Whether a detection shows a sign that already has a track."""
        for track in self._tracks.values():
            if float(iou(box, track.box)[0, 0]) >= self._params.duplicate_iou:
                return True
            smaller = min(float(area(box)), float(area(track.box)))
            # Only a track that is detected in this frame suppresses a nested box of quite different size.
            if track.undetected == 0 and float(intersection(box, track.box)[0, 0]) >= _NESTED_OVERLAP * smaller:
                return True
        return False


def confirmed_event(track: Track, window: int) -> Event:
    """The event of a confirmation by detections of the last ``window`` frames; its value ``frames`` is the age."""
    hits, age = len(track.recent), track.age + 1
    by = f"{plural(hits, 'detection')} in its last {plural(min(age, window), 'frame')}"
    values = {"hits": hits, "frames": age, "since": track.born}
    return Event("confirmed", track.track_id, f"Track {track.track_id} is confirmed by {by}.", values)


def _strength(track: Track) -> tuple[bool, int, int, int]:
    """Sort key of tracks, weakest first: tentative, then longest missed, fewest hits, youngest."""
    return (track.state == "confirmed", -track.missed, track.hits, -track.track_id)
