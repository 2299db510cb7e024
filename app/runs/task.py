"""The job ``track``: runs the engine over a video and stores evidence in the run's folder."""

from __future__ import annotations

import time
from datetime import UTC, datetime

from sqlalchemy.orm import undefer

from app.jobs.context import TaskContext
from app.labels.mapping import labels_of_model
from app.runs.executor import run_engine
from app.runs.focus import focus_of
from app.runs.parameters import params_of
from app.runs.view import publish_run
from app.storage.models import Run, Video
from app.training.folders import models_for_start
from app.videos.checked_file import library_file
from app.videos.error_text import with_upload_name
from app.videos.file_changes import require_unchanged
from app.videos.packed_table import unpack
from tsr_engine.pipeline import load_components
from tsr_engine.runs.track_video import Progress, RunRequest
from tsr_engine.version import __version__

_PROGRESS_INTERVAL_S = 0.3
"""Seconds between updates of the progress."""


def track(task: TaskContext) -> None:
    """Run the engine, or continue after the frames of an earlier process."""
    with task.database.read() as session:
        found = session.get_one(Run, task.job.subject)
        video = session.get_one(Video, found.video_id, options=(undefer(Video.frame_table),))
    file = library_file(task.settings, video)
    require_unchanged(task.database, file, video)  # may read the whole file, so do it before the writing transaction
    with task.write() as session:
        run = session.get_one(Run, task.job.subject)
        run.state, run.error, run.note = "running", None, ""
        run.started = run.started or datetime.now(UTC)
        models = models_for_start(task.settings, session, run)
        publish_run(session, task.events, run)
    params = params_of(run.preset, run.parameters)
    components = load_components(params, models)
    if components.labels is not None:
        with task.write() as session:
            session.get_one(Run, run.id).labels = labels_of_model(components.labels)
    request = RunRequest(
        file,
        params,
        evidence=task.settings.home / run.folder,
        start=run.first,
        stop=run.stop,
        table=None if video.frame_table is None else unpack(video.frame_table),
        limits=task.settings.video_limits,
        cores=task.settings.run_cores,
    )
    reported = 0.0

    def report_progress(progress: Progress) -> None:
        nonlocal reported
        now = time.monotonic()
        if now - reported < _PROGRESS_INTERVAL_S:
            return
        reported = now
        with task.write() as session:
            row = session.get_one(Run, run.id)
            row.frames_done, row.frames_total, row.rate = progress.done, progress.total, progress.rate
            task.record_progress(session, run.first + progress.done)
            publish_run(session, task.events, row)

    report = run_engine(task, request, components, models, report_progress)
    with task.complete() as session:
        row = session.get_one(Run, run.id)
        row.state, row.finished = "complete", datetime.now(UTC)
        row.frames_done = row.frames_total = report.frames
        row.tracks, row.engine_version, row.models = len(report.tracks), __version__, dict(components.models)
        row.rate = report.rate() or row.rate
        row.summary = {
            "seconds": round(report.seconds, 2),
            "focus": focus_of(report.params, named=params.tracking.coast_foe_y is not None),
            "events": dict(sorted(report.events.items())),
            "warnings": [with_upload_name(video, warning) for warning in report.warnings],
            "stages": {stage: round(median, 2) for stage, _, median, _ in report.stage_table()},
        }
        publish_run(session, task.events, row)
