"""Replays a run: takes its evidence through the core with other parameters, without decoding or detecting.

With the run's own parameters every record equals the stored one bit by bit. With other parameters, the report lists the
tracks that differ, and counts the pixels that the evidence lacks.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path

from tsr_engine.errors import EvidenceError, ModelError, UsageError
from tsr_engine.evidence import EvidenceReader, differences
from tsr_engine.geometry.boxes import iou
from tsr_engine.params import Params
from tsr_engine.params.replayable import VALUES_IN_OLD_RUNS, changed_parameters, is_replayable, refuse_missing_focus
from tsr_engine.pipeline import (
    READER_COMPONENTS,
    RECOMPUTED,
    Components,
    ResultStream,
    TrackSummary,
    rescore,
    start_core,
    stored_input,
)
from tsr_engine.recognition.gtsrb_classes import CLASS_NAMES
from tsr_engine.records import FrameEvidence

MATCH_IOU = 0.3
"""IoU from which two boxes of a frame show the same sign."""


@dataclass(frozen=True, slots=True)
class TrackDiff:
    """Differences between the confirmed tracks of a replay and those of the run.

    Attributes:
        gained: ids of replayed tracks that match no track of the run.
        lost: ids of the run's tracks that match no replayed track.
        switched: pairs ``(run's id, replayed ids)`` of tracks that match several replayed tracks.
        relabelled: triples ``(replayed id, class in the run, class in the replay)``.
    """

    gained: tuple[int, ...] = ()
    lost: tuple[int, ...] = ()
    switched: tuple[tuple[int, tuple[int, ...]], ...] = ()
    relabelled: tuple[tuple[int, int, int], ...] = ()

    def __bool__(self) -> bool:
        return bool(self.gained or self.lost or self.switched or self.relabelled)


@dataclass(slots=True)
class ReplayReport:
    """The result of a replay."""

    frames: int = 0
    identical: int = 0
    """Number of frames in which every record equals the stored one bit by bit, except the wording of events."""
    first_difference: str = ""
    """The first difference in the first frame that is not identical."""
    missing_pixels: int = 0
    """Number of requested pixels that the evidence lacks."""
    missing_frames: int = 0
    """Number of frames with missing pixels."""
    seconds: float = 0.0
    before: list[TrackSummary] = field(default_factory=list)
    """Confirmed tracks of the run."""
    tracks: list[TrackSummary] = field(default_factory=list)
    """Confirmed tracks of the replay."""
    diff: TrackDiff = field(default_factory=TrackDiff)
    class_names: tuple[str, ...] = CLASS_NAMES
    """Display name of each class."""


def run_params(reader: EvidenceReader) -> Params:
    """The parameters of a run.

    Raises:
        EvidenceError: this version does not have one of them.
    """
    stored = reader.header.parameters
    pairs = [
        (f"{section}.{name}", tuple(value) if isinstance(value, list) else value)
        for section, values in stored.items()
        for name, value in values.items()
    ]
    try:
        return Params().with_settings([*VALUES_IN_OLD_RUNS.items(), *pairs])
    except UsageError as error:
        raise EvidenceError(f"{reader.folder} was made with other parameters than this version has: {error}") from None


def check_models(reader: EvidenceReader, components: Components, params: Params) -> None:
    """Check that the models are those of the run.

    The prior's hash is not checked. The detector's is checked only if it also rescores windows. Where the parameter
    ``reader`` is another one, a classifier or network that the run did not use is not checked.

    Raises:
        ModelError: a component that the replay uses has another hash.
    """
    if reader.header.labels != components.labels:
        raise ModelError(
            f"{reader.folder} was made with a classifier of other labels. Name its models with --models, or track the "
            "video again."
        )
    other_reader = run_params(reader).pipeline.reader != params.pipeline.reader
    uses_detector = params.pipeline.rescore_windows and "detector" in reader.header.models
    unused = ("prior",) if uses_detector else ("detector", "prior")
    for name, digest in components.models.items():
        stored = reader.header.models.get(name)
        if stored is None and name in READER_COMPONENTS and other_reader:
            continue  # what the run did not use is asked for now
        if stored != digest and name not in unused:
            expected = "none" if stored is None else f"sha256 {stored[:12]}..."
            raise ModelError(
                f"{reader.folder} was made with another {name} (expected {expected}, got {digest[:12]}...). Name its "
                "models with --models, or allow others with --other-models."
            )


def replay(
    folder: Path,
    params: Params,
    components: Components,
    *,
    on_frame: Callable[[FrameEvidence, int, int], None] | None = None,
    report: ReplayReport | None = None,
) -> Iterator[FrameEvidence]:
    """Process the stored frames of a run with the core, and yield the results.

    Args:
        folder: the run's evidence.
        params: parameters of the replay.
        components: trained parts; the detector is not used.
        on_frame: called after each frame with the frame, the number done and the number to do.
        report: filled during the replay; complete when the iterator is exhausted.

    Raises:
        EvidenceError: the folder holds no run, or the run is damaged or has no pixels.
        UsageError: a changed parameter belongs to a step that a replay does not repeat, or needs a focus of expansion
            that the run has not estimated.
    """
    report = ReplayReport() if report is None else report
    report.class_names = components.parts.names
    started = time.perf_counter()
    with EvidenceReader(folder) as reader:
        original_params = run_params(reader)
        changed = changed_parameters(original_params, params)
        if fixed := next((name for name in changed if not is_replayable(name)), None):
            raise UsageError(
                f"A replay does not repeat the step that {fixed} belongs to. Leave it, or track the video of {folder} "
                "again."
            )
        refuse_missing_focus(original_params, params)
        if not reader.header.keep_pixels:
            raise EvidenceError(f"{folder} holds no pixels and cannot be replayed. Track the video again with pixels.")
        weight = _rescoring_weight(reader, original_params, params, components)
        core = start_core(reader, params, components.parts)
        old, new = ResultStream(), ResultStream()
        comparison = _Comparison()
        total = len(reader)
        for stored in reader.frames():
            detections = stored.detections if weight is None else rescore(stored.detections, weight)
            core_input, pixels = stored_input(stored, detections)
            replayed = replace(core.step(core_input), regions=stored.regions)
            _count(report, replayed, stored, pixels.missing)
            comparison.add(stored, replayed)
            _exhaust(old.add(stored))
            _exhaust(new.add(replayed))
            if on_frame is not None:
                on_frame(replayed, report.frames, total)
            yield replayed
        _exhaust(old.finish())
        _exhaust(new.finish())
        report.before, report.tracks = old.tracks, new.tracks
        report.diff = comparison.result(old.tracks, new.tracks)
    report.seconds = time.perf_counter() - started


def _count(report: ReplayReport, replayed: FrameEvidence, stored: FrameEvidence, missing: int) -> None:
    report.frames += 1
    difference = next(differences(replayed, stored, ignore=RECOMPUTED), None)
    if difference is None:
        report.identical += 1
    elif not report.first_difference:
        report.first_difference = f"frame {stored.ordinal}, {difference}"
    report.missing_pixels += missing
    report.missing_frames += missing > 0


def _rescoring_weight(reader: EvidenceReader, original: Params, params: Params, components: Components) -> float | None:
    """The lambda to rescore detections with; None: the stored scores are used."""
    if original.prior == params.prior:
        return None
    if not params.prior.use_prior:
        return 0.0
    if params.prior.prior_lambda is not None:
        return params.prior.prior_lambda
    return float(reader.header.frame_table.get("learned_lambda", components.learned_lambda))


def _exhaust(rows: Iterator[object]) -> None:
    for _ in rows:
        pass


class _Comparison:
    """Matches the tracks of two runs by their overlap in common frames."""

    def __init__(self) -> None:
        self._together: Counter[tuple[int, int]] = Counter()

    def add(self, old: FrameEvidence, new: FrameEvidence) -> None:
        old_tracks, new_tracks = ([t for t in frame.tracks if t.state != "dead"] for frame in (old, new))
        for a, b in product(old_tracks, new_tracks):
            if float(iou(a.box, b.box)[0, 0]) >= MATCH_IOU:
                self._together[a.track_id, b.track_id] += 1

    def result(self, old: list[TrackSummary], new: list[TrackSummary]) -> TrackDiff:
        before = {track.track_id: track for track in old}
        after = {track.track_id: track for track in new}
        pairs = {pair: frames for pair, frames in self._together.items() if pair[0] in before and pair[1] in after}
        parts: dict[int, list[int]] = {}
        source: dict[int, int] = {}
        # A replayed track belongs to the run's track that it overlaps most often; to the older one on a tie.
        for a, b in sorted(pairs, key=lambda pair: (-pairs[pair], pair)):
            parts.setdefault(a, []).append(b)
            source.setdefault(b, a)
        return TrackDiff(
            gained=tuple(sorted(after.keys() - source.keys())),
            lost=tuple(sorted(before.keys() - parts.keys())),
            switched=tuple((a, tuple(sorted(b))) for a, b in sorted(parts.items()) if len(b) > 1),
            relabelled=tuple(
                (b, before[a].class_id, after[b].class_id)
                for b, a in sorted(source.items())
                if before[a].class_id != after[b].class_id
            ),
        )
