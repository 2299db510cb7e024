"""Starts a recording of some frames of a run."""

from __future__ import annotations

from app.evidence.frame_range import check_frames
from app.evidence.service import EvidenceService
from app.outputs.names import file_stem
from app.outputs.service import OutputService
from app.outputs.view import OutputView
from app.storage.database import Database
from app.storage.lookup import require_run
from app.storage.models import Video

JOB = "recording"
MAX_FRAMES = 20_000
"""Maximum number of frames: the viewer holds a recording in memory, and larger ones make pages unusable."""


class RecordingService:
    """Queues recordings."""

    def __init__(self, database: Database, evidence: EvidenceService, outputs: OutputService) -> None:
        self._database = database
        self._evidence = evidence
        self._outputs = outputs

    def start(
        self,
        run_id: str,
        first: int,
        stop: int,
        *,
        name: str = "",
        frame: int | None = None,
        track: str | None = None,
        truth: str | None = None,
    ) -> OutputView:
        """Queue a recording of ``first <= frame < stop``.

        Args:
            run_id: the run.
            first: first frame.
            stop: frame after the last.
            name: name of the recording; unset: made from video and frames.
            frame: frame to show first.
            track: key of the track to select.
            truth: id of the ground truth to include; unset: the video's, if it has exactly one.

        Raises:
            NotFound: no such run.
            Conflict: the run has no results.
            Invalid: the range is empty, too long, or not within the frames of the run.
        """
        check_frames(self._evidence, run_id, first, stop, "recording", MAX_FRAMES)
        with self._database.write() as session:
            run = require_run(session, run_id)
            video = session.get_one(Video, run.video_id)
            options = {"first": first, "stop": stop, "name": name, "frame": frame, "track": track, "truth": truth}
            output = self._outputs.queue(
                session, "recording", run_id, _file_name(name or video.name, first, stop), options, JOB
            )
            return OutputView.from_row(output)


def _file_name(name: str, first: int, stop: int) -> str:
    return f"{file_stem(name, 'recording')}_{first}-{stop - 1}.rrd"
