"""An import that is cancelled or fails at its end leaves no thumbnail and no copy for scrubbing."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

import pytest

import app.videos.previews
from app.job_kinds import KINDS
from app.jobs.context import TaskContext
from app.jobs.worker import execute
from app.storage.models import Job, Video
from app.videos.import_files import import_files
from tests.app.toy_server import Server
from tests.io import video_corpus
from tsr_engine.errors import VideoError


@pytest.mark.parametrize(("end", "error"), [("cancelled", "The import was stopped"), ("failed", "a damaged frame")])
def test_an_unfinished_import_leaves_no_files(
    server: Server, monkeypatch: pytest.MonkeyPatch, end: str, error: str
) -> None:
    monkeypatch.setattr(app.videos.previews, "MAX_SEEK_S", 0.0)  # so that there is a copy
    made = video_corpus.make(video_corpus.RECIPES["constant"], server.settings.home, "drive")
    video = str(server.client.post("/api/videos", json={"path": str(made.path)}).json()["id"])
    context, files = server.context, import_files(server.settings.home, video)
    with context.database.write() as session:
        job = context.jobs.claim(session, context.jobs.waiting_ids(session)[0])
    assert job is not None
    written: list[bool] = []
    complete = TaskContext.complete

    def end_before(task: TaskContext, **options: Any) -> AbstractContextManager[Any]:
        written.extend(path.is_file() for path in files)
        if end == "failed":
            raise VideoError(error)
        with context.database.write() as session:
            context.jobs.cancel(session, video)
        return complete(task, **options)

    monkeypatch.setattr(TaskContext, "complete", end_before)
    execute(TaskContext(context.settings, context.database, context.events, context.jobs, job, lambda: False), KINDS)
    assert written == [True, True]
    with context.database.read() as session:
        assert session.get_one(Job, job.id).state == end
        assert error in str(session.get_one(Video, video).error)
    assert [path for path in files if path.exists()] == []
