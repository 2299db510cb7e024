"""A data folder with an imported clip and a supervisor, without a server."""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.context import Context, build_context
from app.job_kinds import KINDS
from app.jobs.lanes import Lane
from app.jobs.locks import holder_pid
from app.jobs.supervisor import Supervisor, as_environment
from app.jobs.worker import main
from app.settings import Settings
from app.storage.models import Job, Run
from sample_videos import SHIPPED
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import SECRET
from tests.forked_program import ForkedProgram
from tests.waiting import wait_until

FRAMES = 80
MAX_FRAME_IN_PROGRESS = 34
"""Runs report progress three times a second: after this frame enough is left for a run to be seen in progress."""


class ForkingSupervisor(Supervisor):
    """One whose workers are forked from a process that has loaded the engine.

    Attributes:
        program: the workers' program.
    """

    program = f"{__name__}:do_jobs"

    def spawn(self, lane: Lane, *further: str, stdin: int = subprocess.DEVNULL) -> Any:
        """Start a worker of a lane."""
        passed = {f"TSR_{name.upper()}": value for name, value in as_environment(self._settings).items()}
        return ForkedProgram(self.program, [lane, *further], {**os.environ, **passed}, stdin=stdin)


def do_jobs(arguments: list[str]) -> int:
    """``app.worker`` below the process that it is forked from."""
    return main(KINDS, [str(os.getppid()), *arguments])


KNOWN_FOCUS = {"coast_foe_y": 0.5}
"""Where the camera looks, which a run would else find out from 250 frames first."""


@dataclass
class JobServer:
    """A data folder with a supervisor, without a web server.

    Attributes:
        supervising: the supervisor's class.
    """

    context: Context
    video_id: str
    supervisor: Supervisor | None = None
    supervising: type[Supervisor] = ForkingSupervisor

    def open(self, workers: int = 1) -> None:
        """Start the supervisor."""
        c = self.context
        settings = c.settings.model_copy(update={"workers": workers})
        self.supervisor = self.supervising(settings, c.database, c.jobs)
        self.supervisor.start()

    def close(self) -> None:
        """Stop the workers, as a server does on shutdown."""
        if self.supervisor is not None:
            self.supervisor.stop()
        self.supervisor = None

    def start(self, video_id: str | None = None, stop: int = FRAMES) -> str:
        """Queue a run."""
        return self.context.runs.start(video_id or self.video_id, stop=stop, parameters=KNOWN_FOCUS).id

    def run(self, run_id: str) -> Run:
        with self.context.database.read() as session:
            return session.get_one(Run, run_id)

    def job(self, subject: str) -> Job:
        """The newest job of a subject."""
        with self.context.database.read() as session:
            return session.query(Job).filter(Job.subject == subject).order_by(Job.order.desc()).first()  # type: ignore[return-value]

    def worker(self, subject: str) -> int | None:
        """The process that works on a subject."""
        return holder_pid(self.context.settings.home, self.job(subject).id)

    def ended(self, run_id: str, state: str = "complete") -> Run:
        """Wait for the end of a run."""
        run = wait_until(lambda: r if (r := self.run(run_id)).state not in ("queued", "running") else None)
        assert run.state == state, (run.state, run.error)
        return run  # type: ignore[no-any-return]

    def evidence(self, run_id: str) -> Path:
        return self.context.settings.home / self.run(run_id).folder


def make_job_server(home: Path, **settings: Any) -> JobServer:
    """A data folder with the first sample drive imported."""
    values = {"home": home, "roots": (home.parent,), "sample": False, "workers": 0, "token": SECRET, "author": "ada"}
    context = build_context(Settings(**{**values, **settings}))
    video = context.videos.add_path(str(SHIPPED[0].video))
    run_jobs(context, "import")
    return JobServer(context, video.id)
