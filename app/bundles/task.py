"""The job ``bundle``: packs a run's frames, output and corrections as one ZIP. A cancelled job leaves nothing."""

from __future__ import annotations

from sqlalchemy import select
from sqlalchemy.orm import undefer

from app.bundles.request import bundle_request, report_summary
from app.errors import ApiError
from app.exchange.run_sources import run_source
from app.jobs.context import TaskContext
from app.outputs.service import OutputService
from app.runs.source_run import run_of_job
from app.storage.models import Video
from app.training.folders import models_of_run
from app.videos.packed_table import unpack
from tsr_engine.bundle import make_bundle
from tsr_engine.errors import InputError, ModelError

FILE = "bundle.zip"


def make_run_bundle(task: TaskContext) -> None:
    """Make the bundle with the corrections that are stored when the job begins.

    Raises:
        InputError: the run was removed or cannot be packed.
    """
    outputs, output, folder = OutputService.begin(task)
    options = output.options
    with task.database.read() as session:
        run = run_of_job(session, output.run_id)
        try:
            source = run_source(session, task.settings, run.id)
        except ApiError as error:
            raise InputError(error.message) from None
        video = session.scalars(select(Video).where(Video.id == run.video_id).options(undefer(Video.frame_table))).one()
        try:
            models = models_of_run(task.settings, session, run)
        except ModelError:
            models = None  # removed since; the bundle's manifest says so
    request = bundle_request(
        source,
        folder / FILE,
        options["first"],
        options["stop"],
        note=options["note"],
        tracks=options["tracks"],
        models=() if models is None else (models,),
        table=None if video.frame_table is None else unpack(video.frame_table),
        max_eq7=options.get("max_eq7"),
    )
    report = make_bundle(request, lambda done, of: outputs.progress(task, output.id, done, of))
    outputs.complete(task, output.id, report.path, report_summary(report))
