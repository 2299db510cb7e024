"""Operations on runs."""

from __future__ import annotations

import shutil
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.errors import Conflict, Invalid
from app.events import EventBus
from app.files.shared import remove_shared
from app.jobs.outcome import cancel_subject
from app.jobs.queue import JobQueue
from app.runs.parameters import params_of, present_parameters
from app.runs.unstored_ends import runs_with_unstored_ends, views_with_unstored_ends
from app.runs.view import RunView, publish_run
from app.settings import Settings
from app.storage.database import Database
from app.storage.lookup import ACTIVE, require_run, require_video
from app.storage.models import Job, Run, Video
from app.storage.servers import Servers, other_server, require_local, waiting_note
from app.videos.view import publish_video
from tsr_engine.version import __version__


class RunService:
    """Starts, lists, orders, renames, cancels, resumes and removes runs."""

    def __init__(
        self, settings: Settings, database: Database, events: EventBus, jobs: JobQueue, servers: Servers | None = None
    ) -> None:
        self._settings = settings
        self._database = database
        self._events = events
        self._jobs = jobs
        self._servers = servers

    def of_video(self, video_id: str) -> list[Run]:
        """Runs of a video, newest first.

        Raises:
            NotFound: no such video.
        """
        with self._database.read() as session:
            require_video(session, video_id)
            return list(session.scalars(select(Run).where(Run.video_id == video_id).order_by(Run.order.desc(), Run.id)))

    def queued_runs(self) -> list[Run]:
        """Running and waiting runs of the engine, in the order of their turns."""
        query = (
            select(Run)
            .join(Job, Job.subject == Run.id)
            .where(Job.kind == "track", Job.state.in_(ACTIVE))
            .order_by(Job.state != "running", Job.priority.desc(), Job.order)
        )
        with self._database.read() as session:
            return list(session.scalars(query))

    def views(self, runs: Sequence[Run]) -> list[RunView]:
        """Views of runs as they are now, also while nothing can be stored."""
        with self._database.read() as session:
            return views_with_unstored_ends(session, self._settings.home, runs)

    def with_unstored_ends(self) -> list[RunView]:
        """Views of the runs that have ended, but whose end cannot be stored."""
        with self._database.read() as session:
            return runs_with_unstored_ends(session, self._settings.home)

    def move(self, run_id: str, before: str | None) -> Run:
        """Move a waiting run right before another one, or after all of them.

        Raises:
            NotFound: no such run.
            Conflict: one of the two does not wait, or they wait for different servers.
        """
        with self._database.write() as session:
            run = require_run(session, run_id)
            if not self._jobs.move(session, run_id, before):
                raise Conflict(
                    f"{run.name} cannot be moved: it or the other run has started, has ended or is on another server.",
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

        Args:
            video_id: the video.
            preset: preset of parameters.
            parameters: changes of the preset, by name.
            first: first frame.
            stop: frame after the last; None: the video's end.
            name: name of the run; empty: the next free one.

        Raises:
            NotFound: no such video.
            Conflict: the video is not imported yet, or its import failed.
            Invalid: a parameter or the range of frames is wrong.
            Elsewhere: the video lies in shared files that this server does not use.
        """
        changed = present_parameters(parameters or {})
        params_of(preset, changed)
        with self._database.write() as session:
            video = require_video(session, video_id)
            if video.state != "ready":
                raise Conflict(
                    f"{video.name} is {video.state}. Only an imported video can be tracked.", code="not_ready"
                )
            frames = video.frames or 0
            if first >= frames or (stop is not None and stop <= first):
                raise Invalid(f"Frames {first} to {stop} are not in the video, which has {frames}.", field="first")
            run = Run(
                id=uuid.uuid4().hex,
                video_id=video_id,
                name=name or self._next_name(session, video_id),
                preset=preset,
                parameters=changed,
                first=first,
                stop=None if stop is None else min(stop, frames),
                frames_total=min(stop or frames, frames) - first,
                engine_version=__version__,
            )
            run.folder = f"runs/{run.id}"
            if other_server(session, video.place, video.name) is not None:
                run.place, run.note = video.place, waiting_note(session, video.place)
            session.add(run)
            session.flush()
            self._jobs.submit(session, "track", run.id, place=run.place)
            publish_run(session, self._events, run)
        return run

    def _next_name(self, session: Session, video_id: str) -> str:
        used = set(session.scalars(select(Run.name).where(Run.video_id == video_id)))
        return next(name for k in range(1, len(used) + 2) if (name := f"Run {k}") not in used)

    def rename(self, run_id: str, name: str) -> Run:
        """Rename a run; nothing else of a run can be changed.

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
        """Stop a run; its stored results are kept, and it can be resumed."""
        with self._database.write() as session:
            run = require_run(session, run_id)
            cancel_subject(session, self._jobs, run_id)
        return run

    def resume(self, run_id: str) -> Run:
        """Resume a run that was cancelled, failed or interrupted.

        Raises:
            NotFound: no such run.
            Conflict: it is running, or complete.
        """
        with self._database.write() as session:
            run = require_run(session, run_id)
            if run.state in ACTIVE or run.state == "complete":
                raise Conflict(f"{run.name} is {run.state}, so it cannot be resumed.", code="not_resumable")
            run.state, run.error, run.note = "queued", None, waiting_note(session, run.place)
            self._jobs.submit(session, "whatif" if run.kind == "whatif" else "track", run.id, place=run.place)
            publish_run(session, self._events, run)
        return run

    def remove(self, run_id: str) -> list[str]:
        """Remove a run with its evidence, its edits and its what-ifs.

        Returns:
            Ids of the removed runs.

        Raises:
            NotFound: no such run.
            Conflict: it or one of its what-ifs is still running.
        """
        with self._database.write() as session:
            run = require_run(session, run_id)
            self._require_here(session, run)
            if run.state in ACTIVE:
                raise Conflict(f"{run.name} is {run.state}. Cancel it first.", code="still_running")
            children = list(session.scalars(select(Run).where(Run.parent_id == run_id)))
            for child in children:
                if child.state in ACTIVE:
                    raise Conflict(
                        f"The what-if {child.name} of {run.name} is {child.state}. Cancel it first.",
                        code="still_running",
                    )
            removed = [*children, run]
            self._drop(session, removed)
        self._remove_files(removed)
        return [run.id for run in removed]

    def remove_whatifs(self, run_id: str) -> list[str]:
        """Remove the what-ifs of a run that have ended, with evidence and edits.

        Returns:
            Ids of the removed what-ifs.

        Raises:
            NotFound: no such run.
        """
        with self._database.write() as session:
            run = require_run(session, run_id)
            self._require_here(session, run)
            query = select(Run).where(Run.parent_id == run.id, Run.kind == "whatif", Run.state.not_in(ACTIVE))
            removed = list(session.scalars(query))
            self._drop(session, removed)
        self._remove_files(removed)
        return [run.id for run in removed]

    def sweep(self) -> None:
        """Remove leftover folders of removed runs, whose process died or was still writing.

        Only folders of runs with jobs in this database are removed: other evidence in the folder may belong to another
        database, or be newer than a restored copy of this one.
        """
        root = self._settings.home / "runs"
        folders = {path.name for path in root.iterdir()} if root.is_dir() else set()
        with self._database.read() as session:
            for run_id, folder in session.execute(select(Run.id, Run.folder)):
                folders -= {run_id, Path(folder).name}
            removed = [name for name in folders if self._is_over(session, name)]
        self._clear([f"runs/{name}" for name in removed])

    def _require_here(self, session: Session, run: Run) -> None:
        """Refuse to remove a run on another server, unless that server is gone with all its files."""
        if self._servers is None or not self._servers.is_dead(run.place):
            require_local(session, run.place, run.name)

    @staticmethod
    def _is_over(session: Session, run_id: str) -> bool:
        """Whether a run had jobs and all have ended."""
        states = set(session.scalars(select(Job.state).where(Job.subject == run_id)))
        return bool(states) and not states & set(ACTIVE)

    def _drop(self, session: Session, runs: Sequence[Run]) -> None:
        """Delete the rows of runs of one video, what-ifs before the run that they replay."""
        for run in runs:
            session.delete(run)
            self._events.publish(session, "removed", run.id, {"run": run.id, "video": run.video_id})
            session.flush()
        if runs:
            publish_video(session, self._events, session.get_one(Video, runs[0].video_id))

    def _remove_files(self, runs: Sequence[Run]) -> None:
        """Remove the evidence of removed runs here and from the shared files."""
        self._clear([run.folder for run in runs])
        remove_shared(self._settings, [(run.place, run.folder) for run in runs])

    def _clear(self, folders: Sequence[str]) -> None:
        for folder in folders:
            if folder.startswith("runs/"):
                shutil.rmtree(self._settings.home / folder, ignore_errors=True)
