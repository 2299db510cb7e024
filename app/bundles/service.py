"""Requests bug bundles of frames of a run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.errors import Conflict, Invalid
from app.evidence.frame_range import check_frames
from app.evidence.service import EvidenceService
from app.outputs.names import file_stem
from app.outputs.service import OutputService
from app.outputs.view import OutputView
from app.storage.database import Database
from app.storage.lookup import ACTIVE, require_run
from app.storage.models import TrackDocument, Video
from app.videos.error_text import with_upload_name
from tsr_engine.bundle.layout import MAX_FRAMES

JOB = "bundle"


class BundleService:
    """Checks requests for bundles and queues their jobs."""

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
        note: str = "",
        tracks: Sequence[str] = (),
        max_eq7: float | None = None,
    ) -> OutputView:
        """Queue a bundle of ``first <= frame < stop``.

        Args:
            run_id: the run.
            first: first frame.
            stop: frame after the last.
            note: the reporter's description.
            tracks: keys of the tracks with the problem; empty: all corrected tracks.
            max_eq7: allowed error (Eq. 7) of a corrected box; unset: the default.

        Raises:
            NotFound: no such run.
            Conflict: the run is unfinished or imported, or its video is missing.
            Invalid: the range is empty, too long or outside of the run, or a track does not exist.
        """
        check_frames(self._evidence, run_id, first, stop, "bundle", MAX_FRAMES)
        with self._database.write() as session:
            run = require_run(session, run_id)
            if run.kind == "imported":
                raise Conflict(
                    f"{run.name} was made by another program, so the engine cannot replay it.", code="not_replayable"
                )
            if run.state in ACTIVE:
                raise Conflict(f"{run.name} is still {run.state}. Wait until it is complete.", code="still_running")
            video = session.get_one(Video, run.video_id)
            if not Path(video.path).is_file():
                missing = with_upload_name(video, f"{video.path} is missing. Put the video back.")
                raise Conflict(missing, code="video_missing")
            for key in tracks:
                known = session.get(TrackDocument, (run_id, key)) is not None
                if not known and (not key.startswith("m") or self._evidence.span(run_id, int(key[1:])) is None):
                    raise Invalid(f"The run has no track {key}.", field="tracks")
            options = {"first": first, "stop": stop, "note": note, "tracks": sorted(set(tracks)), "max_eq7": max_eq7}
            name = f"{file_stem(video.name, 'video')}_{first}-{stop - 1}_bug.zip"
            return OutputView.from_row(self._outputs.queue(session, "bundle", run_id, name, options, JOB))
