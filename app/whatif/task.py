"""The job ``whatif``: replays a run's evidence with other parameters into a separate folder."""

from __future__ import annotations

import time
from collections.abc import Generator
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from app.files.shared import ensure_local
from app.jobs.context import Stopped, TaskContext
from app.labels.mapping import classes_in, labels_of_model
from app.runs.focus import focus_of
from app.runs.parameters import as_setting, params_of
from app.runs.source_run import run_of_job
from app.runs.view import publish_run
from app.storage.models import Run
from app.training.folders import models_of_run
from app.whatif.difference import difference
from tsr_engine.evidence import EvidenceReader, EvidenceWriter
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, load_components
from tsr_engine.runs.replay import ReplayReport, check_models, replay, run_params
from tsr_engine.version import __version__

PROGRESS_INTERVAL_S = 0.3
"""Seconds between updates of the progress."""


def run_whatif(task: TaskContext) -> None:
    """Replay; an interrupted what-if starts over, because it takes only seconds.

    Raises:
        Stopped: the job was asked to stop, or its subject was removed.
    """
    with task.write() as session:
        run = session.get_one(Run, task.job.subject)
        parent = run_of_job(session, run.parent_id)
        run.state, run.error, run.note, run.started = "running", None, "", run.started or datetime.now(UTC)
        models = models_of_run(task.settings, session, parent)
        requested_params = params_of(run.preset, run.parameters)
        publish_run(session, task.events, run)
    source = ensure_local(task.settings, parent.place, parent.folder)
    with EvidenceReader(source) as reader:
        params = run_params(reader).with_settings([(name, as_setting(value)) for name, value in run.parameters.items()])
        components = load_components(params, models)
        check_models(reader, components, params)
        report = ReplayReport()
        reported = time.monotonic()
        started, total = reported, len(reader)
        with closing(replay_into(task.settings.home / run.folder, reader, params, components, report)) as steps:
            for done in steps:
                now = time.monotonic()
                if now - reported < PROGRESS_INTERVAL_S:
                    continue
                reported = now
                if task.should_stop():
                    raise Stopped
                with task.write() as session:
                    row = session.get_one(Run, run.id)
                    row.frames_done, row.frames_total, row.rate = done, total, done / (now - started)
                    task.record_progress(session, done)
                    publish_run(session, task.events, row)
    with task.complete() as session:
        row = session.get_one(Run, run.id)
        row.state, row.finished = "complete", datetime.now(UTC)
        row.frames_done = row.frames_total = report.frames
        row.rate = report.frames / max(report.seconds, 1e-9)
        row.tracks, row.engine_version, row.models = len(report.tracks), __version__, dict(components.models)
        row.labels = labels_of_model(components.labels)
        row.summary = {
            "seconds": round(report.seconds, 2),
            "focus": focus_of(params, named=requested_params.tracking.coast_foe_y is not None),
            "identical_frames": report.identical,
            "missing_pixels": report.missing_pixels,
            "missing_frames": report.missing_frames,
            "difference": difference(report, classes_in(session, row)),
        }
        publish_run(session, task.events, row)


def replay_into(
    folder: Path, reader: EvidenceReader, params: Params, components: Components, report: ReplayReport
) -> Generator[int, None, None]:
    """Replay a run and store the result without pixels; yields the number of frames done after each frame.

    Args:
        folder: for the new evidence; an existing one is replaced.
        reader: the run.
        params: parameters of the replay.
        components: trained models.
        report: filled during the replay.
    """
    header = replace(
        reader.header,
        parameters=params.model_dump(mode="json"),
        models=dict(components.models),
        labels=components.labels,
        engine_version=__version__,
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        keep_pixels=False,
    )
    entries = reader.frame_table()
    with EvidenceWriter.create(folder, header, chunk=256, overwrite=True) as writer:
        for frame in replay(reader.folder, params, components, report=report):
            writer.append(frame, next(entries)[1])
            yield report.frames
