"""The job ``export``: one ZIP file from runs. A cancelled or killed job leaves nothing; a killed job starts again."""

from __future__ import annotations

from app.errors import ApiError
from app.exchange.export import ExportRequest, export_sources, summary_of
from app.exchange.run_sources import run_source
from app.jobs.context import TaskContext
from app.outputs.service import OutputService
from app.runs.source_run import run_of_job
from tsr_engine.errors import ExportError

FILE = "export.zip"


def export(task: TaskContext) -> None:
    """Write the export in the output's options, with the corrections that are stored when the job begins."""
    outputs, output, folder = OutputService.begin(task)
    request = ExportRequest.model_validate(output.options)
    try:
        with task.database.read() as session:
            runs = [run_of_job(session, run_id).id for run_id in request.runs]
            sources = [run_source(session, task.settings, run_id) for run_id in runs]
        manifest = export_sources(
            request,
            sources,
            folder / FILE,
            zipped=True,
            progress=lambda done, of: outputs.progress(task, output.id, done, of),
        )
    except ApiError as error:
        raise ExportError(error.message) from None
    outputs.complete(task, output.id, folder / FILE, summary_of(manifest))
