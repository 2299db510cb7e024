"""Replays a bundle: runs the installed engine on the clip and compares the result with expectation and old output."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from tsr_engine.bundle.clip import picture_digest
from tsr_engine.bundle.judge import judge, overall_verdict
from tsr_engine.bundle.layout import MODELS, Verdict
from tsr_engine.bundle.load import Bundle, open_evidence
from tsr_engine.bundle.models import extract_models
from tsr_engine.bundle.output import Output, same_output
from tsr_engine.errors import EvidenceError, ImportFormatError, UsageError, VideoError
from tsr_engine.evidence import EvidenceReader, FramePixels, ResultRow, differences
from tsr_engine.io.video import open_video
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params import Params
from tsr_engine.params.aliases import current_sections
from tsr_engine.params.replayable import VALUES_IN_OLD_RUNS
from tsr_engine.pipeline import RECOMPUTED, Components, FrameInput, ResultStream, TrackingCore, VideoDetector
from tsr_engine.records import FrameEvidence
from tsr_engine.tracking.camera_shift import CameraShift
from tsr_engine.version import __version__


@dataclass(frozen=True, slots=True)
class Outcome:
    """The verdict on one expectation when the bundle was made and now; see :class:`~.judge.Finding`."""

    id: str
    expected: str
    before: bool
    now: bool
    got: str
    frame: int

    @property
    def verdict(self) -> str:
        """``fixed``, ``still broken``, ``right`` (as before) or ``newly broken``."""
        if self.now:
            return "right" if self.before else "fixed"
        return "newly broken" if self.before else "still broken"


@dataclass(slots=True)
class BundleReplay:
    """The result of a replay of a bundle.

    Attributes:
        verdict: the overall verdict.
        outcomes: one per expectation.
        frames: number of frames run, with the lead-in.
        identical: number of judged frames whose records all equal the stored ones, bit by bit; None: this version
            cannot read the stored evidence.
        judged: number of judged frames.
        first_difference: the first difference and its frame.
        same: whether the output equals that in the bundle.
        tracks: number of tracks now; ``tracks_before``: in the bundle.
        other_pictures: number of frames that decode to other pictures here.
        changed: other differences from the run (version, models, parameters), one sentence each.
        seconds: wall time.
        rows: output of the replay.
    """

    verdict: Verdict = "different"
    outcomes: list[Outcome] = field(default_factory=list)
    frames: int = 0
    identical: int | None = None
    judged: int = 0
    first_difference: str = ""
    same: bool = False
    tracks: int = 0
    tracks_before: int = 0
    other_pictures: int = 0
    changed: list[str] = field(default_factory=list)
    seconds: float = 0.0
    rows: list[ResultRow] = field(default_factory=list)


def bundle_params(bundle: Bundle) -> tuple[Params, list[str]]:
    """The parameters of the run, and one sentence for each that this version does not know or accept.

    Raises:
        ImportFormatError: the bundle has no parameters.
    """
    known = {f"{section}.{leaf}" for section, leaf in Params.names()}
    stored: JsonObject = {}
    for section, values in current_sections(bundle.manifest.run.parameters).items():
        if not isinstance(values, dict):
            raise ImportFormatError(f"{bundle.name}: the parameters of the run are damaged. Create the bundle again.")
        stored |= {f"{section}.{name}": tuple(v) if isinstance(v, list) else v for name, v in values.items()}
    params, problems = Params().with_settings(VALUES_IN_OLD_RUNS.items()), []
    for name, value in stored.items():
        if name not in known:
            problems.append(f"The parameter {name[:80]} of the run is not known to this version.")
            continue
        try:
            params = params.with_settings([(name, value)])
        except UsageError:
            problems.append(f"The parameter {name} of the run, {str(value)[:40]}, is not allowed by this version.")
    problems += [
        f"The run has no parameter {name}: "
        f"{'it replays as it was made' if name in VALUES_IN_OLD_RUNS else 'its default is used'}."
        for name in sorted(known - stored.keys())
    ]
    return params, problems


def bundled_models(bundle: Bundle) -> Path | None:
    """Unpack the models of the bundle into a folder; None: there are none, because the run used the shipped ones.

    Raises:
        ImportFormatError: the run used other models, and they are missing or damaged.
    """
    if bundle.manifest.models_inside:
        return extract_models(bundle.folder / MODELS, bundle.folder / "models-taken")
    if "ship with" in bundle.manifest.models:
        return None
    raise ImportFormatError(f"{bundle.name} holds no models: {bundle.manifest.models} Leave --bundled-models out.")


def replay_bundle(
    bundle: Bundle,
    params: Params,
    components: Components,
    *,
    changed: list[str] | None = None,
    progress: Callable[[int, int], None] = lambda _done, _of: None,
    stop: Callable[[], bool] = lambda: False,
) -> BundleReplay:
    """Run the engine on a bundle and judge its output.

    Args:
        bundle: the bundle.
        params: parameters of the replay.
        components: the trained components.
        changed: known differences from the run.
        progress: called with (frames done, total).
        stop: called after each frame; True ends the replay.

    Raises:
        VideoError: the clip cannot be decoded.
        KeyboardInterrupt: ``stop`` returned True.
    """
    start_time = time.perf_counter()
    report = BundleReplay(changed=[*(changed or []), *_changes(bundle, components)])
    stream, comparison = ResultStream(), _Comparison(bundle)
    rows: list[ResultRow] = []
    try:
        for frame in _run_engine(bundle, params, components, report, progress):
            rows.extend(stream.add(frame))
            comparison.add(frame)
            if stop():
                raise KeyboardInterrupt
    finally:
        comparison.close()
    rows.extend(stream.finish())
    frame_range = bundle.manifest.frames
    output = Output.from_rows(rows, frame_range.first, frame_range.stop)
    before_findings, findings = judge(bundle.expectation, bundle.output), judge(bundle.expectation, output)
    report.judged = frame_range.stop - frame_range.first
    report.identical, report.first_difference = comparison.identical, comparison.first
    report.same = same_output(bundle.output, output)
    report.verdict = overall_verdict(before_findings, findings, report.same)
    report.outcomes = [
        Outcome(now.id, now.expected, before.met, now.met, now.got, now.frame)
        for before, now in zip(before_findings, findings, strict=True)
    ]
    report.tracks, report.tracks_before = len(output.tracks), len(bundle.output.tracks)
    report.rows = output.rows
    report.seconds = time.perf_counter() - start_time
    return report


def _run_engine(
    bundle: Bundle, params: Params, components: Components, report: BundleReplay, progress: Callable[[int, int], None]
) -> Iterator[FrameEvidence]:
    """Run the engine on every frame of the clip, including the lead-in; the report counts frames and other pictures.

    Frame numbers and times, the nominal interval and the first track's number are those of the run, so that equal
    pictures, parameters and models give equal evidence.

    Raises:
        VideoError: the clip cannot be decoded, is too short, or has pictures of another size.
    """
    manifest = bundle.manifest
    with open_video(bundle.clip) as video:
        if (video.width, video.height) != (manifest.clip.width, manifest.clip.height):
            raise VideoError(
                f"{manifest.clip.file} of {bundle.name} has pictures of {video.width}x{video.height}, expected "
                f"{manifest.clip.width}x{manifest.clip.height}. Create the bundle again."
            )
        interval, first_id = manifest.run.interval, manifest.frames.first_id
        core = TrackingCore(params, components.parts, video.width, video.height, interval=interval, first_id=first_id)
        detector, tracking = VideoDetector(components.detector), params.tracking
        shift_estimator = CameraShift(tracking.shift_scale, (tracking.foe_x, tracking.foe_y))
        pictures = video.frames(bundle.frames[0].clip, bundle.frames[-1].clip + 1)
        for wanted, frame in zip(bundle.frames, pictures, strict=False):
            report.other_pictures += picture_digest(frame.picture) != wanted.digest
            detections = detector.detect(wanted.ordinal, frame.picture)
            camera_shift = shift_estimator.step(frame.picture) if tracking.use_camera_shift else (0.0, 0.0)
            pixels = FramePixels(frame.picture)
            revisit = detector.revisit(frame.picture, detections)
            yield core.step(FrameInput(wanted.ordinal, wanted.seconds, detections, camera_shift, pixels, revisit))
            report.frames += 1
            progress(report.frames, len(bundle.frames))
    if report.frames != len(bundle.frames):
        raise VideoError(
            f"{manifest.clip.file} of {bundle.name} ends after {report.frames} of {len(bundle.frames)} frames. "
            "Copy the bundle again."
        )


def _changes(bundle: Bundle, components: Components) -> list[str]:
    """Differences between this installation and that of the run."""
    run = bundle.manifest.run
    found = []
    if run.engine_version != __version__:
        found.append(f"The run was made by engine {run.engine_version[:40]}, this is {__version__}.")
    for name in sorted(run.models.keys() | components.models.keys()):
        if run.models.get(name) != components.models.get(name):
            found.append(f"The model {name[:80]} is another than in the run.")
    return found


class _Comparison:
    """Counts judged frames that equal the stored ones, bit by bit."""

    def __init__(self, bundle: Bundle) -> None:
        self.identical: int | None = None
        self.first = ""
        self._first = bundle.manifest.frames.first
        self._reader: EvidenceReader | None = None
        try:
            self._reader = open_evidence(bundle)
            self._stored = self._reader.frames(pixels=False)
            self.identical = 0
        except EvidenceError as error:
            self.first = str(error)

    def add(self, frame: FrameEvidence) -> None:
        if self.identical is None:
            return
        try:
            stored = next(self._stored, None)
        except EvidenceError as error:
            self.identical, self.first = None, str(error)
            return
        if stored is None or frame.ordinal < self._first:
            return
        found = next(differences(frame, stored, ignore=RECOMPUTED), None)
        if found is None:
            self.identical += 1
        elif not self.first:
            self.first = f"frame {frame.ordinal}, {found[:200]}"

    def close(self) -> None:
        if self._reader is not None:
            self._reader.close()
