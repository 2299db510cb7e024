"""A check: tracks reviewed drives again, measures the results against people's decisions, and reports."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from app.check.figures import Change, Unit, changes, over_budget
from app.check.regressions import Regression, find_regressions
from app.check.reviewed import ReviewedDrive
from tsr_engine.batch.manifest import Manifest
from tsr_engine.batch.run import BatchProgress, BatchRequest, run_batch
from tsr_engine.errors import InputError, UsageError
from tsr_engine.evaluation.track_tables import read_results
from tsr_engine.evaluation.tracking import VideoReport, evaluate_video
from tsr_engine.evidence import read_header
from tsr_engine.io.opened_file import display_path
from tsr_engine.labels.classes import RunClasses, classes_of_keys
from tsr_engine.track_table import TrackTable


@dataclass(frozen=True, slots=True)
class CheckedDrive:
    """One drive of a check.

    Attributes:
        reviewed: people's decisions.
        path: path of the video.
        folder: folder of the new results.
        classes: maps the class numbers of the new results to the video's label set.
        before, after: reports on the run's own results and on the new ones.
    """

    reviewed: ReviewedDrive
    path: Path
    folder: Path
    classes: RunClasses
    before: VideoReport
    after: VideoReport


@dataclass(frozen=True, slots=True)
class CheckReport:
    """The results of a check.

    Attributes:
        drives: drives that were measured.
        changes: all figures.
        unit: the unit that the bootstrap of the intervals draws.
        over: figures that exceed their budget, one sentence each.
        places: places that got worse, worst first.
        failures: drives that could not be tracked, each with an error sentence.
    """

    drives: list[CheckedDrive]
    changes: list[Change]
    unit: Unit
    over: list[str]
    places: list[Regression]
    failures: list[tuple[str, str]]


def check(
    drives: Sequence[ReviewedDrive],
    request: BatchRequest,
    allowed: Mapping[str, float],
    progress: Callable[[BatchProgress], None],
    stop: Callable[[], bool],
) -> CheckReport | None:
    """Track reviewed drives and measure the results.

    Args:
        drives: drives to check against.
        request: how to track; its drives and ranges are replaced.
        allowed: budgets, see :func:`app.check.figures.budgets`.
        progress: as for :func:`tsr_engine.batch.run.run_batch`.
        stop: as for ``run_batch``.

    Returns:
        The report; None if it was stopped.

    Raises:
        InputError: no drive could be tracked, or a video is missing.
        UsageError: two runs belong to one video, or as for ``run_batch``.
        StorageError: as for ``run_batch``.
    """
    paths = [_path(drive) for drive in drives]
    if repeated := [path for path, count in Counter(paths).items() if count > 1]:
        raise UsageError(f"Two of the runs belong to {repeated[0]}. Choose one run of each video.")
    ranges: dict[Path, tuple[int, int | None]] = {
        path: (drive.source.first, drive.source.stop) for path, drive in zip(paths, drives, strict=True)
    }
    manifest = run_batch(replace(request, drives=paths, ranges=ranges), progress, stop)
    if stop():
        return None
    checked, results, failures = _measured(drives, paths, request.out, manifest)
    if not checked:
        raise InputError(f"No drive could be tracked. The first one: {failures[0][1]}")
    before, after = [drive.before for drive in checked], [drive.after for drive in checked]
    found, unit = changes(before, after)
    places = find_regressions([drive.reviewed for drive in checked], before, after, results)
    return CheckReport(checked, found, unit, over_budget(found, allowed), places, failures)


def _path(drive: ReviewedDrive) -> Path:
    if drive.source.video.path is None:
        raise InputError(f"The video {drive.source.video.name} is missing. Put it back, or leave it out.")
    return display_path(drive.source.video.path).absolute()


def _measured(
    drives: Sequence[ReviewedDrive], paths: Sequence[Path], out: Path, manifest: Manifest
) -> tuple[list[CheckedDrive], list[TrackTable], list[tuple[str, str]]]:
    states = {drive.video: drive for drive in manifest.drives}
    checked: list[CheckedDrive] = []
    results: list[TrackTable] = []
    failures: list[tuple[str, str]] = []
    for drive, path in zip(drives, paths, strict=True):
        state = states[str(path)]
        if state.state != "done":
            failures.append((str(path), state.error))
            continue
        folder = out / state.folder
        rows, classes = _new_results(drive, folder)
        checked.append(CheckedDrive(drive, path, folder, classes, _report(drive, drive.results), _report(drive, rows)))
        results.append(rows)
    return checked, results, failures


def _new_results(drive: ReviewedDrive, folder: Path) -> tuple[TrackTable, RunClasses]:
    """The rows of a drive with labels of its video's set as classes, and the map from the model's class numbers."""
    rows = read_results(folder / "tracks.csv")
    classes = classes_of_keys(read_header(folder / "evidence").labels, drive.source.classes.labels)
    return replace(rows, class_id=classes.to_labels(rows.class_id)), classes


def _report(drive: ReviewedDrive, results: TrackTable) -> VideoReport:
    video, source = drive.source.video, drive.source
    return evaluate_video(
        video.name, drive.truth, results, source.stop - source.first, size=(video.width, video.height)
    )
