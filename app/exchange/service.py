"""Operations of routes on exports."""

from __future__ import annotations

from app.errors import Invalid
from app.exchange.export import ExportRequest, check_request
from app.exchange.run_sources import run_source
from app.outputs.names import file_stem
from app.outputs.service import OutputService
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Output, Run, Video
from tsr_engine.errors import ExportError, UsageError


class ExportService:
    """Checks requests for exports and queues their jobs."""

    def __init__(self, settings: Settings, database: Database, outputs: OutputService) -> None:
        self._settings = settings
        self._database = database
        self._outputs = outputs

    def start(self, request: ExportRequest) -> Output:
        """Queue an export.

        Raises:
            NotFound: no such run.
            Conflict: a run is not complete, or has no results.
            Invalid: two runs belong to one video, or an option is invalid.
        """
        try:
            check_request(request)
        except (UsageError, ExportError) as error:
            raise Invalid(str(error), code="bad_export") from None
        with self._database.write() as session:
            videos: dict[str, str] = {}
            for run_id in request.runs:
                run = session.get(Run, run_id)
                if run is not None and run.video_id in videos:
                    name = session.get_one(Video, run.video_id).name
                    raise Invalid(f"Two of the runs belong to {name}. Choose one run per video.", field="runs")
                source = run_source(session, self._settings, run_id)
                videos[source.video.sha256] = source.video.name
            options = request.model_dump(mode="json")
            only = request.runs[0] if len(request.runs) == 1 else None
            name = f"{_file_name(request, list(videos.values()))}.zip"
            return self._outputs.queue(session, "export", only, name, options, "export")


def _file_name(request: ExportRequest, videos: list[str]) -> str:
    if request.name.strip():
        return request.name.strip().removesuffix(".zip")
    more = f"-and-{len(videos) - 1}-more" if len(videos) > 1 else ""
    return f"{file_stem(videos[0], 'video')}{more}-{request.format}"
