"""Operations on runs."""

from __future__ import annotations

import shutil
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.errors import Conflict, Invalid, NotFound
from app.events import EventBus
from app.files.shared import shared_files
from app.jobs.outcome import cancel_subject
from app.jobs.queue import JobQueue
from app.runs.parameters import asked_parameters, params_of
from app.runs.view import publish_run
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Job, Run, Video
from app.storage.of_run import require_run
from app.storage.places import Servers, lies_here, require_here
from app.videos.view import publish_video
from tsr_engine.version import __version__

__all__ = ["RunService"]

_ACTIVE = ("queued", "running")


class RunService:
    """Start, list, put in order, rename, cancel, resume, remove."""

    def __init__(
        self,
        settings: Settings,
        database: Database,
        events: EventBus,
        jobs: JobQueue,
        servers: Servers | None = None,
    ) -> None:
        self._settings = settings
        self._database = database
        self._events = events
        self._jobs = jobs
        self._servers = servers

    def of_video(self, video_id: str) -> list[Run]:
        """Runs of a video, the newest first.

        Raises:
            NotFound: no such video.
        """
        with self._database.read() as session:
            if session.get(Video, video_id) is None:
                raise NotFound(f"There is no video {video_id[:80]!r}.")
            return list(session.scalars(select(Run).where(Run.video_id == video_id).order_by(Run.order.desc(), Run.id)))

    def line(self) -> list[Run]:
        """Runs of the engine that go on or wait, in the order of their turns."""
        query = (
            select(Run)
            .join(Job, Job.subject == Run.id)
            .where(Job.kind == "track", Job.state.in_(_ACTIVE))
            .order_by(Job.state != "running", Job.priority.desc(), Job.order)
        )
        with self._database.read() as session:
            return list(session.scalars(query))

    def move(self, run_id: str, before: str | None) -> Run:
        """Let a run that waits take its turn right before another one, or after all of them.

        Raises:
            NotFound: no such run.
            Conflict: one of the two does not wait, or they wait for different servers.
        """
        with self._database.write() as session:
            run = require_run(session, run_id)
            if not self._jobs.move(session, run_id, before):
                raise Conflict(
                    f"{run.name} keeps its turn: it or the other run has begun, is over, or is another server's.",
                    code="not_waiting",
                )
            publish_run(session, self._events, run)
        return run

    def start(
        self,
        video_id: str,
        *,
        preset: str = "default",
        parameters: Mapping[str, object] | None = None,
        first: int = 0,
        stop: int | None = None,
        name: str = "",
    ) -> Run:
        """Queue a run of the engine.

        Raises:
            NotFound: no such video.
            Conflict: the video is not imported yet, or its import failed.
            Invalid: a parameter or the range of frames.
        """
        changed = asked_parameters(parameters or {})
        params_of(preset, changed)
        with self._database.write() as session:
            video = session.get(Video, video_id)
            if video is None:
                raise NotFound(f"There is no video {video_id[:80]!r}.")
            if video.state != "ready":
                raise Conflict(f"{video.name} is {video.state}: only an imported video can be run.", code="not_ready")
            frames = video.frames or 0
            if first >= frames or (stop is not None and stop <= first):
                raise Invalid(f"Frames {first} to {stop} are not in the video, which has {frames}.", field="first")
            run = Run(
                id=uuid.uuid4().hex,
                video_id=video_id,
                kind="engine",
                name=name or self._next_name(session, video_id),
                state="queued",
                preset=preset,
                parameters=changed,
                first=first,
                stop=None if stop is None else min(stop, frames),
                frames_total=min(stop or frames, frames) - first,
                engine_version=__version__,
            )
            run.folder = f"runs/{run.id}"
            if not lies_here(session, video.place):
                run.place = video.place  # the engine works where the video lies
            session.add(run)
            session.flush()
            self._jobs.submit(session, "track", run.id, place=run.place)
            publish_run(session, self._events, run)
        return run

    def _next_name(self, session: Session, video_id: str) -> str:
        used = set(session.scalars(select(Run.name).where(Run.video_id == video_id)))
        return next(name for k in range(1, len(used) + 2) if (name := f"Run {k}") not in used)

    def rename(self, run_id: str, name: str) -> Run:
        """Give a run another name; nothing else of it ever changes.

        Raises:
            NotFound: no such run.
            Invalid: the name is blank.
        """
        if not name.strip():
            raise Invalid("A run needs a name.", field="name")
        with self._database.write() as session:
            run = require_run(session, run_id)
            run.name = name.strip()
            publish_run(session, self._events, run)
        return run

    def cancel(self, run_id: str) -> Run:
        """Stop a run; what it has stored stays and can be resumed."""
        with self._database.write() as session:
            run = require_run(session, run_id)
            cancel_subject(session, self._jobs, run_id)
        return run

    def resume(self, run_id: str) -> Run:
        """Go on with a run that was cancelled, failed or interrupted.

        Raises:
            Conflict: it is running, or complete.
        """
        with self._database.write() as session:
            run = require_run(session, run_id)
            if run.state in _ACTIVE or run.state == "complete":
                raise Conflict(f"{run.name} is {run.state}: there is nothing to resume.", code="not_resumable")
            run.state, run.error = "queued", None
            self._jobs.submit(session, "whatif" if run.kind == "whatif" else "track", run.id, place=run.place)
            publish_run(session, self._events, run)
        return run

    def remove(self, run_id: str) -> None:
        """Remove a run with its evidence, its edits and its what-ifs.

        Raises:
            NotFound: no such run.
            Conflict: it is still going on, or a what-if of it is.
        """
        with self._database.write() as session:
            run = require_run(session, run_id)
            self._require_here(session, run)
            if run.state in _ACTIVE:
                raise Conflict(f"{run.name} is {run.state}. Cancel it first.", code="still_running")
            children = list(session.scalars(select(Run).where(Run.parent_id == run_id)))
            for child in children:
                if child.state in _ACTIVE:
                    raise Conflict(
                        f"The what-if {child.name} of {run.name} is {child.state}. Cancel it first.",
                        code="still_running",
                    )
            folders = self._drop(session, [*children, run])
        self._clear(folders)
        self._forget([*children, run])

    def remove_whatifs(self, run_id: str) -> list[str]:
        """Remove what was asked of a run, with evidence and edits; a replay that goes on stays.

        Returns:
            Names of the what-ifs that are gone.

        Raises:
            NotFound: no such run.
        """
        with self._database.write() as session:
            run = require_run(session, run_id)
            self._require_here(session, run)
            query = select(Run).where(Run.parent_id == run.id, Run.kind == "whatif", Run.state.not_in(_ACTIVE))
            gone = list(session.scalars(query))
            names = [one.id for one in gone]
            folders = self._drop(session, gone)
        self._clear(folders)
        self._forget(gone)
        return names

    def sweep(self) -> None:
        """Remove folders of runs that are gone, whose process died or still wrote as they were removed.

        Of this database's runs alone, and it knows them by their jobs: evidence in the folder may be another
        database's, or newer than a copy of this one that was put back.
        """
        root = self._settings.home / "runs"
        folders = {path.name for path in root.iterdir()} if root.is_dir() else set()
        with self._database.read() as session:
            for run_id, folder in session.execute(select(Run.id, Run.folder)):
                folders -= {run_id, Path(folder).name}
            gone = [name for name in folders if self._is_over(session, name)]
        self._clear([f"runs/{name}" for name in gone])

    def _require_here(self, session: Session, run: Run) -> None:
        """Refuse to remove what lies with another server, unless that is gone with all its files."""
        if self._servers is None or not self._servers.is_gone(run.place):
            require_here(session, run.place, run.name)

    @staticmethod
    def _is_over(session: Session, run_id: str) -> bool:
        """Whether there were jobs for a run, and none is left."""
        states = set(session.scalars(select(Job.state).where(Job.subject == run_id)))
        return bool(states) and not states & set(_ACTIVE)

    def _drop(self, session: Session, runs: Sequence[Run]) -> list[str]:
        """Take runs of one video out of the database, what-ifs before the run that they came from; their folders."""
        folders = [run.folder for run in runs]
        for run in runs:
            session.delete(run)
            self._events.publish(session, "removed", run.id, {"run": run.id, "video": run.video_id})
            session.flush()
        if runs:
            publish_video(session, self._events, session.get_one(Video, runs[0].video_id))
        return folders

    def _forget(self, runs: Sequence[Run]) -> None:
        """Remove the evidence of runs that are gone from the shared files."""
        if (files := shared_files(self._settings)) is not None:
            files.forget(*(run.folder for run in runs if run.place == files.id))

    def _clear(self, folders: Sequence[str]) -> None:
        for folder in folders:
            if folder.startswith("runs/"):
                shutil.rmtree(self._settings.home / folder, ignore_errors=True)
