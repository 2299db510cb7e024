"""Starts the export of a scene as a file."""

from __future__ import annotations

from collections.abc import Mapping

from app.evidence.service import EvidenceService
from app.outputs.names import file_stem
from app.outputs.service import OutputService
from app.outputs.view import OutputView
from app.storage.database import Database
from app.storage.lookup import require_run
from app.storage.models import Video

JOB = "scene"


class SceneService:
    """Checks requests for scenes and queues their jobs."""

    def __init__(self, database: Database, evidence: EvidenceService, outputs: OutputService) -> None:
        self._database = database
        self._evidence = evidence
        self._outputs = outputs

    def start(self, run_id: str, options: Mapping[str, object], name: str = "") -> OutputView:
        """Queue the export of a scene.

        Args:
            run_id: the run.
            options: ``mode``, and further fields of :class:`app.scene3d.view_state.ViewState`; None: the default of the
                run.
            name: name of the file; unset: made from video, run and mode.

        Raises:
            NotFound: no such run.
            Conflict: it has no results yet.
        """
        with self._evidence.reading(self._evidence.stored_run(run_id)):
            pass
        with self._database.write() as session:
            run = require_run(session, run_id)
            video = session.get_one(Video, run.video_id)
            usual = f"{file_stem(video.name, 'video')}_{file_stem(run.name, 'run')}_{options['mode']}"
            file = f"{file_stem(name, usual)}.html"
            return OutputView.from_row(self._outputs.queue(session, "scene", run_id, file, options, JOB))
