"""The job ``retrain``: trains a new model version in a separate folder.

A stopped refinement starts over, because it takes minutes. A whole training on public data takes an hour, so its
finished parts are kept. The folder gets its final name in the transaction that completes the version.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from app.files.shared import ensure_local
from app.jobs.context import Stopped, TaskContext
from app.storage.models import ModelVersion, Output, Video
from app.training.folders import working_folder
from app.training.sources import export_age
from app.training.view import publish_model
from app.videos.checked_file import ChangedError, CheckedFile, library_file
from app.videos.error_text import with_upload_name
from app.videos.file_changes import confirm_content
from tsr_engine.errors import InputError, ModelError
from tsr_engine.io.unfinished import fsync_path
from tsr_engine.json_shapes import JsonObject
from tsr_engine.training.corrections.exports import OpenedExport, open_export
from tsr_engine.training.corrections.retrain import PARTS, Recipe, retrain
from tsr_engine.training.public.train_parts import train_parts

ExportReviews = Callable[[TaskContext, Sequence[str], Path], None]
REVIEWS = "reviews.zip"
"""File of the temporary export of current reviews."""
_MIN_INTERVAL_S = 0.3
"""Seconds between updates of the progress."""


class _JobProgress:
    """Stores stage and progress, and stops the job when it is asked to."""

    def __init__(self, task: TaskContext) -> None:
        self._task = task
        self._stages: list[str] = []
        self._reported = 0.0

    def __call__(self, stage: str, done: int, total: int) -> None:
        if self._task.should_stop():
            raise Stopped
        new = not self._stages or self._stages[-1] != stage
        now = time.monotonic()
        if not new and now - self._reported < _MIN_INTERVAL_S:
            return
        self._reported = now
        if new:
            self._stages.append(stage)
        with self._task.write() as session:
            version = session.get_one(ModelVersion, self._task.job.subject)
            version.stage, version.done, version.total = stage, done, total
            # a stage counts as a hundred steps, so that progress between crashes is visible
            self._task.record_progress(session, 100 * len(self._stages))
            publish_model(session, self._task.events, version)


def retrain_models(task: TaskContext, export_reviews: ExportReviews) -> None:
    """Train the version of the job's row.

    Args:
        task: the job.
        export_reviews: writes the current reviews of runs to a file;
            see :func:`app.exchange.retrain_task.export_reviews`.

    Raises:
        Stopped: the job was asked to stop, or its subject was removed.
        ModelError, InputError: the parent version or an export was removed meanwhile.
    """
    home = task.settings.home
    with task.write() as session:
        version = session.get(ModelVersion, task.job.subject)
        if version is None:
            raise Stopped
        request: JsonObject = dict(version.lineage["asked"])
        parent = _parent(task, session.get(ModelVersion, version.parent_id) if version.parent_id else None, version)
        version.state, version.error, version.note = "running", None, ""
        publish_model(session, task.events, version)
    final = home / "models" / version.id
    part, work = final.with_suffix(".part"), working_folder(home, version.id)
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    progress = _JobProgress(task)
    folders = {name: Path(path) for name, path in request["folders"].items()}
    seed = int(request["seed"])
    try:
        reviews = request.get("reviews", [])  # requests of earlier versions of tsr have none
        if reviews or request["exports"]:
            shutil.rmtree(part, ignore_errors=True)
            opened = [_export_reviews(task, reviews, work, export_reviews)] if reviews else []
            opened += [_open_export(task, entry, work) for entry in request["exports"]]
            recipe = Recipe(parts=tuple(p for p in PARTS if p in request["parts"]), seed=seed)
            report = retrain(opened, recipe, parent, part, work, progress, **folders)
        else:
            report = train_parts(tuple(request["parts"]), parent, part, seed, progress, **folders)
        _fsync_folder(part)
        shutil.rmtree(final, ignore_errors=True)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    with task.complete() as session:
        part.rename(final)
        fsync_path(final.parent)
        row = session.get_one(ModelVersion, version.id)
        row.state, row.error, row.stage, row.finished = "complete", None, "", datetime.now(UTC)
        row.done = row.total = 0
        row.lineage = {**row.lineage, **report.lineage}
        row.figures, row.models = dict(report.figures), dict(report.models)
        publish_model(session, task.events, row)


def _parent(task: TaskContext, parent: ModelVersion | None, version: ModelVersion) -> Path | None:
    """The folder to start from; its hashes are checked when it is read."""
    if version.parent_id is None:
        return task.settings.models
    if parent is None or parent.state != "complete":
        raise ModelError("The version to start from was removed meanwhile. Start from another one.")
    return ensure_local(task.settings, parent.place, parent.folder)


def _export_reviews(
    task: TaskContext, reviews: list[JsonObject], work: Path, export_reviews: ExportReviews
) -> OpenedExport:
    """The current reviews of some runs, by a temporary export."""
    export_reviews(task, [one["run"] for one in reviews], work / REVIEWS)
    opened = _open_with_videos(task, work / REVIEWS, "The review", work)
    return replace(opened, about={**opened.about, "name": "Present review"})


def _open_export(task: TaskContext, entry: JsonObject, work: Path) -> OpenedExport:
    """An export of the data folder, and the changes since it was made."""
    with task.database.read() as session:
        output = session.get(Output, entry["artefact"])
        if output is None or output.sha256 != entry["sha256"]:
            raise InputError(f"The export {entry['name']} was removed meanwhile. Export again.")
        path, name, age = task.settings.home / output.path, output.name, export_age(session, output)
    ensure_local(task.settings, output.place, str(Path(output.path).parent))
    opened = _open_with_videos(task, path, name, work)
    about = {**opened.about, "artefact": entry["artefact"], "name": name, "sha256": entry["sha256"]}
    about |= {"edits_since": age.edits, "undone_since": age.undone}
    return replace(opened, about=about)


def _open_with_videos(task: TaskContext, path: Path, name: str, work: Path) -> OpenedExport:
    """An export with those of its videos that are in the library."""
    notes: list[str] = []

    def find(sha256: str, _name: str) -> CheckedFile | None:
        with task.database.read() as session:
            video = session.get(Video, sha256)
        if video is None:
            return None
        file = library_file(task.settings, video)
        if not file.exists:
            return None
        try:
            confirm_content(task.database, file, video)
        except ChangedError:
            changed = f"{name}: {video.path} has changed since it was added and was not used for training."
            notes.append(with_upload_name(video, changed))
            return None
        return file

    opened = open_export(path, find, work, task.settings.video_limits, name)
    return replace(opened, notes=(*notes, *opened.notes))


def _fsync_folder(part: Path) -> None:
    """Sync the files and their folder to the disk."""
    for place in (*sorted(part.iterdir()), part):
        fsync_path(place)
