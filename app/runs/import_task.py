"""The job ``import``; after the import of a sample drive on the first start it queues the first runs."""

from __future__ import annotations

import uuid

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.events import EventBus
from app.jobs.context import TaskContext
from app.jobs.queue import JobQueue
from app.runs.view import publish_run
from app.storage.models import Run, Video
from app.videos.importing import import_video
from sample_videos import SHIPPED
from tsr_engine.version import __version__


def import_and_start(task: TaskContext) -> None:
    """Import a video; a sample drive also starts the first runs."""
    import_video(task, sample_ready=_queue_first_runs)


def _queue_first_runs(session: Session, events: EventBus, jobs: JobQueue) -> None:
    """Queue a default run of each imported sample drive that has none, in the order in which they ship.

    The first screen shows the first drive, so nothing starts before that is imported.
    """
    for clip in SHIPPED:
        video = session.scalars(select(Video).where(Video.sample, Video.name == clip.video.name)).first()
        if video is None or video.state == "failed":
            continue
        if video.state != "ready":
            return  # called again at the end of its import
        if session.scalars(select(Run.id).where(Run.video_id == video.id).limit(1)).first() is None:
            _queue(session, events, jobs, video)


def _queue(session: Session, events: EventBus, jobs: JobQueue, video: Video) -> None:
    run_id = uuid.uuid4().hex
    run = Run(
        id=run_id,
        video_id=video.id,
        name="Run 1",
        frames_total=video.frames,
        folder=f"runs/{run_id}",
        engine_version=__version__,
    )
    if video.place is not None:
        run.place = video.place
    session.add(run)
    session.flush()
    jobs.submit(session, "track", run.id, priority=5, place=run.place)
    publish_run(session, events, run)
