"""A data folder with an imported clip and a supervisor, without a server."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.context import Context, build_context
from app.jobs.locks import holder
from app.jobs.supervisor import Supervisor
from app.settings import Settings
from app.storage.models import Job, Run
from sample_videos import SHIPPED
from tests.app.import_now import work_off
from tests.app.toy_server import SECRET

FRAMES = 96
LATEST = 50
"""Runs report progress three times a second: after this frame enough is left for a run to be seen in progress."""


@dataclass
class Office:
    """A data folder without a server, only with a supervisor."""

    context: Context
    video_id: str
    supervisor: Supervisor | None = None

    def open(self, workers: int = 1) -> None:
        """Start the supervisor."""
        c = self.context
        settings = c.settings.model_copy(update={"workers": workers})
        self.supervisor = Supervisor(settings, c.database, c.jobs)
        self.supervisor.start()

    def close(self) -> None:
        """Stop the workers, as a server does on shutdown."""
        if self.supervisor is not None:
            self.supervisor.stop()
        self.supervisor = None

    def start(self, video_id: str | None = None, stop: int = FRAMES) -> str:
        """Queue a run."""
        return self.context.runs.start(video_id or self.video_id, stop=stop).id

    def run(self, run_id: str) -> Run:
        with self.context.database.read() as session:
            return session.get_one(Run, run_id)

    def job(self, subject: str) -> Job:
        """The newest job of a subject."""
        with self.context.database.read() as session:
            return session.query(Job).filter(Job.subject == subject).order_by(Job.order.desc()).first()  # type: ignore[return-value]

    def worker(self, subject: str) -> int | None:
        """The process that works on a subject."""
        return holder(self.context.settings.home, self.job(subject).id)

    def wait(self, what: Callable[[], Any], seconds: float = 240.0) -> Any:
        """Wait until a condition holds; returns its value."""
        until = time.monotonic() + seconds
        while not (found := what()):
            assert time.monotonic() < until, "it does not happen"
            time.sleep(0.02)
        return found

    def ended(self, run_id: str, state: str = "complete") -> Run:
        """Wait for the end of a run."""
        run = self.wait(lambda: r if (r := self.run(run_id)).state not in ("queued", "running") else None)
        assert run.state == state, (run.state, run.error)
        return run  # type: ignore[no-any-return]

    def evidence(self, run_id: str) -> Path:
        return self.context.settings.home / self.run(run_id).folder


def make_office(home: Path, **settings: Any) -> Office:
    """A data folder with the first sample drive imported."""
    values = {"home": home, "roots": (home.parent,), "sample": False, "workers": 0, "token": SECRET, "author": "ada"}
    context = build_context(Settings(**{**values, **settings}))
    video = context.videos.add_path(str(SHIPPED[0].video))
    work_off(context, "import")
    return Office(context, video.id)
