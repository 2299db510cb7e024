"""The job ``recording``: a run's evidence, the corrected annotation and ground truth as one ``.rrd`` file."""

from __future__ import annotations

from sqlalchemy import select
from sqlalchemy.orm import undefer

from app.edits.log_store import documents_of
from app.files.shared import ensure_local
from app.jobs.context import TaskContext
from app.labels.mapping import classes_in
from app.outputs.service import OutputService
from app.recordings.annotation import corrected_rows, truth_of
from app.recordings.summary import report_summary
from app.runs.source_run import run_of_job
from app.storage.lookup import newest_edit
from app.storage.models import Video
from app.videos.checked_file import ChangedError, library_file
from app.videos.file_changes import confirm_content
from app.videos.packed_table import unpack
from tsr_engine.errors import InputError
from tsr_engine.recording import RecordingRequest, write_recording


def record_run(task: TaskContext) -> None:
    """Make the recording.

    Raises:
        InputError: the run was removed, or the video's file has changed.
    """
    outputs, output, folder = OutputService.begin(task)
    options = output.options
    with task.database.read() as session:
        run = run_of_job(session, output.run_id)
        video = session.scalars(select(Video).where(Video.id == run.video_id).options(undefer(Video.frame_table))).one()
        documents = documents_of(session, run.id)
        edits = newest_edit(session, run.id)
        classes = classes_in(session, run)
        truth = truth_of(session, video.id, options.get("truth"), classes.labels)
    called = f"the run{f' {run.name!r}' if run.name else ''} of {video.name}"
    file = library_file(task.settings, video)
    if file.exists:
        try:
            confirm_content(task.database, file, video)
        except ChangedError:
            raise InputError(f"{file} is not the video of {called}: it has changed. Put that file back.") from None
    evidence = ensure_local(task.settings, run.place, run.folder)
    track = str(options.get("track") or "")
    request = RecordingRequest(
        evidence=evidence,
        out=folder / "recording.rrd",
        first=options["first"],
        stop=options["stop"],
        video=file if file.exists else None,
        table=unpack(video.frame_table) if file.exists and video.frame_table else None,
        limits=task.settings.video_limits,
        known=True,  # compared each time that it is opened
        corrected=corrected_rows(evidence, documents, classes),
        truth=truth,
        classes=classes,
        focus_frame=options.get("frame"),
        focus_track=int(track[1:]) if track.startswith("m") and track[1:].isdecimal() else None,
        name=options.get("name") or "",
        called=called,
        notes={"run": run.id, "run_name": run.name, "preset": run.preset},
    )
    report = write_recording(request, lambda done, of: outputs.progress(task, output.id, done, of))
    # with the edits' revision the page can tell whether a corrected box in the viewer still belongs to the same track
    outputs.complete(task, output.id, report.path, {**report_summary(report), "edits": edits})
