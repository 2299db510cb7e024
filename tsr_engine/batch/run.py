"""Runs a batch: one folder of results for each drive, a manifest of the progress, and a summary."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from tsr_engine.batch.drives import folder_names
from tsr_engine.batch.executors import Outcomes, run_locally, run_on_ray
from tsr_engine.batch.manifest import DriveState, Identity, Manifest, load_manifest, save_manifest
from tsr_engine.batch.summary import write_summary
from tsr_engine.batch.task import REPORT_FILE, DriveTask
from tsr_engine.batch.worker import unfinished_folder
from tsr_engine.errors import StorageError, UsageError
from tsr_engine.json_shapes import JsonObject


@dataclass(frozen=True)
class BatchRequest:
    """A request to run a batch.

    Attributes:
        drives: absolute paths.
        out: folder of the results.
        identity: inputs that decide the results.
        task: template of the tasks; ``video`` and ``folder`` are replaced.
        target: ``local``, ``ray`` or the ``HOST:PORT`` of a Ray cluster.
        jobs: processes at a time on this machine.
        restart: whether to discard results of earlier calls.
        ranges: first frame and the frame after the last, for drives that are not tracked whole.
    """

    drives: Sequence[Path]
    out: Path
    identity: Identity
    task: DriveTask
    target: str = "local"
    jobs: int = 1
    restart: bool = False
    ranges: Mapping[Path, tuple[int, int | None]] = field(default_factory=dict)


@dataclass(frozen=True)
class BatchProgress:
    """The progress of a batch.

    Attributes:
        done, failed, total: numbers of drives.
        rate: frames per second of this call; None: not known yet.
        remaining: estimated seconds left, by the size of the videos; None: not known yet.
        note: what a process of a drive does before it tracks; empty: nothing to say.
    """

    done: int
    failed: int
    total: int
    rate: float | None
    remaining: float | None
    note: str = ""


def run_batch(request: BatchRequest, progress: Callable[[BatchProgress], None], stop: Callable[[], bool]) -> Manifest:
    """Track all drives that are not finished.

    Args:
        request: the request.
        progress: called when a drive ends, and in several threads when there is a note.
        stop: True ends the batch; finished drives are kept, and the next call continues.

    Returns:
        The manifest in the folder. It gives the reasons of failed drives; the others continue.

    Raises:
        UsageError: the folder has results of other parameters, models or version, or another batch writes it.
        StorageError: the folder cannot be written.
    """
    with _exclusive_lock(request.out):
        manifest = _load_or_make_manifest(request)
        _reset_changed(manifest, request)
        if not request.restart:
            _adopt_finished(manifest, request)
        wanted = {str(path) for path in request.drives}
        todo = [drive for drive in manifest.drives if drive.video in wanted and drive.state != "done"]
        save_manifest(manifest, request.out)
        tracker = _ProgressTracker(manifest, todo)
        tasks = [_make_task(request, drive) for drive in todo]

        def show_note(text: str) -> None:
            if text:
                progress(replace(tracker.progress(), note=text))

        for index, outcome in _run_tasks(request, tasks, tracker, stop, show_note):
            drive = todo[index]
            if outcome.result is None:
                drive.state, drive.error, drive.result = "failed", outcome.error, {}
            else:
                drive.state, drive.error, drive.result = "done", "", outcome.result
            save_manifest(manifest, request.out)
            tracker.finish_drive(index, drive.state == "done")
            progress(tracker.progress())
        write_summary(manifest, request.out)
        return manifest


def _run_tasks(
    request: BatchRequest,
    tasks: list[DriveTask],
    tracker: _ProgressTracker,
    stop: Callable[[], bool],
    note: Callable[[str], None],
) -> Outcomes:
    if not tasks:
        return iter(())
    if request.target == "local":
        return run_locally(tasks, request.jobs, tracker.update, stop, note)
    return run_on_ray(tasks, None if request.target == "ray" else request.target, tracker.update, stop, note)


def _load_or_make_manifest(request: BatchRequest) -> Manifest:
    known = load_manifest(request.out)
    if known is not None and request.restart:
        for drive in known.drives:
            shutil.rmtree(unfinished_folder(request.out / drive.folder), ignore_errors=True)
        known = None
    if known is not None and (differences := request.identity.differences(known.identity)):
        shown = "; ".join(differences[:3]) + ("; ..." if len(differences) > 3 else "")
        raise UsageError(
            f"{request.out} holds results of another batch ({shown}). Use the same settings, another --out, or "
            "--restart to track all drives again."
        )
    manifest = known or Manifest(request.identity, [])
    drive_by_video = {drive.video: drive for drive in manifest.drives}
    names = folder_names(request.drives, {Path(drive.video): drive.folder for drive in manifest.drives})
    for path in request.drives:
        if str(path) not in drive_by_video:
            manifest.drives.append(DriveState(str(path), names[path]))
    return manifest


def _reset_changed(manifest: Manifest, request: BatchRequest) -> None:
    """Mark drives to be tracked again if their file or frames have changed, or a wanted result is missing."""
    out, wanted = request.out, {str(path) for path in request.drives}
    for drive in manifest.drives:
        try:
            status = Path(drive.video).stat()
            size, changed = status.st_size, status.st_mtime_ns
        except OSError:
            size = changed = 0  # the process that opens it says what is wrong
        if (size, changed) != (drive.size, drive.changed) and drive.state != "waiting" and size:
            drive.state = "waiting"
        drive.size, drive.changed = size or drive.size, changed or drive.changed
        folder = out / drive.folder
        if drive.video in wanted and drive.stamp != (stamp := _make_task(request, drive).stamp):
            shutil.rmtree(unfinished_folder(folder), ignore_errors=True)  # of another file or of other frames
            drive.stamp = stamp
        is_done = _is_finished(drive, drive.result, request) if drive.video in wanted else folder.is_dir()
        if drive.state == "done" and not is_done:
            drive.state = "waiting"


def _is_finished(drive: DriveState, report: JsonObject, request: BatchRequest) -> bool:
    """Whether a report is that of a drive's task, and its folder holds all results that the batch keeps."""
    task = _make_task(request, drive)
    kept = {"evidence": task.evidence, "csv": task.csv, "annotated": task.annotated}
    names = [report.get(key) for key, is_kept in kept.items() if is_kept]
    places = [request.out / drive.folder / name for name in (REPORT_FILE, *names) if name is not None]
    return report.get("stamp") == task.stamp and None not in names and all(place.exists() for place in places)


def _make_task(request: BatchRequest, drive: DriveState) -> DriveTask:
    """The task for a drive; its stamp identifies the file and the inputs of its results."""
    start, stop = request.ranges.get(Path(drive.video), (0, None))
    identity, file = request.identity, (drive.video, drive.size, drive.changed)
    inputs = [identity.version, identity.parameters, identity.models, *file, start, stop]
    return replace(
        request.task,
        video=drive.video,
        folder=str(request.out.absolute() / drive.folder),
        start=start,
        stop=stop,
        stamp=hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest(),
    )


def _adopt_finished(manifest: Manifest, request: BatchRequest) -> None:
    """Take over results that became whole just when the previous call was stopped."""
    for drive in manifest.drives:
        if drive.state == "done":
            continue
        try:
            report = json.loads((request.out / drive.folder / REPORT_FILE).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            continue
        if _is_finished(drive, report, request):
            drive.state, drive.error, drive.result = "done", "", report


class _ProgressTracker:
    """Frames and bytes that this call has tracked, for the rate and the time left; other threads call ``update``."""

    def __init__(self, manifest: Manifest, todo: list[DriveState]) -> None:
        self._manifest = manifest
        self._sizes = [drive.size for drive in todo]
        self._lock = threading.Lock()
        self._frames: dict[int, int] = {}
        self._first_frames: dict[int, int] = {}
        self._tracked = [0.0] * len(todo)
        self._left = [1.0] * len(todo)
        self._start_time = time.monotonic()

    def update(self, index: int, done: int, total: int | None) -> None:
        with self._lock:
            first = self._first_frames.setdefault(index, done if total is None or done < total else 0)
            self._frames[index] = done
            if total:
                self._tracked[index] = min(1.0, (done - first) / total)
                self._left[index] = max(0.0, 1 - done / total)

    def finish_drive(self, index: int, is_tracked: bool) -> None:
        with self._lock:
            if is_tracked:  # the rest of a failed drive took no time
                self._tracked[index] += self._left[index]
            self._left[index] = 0.0

    def progress(self) -> BatchProgress:
        with self._lock:
            elapsed = time.monotonic() - self._start_time
            frames = sum(n - self._first_frames[k] for k, n in self._frames.items())
            tracked, left = (
                sum(share * size for share, size in zip(shares, self._sizes, strict=True))
                for shares in (self._tracked, self._left)
            )
        states = [drive.state for drive in self._manifest.drives]
        return BatchProgress(
            states.count("done"),
            states.count("failed"),
            len(states),
            frames / elapsed if frames and elapsed else None,
            left * elapsed / tracked if tracked else None,
        )


@contextmanager
def _exclusive_lock(out: Path) -> Iterator[None]:
    try:
        out.mkdir(parents=True, exist_ok=True)
        lock = os.open(out / ".batch.lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    except OSError as error:
        raise StorageError(f"{out} cannot be written: {error.strerror}. Choose another --out.") from None
    try:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UsageError(f"Another batch writes {out}. Wait for it, or choose another --out.") from None
        yield
    finally:
        os.close(lock)
