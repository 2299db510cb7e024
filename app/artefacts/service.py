"""What is done with artefacts: queued by routes, made by jobs, listed, downloaded, removed.

A job that makes one calls, in this order, ``begin``, ``progress`` as often as it likes, and ``complete``. It need not
clean up: when it is cancelled, fails or dies, its folder is removed, and ``begin`` starts with an empty one.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.artefacts.folders import artefact_folder, clear_folder, settle_file
from app.artefacts.settling import settle_artefact
from app.artefacts.view import ArtefactView, artefact_view, publish_artefact
from app.errors import Conflict, NotFound
from app.events import EventBus
from app.jobs.context import Stopped, TaskContext
from app.jobs.queue import JobQueue
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Artefact
from app.storage.places import require_here
from tsr_engine.errors import InputError
from tsr_engine.io.atomic import storage_error
from tsr_engine.io.digest import file_sha256

__all__ = ["KINDS", "ArtefactService"]

KINDS = ("export", "recording", "bundle", "scene")
PRIORITY = 15
"""Somebody waits for it: before imports, after what-ifs."""
_ACTIVE = ("queued", "running")
_TELL = 0.3
"""Seconds between two notes of progress."""


class ArtefactService:
    """Queue, make, list, open, cancel, remove."""

    def __init__(self, settings: Settings, database: Database, events: EventBus, jobs: JobQueue) -> None:
        self._home = settings.home
        self._database = database
        self._events = events
        self._jobs = jobs
        self._told: dict[str, float] = {}

    @classmethod
    def of_task(cls, task: TaskContext) -> ArtefactService:
        """The service within a worker."""
        return cls(task.settings, task.database, task.events, task.jobs)

    # ------------------------------------------------------------------------------------------------- for routes

    def queue(
        self, session: Session, kind: str, run_id: str | None, name: str, options: Mapping[str, Any], job_kind: str
    ) -> Artefact:
        """Ask for an artefact, within the caller's transaction.

        Args:
            session: writes.
            kind: one of ``KINDS``.
            run_id: the run that it is made from, where there is exactly one.
            name: file name offered for the download.
            options: everything that the job needs to know, as plain JSON values.
            job_kind: name of the job, see :mod:`app.kinds`; its subject is the artefact.
        """
        artefact = Artefact(
            id=uuid.uuid4().hex,
            kind=kind,
            run_id=run_id,
            name=name,
            state="queued",
            options=dict(options),
            done=0,
            path="",
            sha256="",
            summary={},
        )
        session.add(artefact)
        session.flush()
        self._jobs.submit(session, job_kind, artefact.id, priority=PRIORITY)
        publish_artefact(session, self._events, artefact)
        return artefact

    def get(self, artefact_id: str) -> Artefact:
        """One artefact.

        Raises:
            NotFound: there is none of that name.
        """
        with self._database.read() as session:
            return _require(session, artefact_id)

    def list(self, kind: str | None = None, run_id: str | None = None) -> list[ArtefactView]:
        """Artefacts, the newest first; of one kind, of one run."""
        query = select(Artefact).order_by(Artefact.created.desc(), Artefact.id)
        if kind is not None:
            query = query.where(Artefact.kind == kind)
        if run_id is not None:
            query = query.where(Artefact.run_id == run_id)
        with self._database.read() as session:
            return [artefact_view(artefact) for artefact in session.scalars(query)]

    def open(self, artefact_id: str) -> tuple[Path, str]:
        """The finished file, and the name that it is offered under.

        Raises:
            NotFound: no such artefact, or its file is gone.
            Conflict: it is not finished.
        """
        with self._database.read() as session:
            artefact = _require(session, artefact_id)
            require_here(session, artefact.place, artefact.name)
        if artefact.state != "complete":
            raise Conflict(f"{artefact.name} is {artefact.state}: there is no file yet.", code="not_complete")
        path = self._home / artefact.path
        if not path.is_file():
            raise NotFound(f"The file of {artefact.name} is gone from the data folder. Make it again.")
        return path, artefact.name

    def cancel(self, artefact_id: str) -> Artefact:
        """Stop the making of an artefact; nothing of it stays. One that is finished stays as it is."""
        with self._database.write() as session:
            artefact = _require(session, artefact_id)
            waited = [job for job in self._jobs.cancel(session, artefact_id) if job.state == "cancelled"]
            for job in waited:
                settle_artefact(session, self._events, job, "cancelled", None)
        if waited:
            clear_folder(self._home, artefact_id)
        return artefact

    def remove(self, artefact_id: str) -> None:
        """Remove an artefact with its file.

        Raises:
            NotFound: there is none of that name.
            Conflict: it is being made.
        """
        with self._database.write() as session:
            artefact = _require(session, artefact_id)
            require_here(session, artefact.place, artefact.name)
            if artefact.state in _ACTIVE:
                raise Conflict(f"{artefact.name} is {artefact.state}. Cancel it first.", code="still_running")
            session.delete(artefact)
            self._events.publish(session, "removed", artefact_id, {"artefact": artefact_id})
        clear_folder(self._home, artefact_id)

    def sweep(self) -> None:
        """Remove folders that nothing will ever come of: their work has failed or was cancelled as the machine died."""
        root = self._home / "artefacts"
        folders = {path.name for path in root.iterdir()} if root.is_dir() else set()
        if not folders:
            return
        with self._database.read() as session:
            kept = select(Artefact.id).where(Artefact.state.in_((*_ACTIVE, "complete")))
            folders -= set(session.scalars(kept))
        for name in folders:
            clear_folder(self._home, name)

    # --------------------------------------------------------------------------------------------------- for jobs

    def begin(self, task: TaskContext) -> tuple[Artefact, Path]:
        """Start to make the job's artefact: its row, and its folder, which is empty.

        Raises:
            InputError: the artefact has been removed.
            StorageError: its folder cannot be made.
            Fenced: the job belongs to another process.
        """
        with task.write() as session:
            artefact = session.get(Artefact, task.job.subject)
            if artefact is None:
                raise InputError("What was asked for has been removed in the meantime. Ask for it again.")
            artefact.state, artefact.error, artefact.done, artefact.total = "running", None, 0, None
            artefact.path, artefact.size, artefact.sha256, artefact.summary = "", None, "", {}
            publish_artefact(session, task.events, artefact)
        clear_folder(self._home, artefact.id)
        folder = artefact_folder(self._home, artefact.id)
        try:
            folder.mkdir(parents=True)
        except OSError as error:
            raise storage_error(folder, error) from None
        return artefact, folder

    def progress(self, task: TaskContext, artefact_id: str, done: int, total: int | None) -> None:
        """Note how far it is; cheap, so that it can be called for every track or frame.

        Raises:
            Stopped: a person has cancelled it, or the process is to end. Let it through.
            Fenced: the job belongs to another process.
        """
        now = time.monotonic()
        if task.leaving():
            raise Stopped
        if now - self._told.get(artefact_id, 0.0) < _TELL:
            return
        self._told[artefact_id] = now
        if task.cancelled():
            raise Stopped
        with task.write() as session:
            artefact = session.get_one(Artefact, artefact_id)
            artefact.done, artefact.total = done, total
            task.reached(session, done)
            publish_artefact(session, task.events, artefact)

    def complete(
        self, task: TaskContext, artefact_id: str, path: Path, summary: Mapping[str, Any], name: str | None = None
    ) -> None:
        """The file is whole.

        Args:
            task: the job.
            artefact_id: of the artefact.
            path: the file, in the folder that ``begin`` gave.
            summary: counts, skipped items; plain JSON values.
            name: another name for the download; unset: as it was queued.

        Raises:
            Fenced: the job belongs to another process.
            StorageError: the disk is full.
        """
        try:
            settle_file(path)
            digest, size = file_sha256(path), path.stat().st_size
        except OSError as error:
            raise storage_error(path, error) from None
        with task.write() as session:
            artefact = session.get_one(Artefact, artefact_id)
            artefact.state, artefact.error, artefact.finished = "complete", None, datetime.now(UTC)
            artefact.path, artefact.size, artefact.sha256 = str(path.relative_to(self._home)), size, digest
            artefact.total = artefact.total if artefact.total is not None else artefact.done
            artefact.done, artefact.summary = artefact.total, dict(summary)
            artefact.name = artefact.name if name is None else name
            publish_artefact(session, task.events, artefact)

    def fail(self, task: TaskContext, artefact_id: str, message: str) -> None:
        """It cannot be made; a job that raises a ``TsrError`` need not call this."""
        clear_folder(self._home, artefact_id)
        with task.write() as session:
            artefact = session.get_one(Artefact, artefact_id)
            artefact.state, artefact.error, artefact.finished = "failed", message, datetime.now(UTC)
            publish_artefact(session, task.events, artefact)


def _require(session: Session, artefact_id: str) -> Artefact:
    artefact = session.get(Artefact, artefact_id)
    if artefact is None:
        raise NotFound(f"There is no artefact {artefact_id[:40]!r}.")
    return artefact
