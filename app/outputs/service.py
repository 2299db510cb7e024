"""Operations on outputs: routes queue them, jobs make them; list, download, remove.

A job calls ``begin``, ``progress`` any number of times, and ``complete``. It need not clean up: if it is cancelled,
fails or dies, its folder is removed, and ``begin`` starts with an empty one.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.errors import Conflict, NotFound
from app.events import EventBus
from app.files.shared import ensure_local, remove_shared
from app.jobs.context import Stopped, TaskContext
from app.jobs.outcome import cancel_subject
from app.jobs.queue import JobQueue
from app.outputs.folders import clear_folder, output_folder, sync_file
from app.outputs.view import OutputView, publish_output
from app.settings import Settings
from app.storage.database import Database
from app.storage.lookup import ACTIVE
from app.storage.models import Output
from app.storage.servers import require_local
from tsr_engine.errors import InputError
from tsr_engine.io.atomic import storage_error
from tsr_engine.io.digest import file_sha256

KINDS = ("export", "recording", "bundle", "scene")
PRIORITY = 15
"""Priority of outputs, because people wait for them: before imports, after what-ifs."""
PROGRESS_INTERVAL_S = 0.3
"""Seconds between updates of the progress."""


class OutputService:
    """Queue, make, list, open, cancel, remove."""

    def __init__(self, settings: Settings, database: Database, events: EventBus, jobs: JobQueue) -> None:
        self._settings = settings
        self._home = settings.home
        self._database = database
        self._events = events
        self._jobs = jobs
        self._reported: dict[str, float] = {}

    # ------------------------------------------------------------------------------------------------- for routes

    def queue(
        self, session: Session, kind: str, run_id: str | None, name: str, options: Mapping[str, object], job_kind: str
    ) -> Output:
        """Queue an output within the caller's transaction.

        Args:
            session: writes.
            kind: one of ``KINDS``.
            run_id: its run, if it is made from exactly one.
            name: file name of the download.
            options: all data that the job needs, as plain JSON values.
            job_kind: kind of the job, see :mod:`app.job_kinds`; its subject is the output.
        """
        output = Output(id=uuid.uuid4().hex, kind=kind, run_id=run_id, name=name, options=dict(options))
        session.add(output)
        session.flush()
        self._jobs.submit(session, job_kind, output.id, priority=PRIORITY)
        publish_output(session, self._events, output)
        return output

    def get(self, output_id: str) -> Output:
        """Return one output.

        Raises:
            NotFound: no such output.
        """
        with self._database.read() as session:
            return _require(session, output_id)

    def list(self, kind: str | None = None, run_id: str | None = None) -> list[OutputView]:
        """Outputs, newest first; of one kind, of one run, or all."""
        query = select(Output).order_by(Output.created.desc(), Output.id)
        if kind is not None:
            query = query.where(Output.kind == kind)
        if run_id is not None:
            query = query.where(Output.run_id == run_id)
        with self._database.read() as session:
            return [OutputView.from_row(output) for output in session.scalars(query)]

    def open(self, output_id: str) -> tuple[Path, str]:
        """Return the finished file, and its name for the download.

        Raises:
            NotFound: no such output, or its file is missing.
            Conflict: it is not finished.
        """
        with self._database.read() as session:
            output = _require(session, output_id)
            require_local(session, output.place, output.name)
        if output.state != "complete":
            raise Conflict(f"{output.name} is {output.state}, so it has no file yet.", code="not_complete")
        path = self._home / output.path
        ensure_local(self._settings, output.place, str(Path(output.path).parent))
        if not path.is_file():
            raise NotFound(f"The file of {output.name} is missing in the data folder. Make it again.")
        return path, output.name

    def cancel(self, output_id: str) -> Output:
        """Cancel the making of an output, and keep nothing of it. A finished output stays as it is."""
        with self._database.write() as session:
            output = _require(session, output_id)
            was_waiting = cancel_subject(session, self._jobs, output_id)
        if was_waiting:
            clear_folder(self._home, output_id)
        return output

    def remove(self, output_id: str) -> None:
        """Remove an output with its file.

        Raises:
            NotFound: no such output.
            Conflict: it is being made.
        """
        with self._database.write() as session:
            output = _require(session, output_id)
            require_local(session, output.place, output.name)
            if output.state in ACTIVE:
                raise Conflict(f"{output.name} is {output.state}. Cancel it first.", code="still_running")
            session.delete(output)
            self._events.publish(session, "removed", output_id, {"artefact": output_id})
        clear_folder(self._home, output_id)
        folder = output_folder(self._home, output_id).relative_to(self._home)
        remove_shared(self._settings, [(output.place, str(folder))])

    def sweep(self) -> None:
        """Remove folders of outputs whose job failed or was cancelled while the machine went down."""
        root = self._home / "artefacts"
        folders = {path.name for path in root.iterdir()} if root.is_dir() else set()
        if not folders:
            return
        with self._database.read() as session:
            kept = select(Output.id).where(Output.state.in_((*ACTIVE, "complete")))
            folders -= set(session.scalars(kept))
        for name in folders:
            clear_folder(self._home, name)

    # --------------------------------------------------------------------------------------------------- for jobs

    @classmethod
    def begin(cls, task: TaskContext) -> tuple[OutputService, Output, Path]:
        """Start to make the job's output; return the service within the worker, the output's row and its empty folder.

        Raises:
            InputError: the output has been removed.
            StorageError: its folder cannot be made.
            Fenced: the job belongs to another process.
        """
        service = cls(task.settings, task.database, task.events, task.jobs)
        with task.write() as session:
            output = session.get(Output, task.job.subject)
            if output is None:
                raise InputError("The output was removed in the meantime. Request it again.")
            output.state, output.error, output.done, output.total = "running", None, 0, None
            output.path, output.size, output.sha256, output.summary = "", None, "", {}
            publish_output(session, task.events, output)
        clear_folder(service._home, output.id)
        folder = output_folder(service._home, output.id)
        try:
            folder.mkdir(parents=True)
        except OSError as error:
            raise storage_error(folder, error) from None
        return service, output, folder

    def progress(self, task: TaskContext, output_id: str, done: int, total: int | None) -> None:
        """Report progress; cheap enough to call for every track or frame.

        Raises:
            Stopped: a person has cancelled it, or the process is to end. Do not catch it.
            Fenced: the job belongs to another process.
        """
        now = time.monotonic()
        if task.leaving():
            raise Stopped
        if now - self._reported.get(output_id, 0.0) < PROGRESS_INTERVAL_S:
            return
        self._reported[output_id] = now
        if task.is_cancelled():
            raise Stopped
        with task.write() as session:
            output = session.get_one(Output, output_id)
            output.done, output.total = done, total
            task.record_progress(session, done)
            publish_output(session, task.events, output)

    def complete(
        self, task: TaskContext, output_id: str, path: Path, summary: Mapping[str, object], name: str | None = None
    ) -> None:
        """Mark the output as complete, and end the job.

        Args:
            task: the job.
            output_id: the output.
            path: the file, in the folder from ``begin``.
            summary: counts and skipped items, as plain JSON values.
            name: new file name of the download; unset: unchanged.

        Raises:
            Stopped: a person has cancelled it in the meantime. Do not catch it.
            Fenced: the job belongs to another process.
            StorageError: the disk is full.
        """
        try:
            sync_file(path)
            digest, size = file_sha256(path), path.stat().st_size
        except OSError as error:
            raise storage_error(path, error) from None
        with task.complete() as session:
            output = session.get_one(Output, output_id)
            output.state, output.error, output.finished = "complete", None, datetime.now(UTC)
            output.path, output.size, output.sha256 = str(path.relative_to(self._home)), size, digest
            output.total = output.total if output.total is not None else output.done
            output.done, output.summary = output.total, dict(summary)
            output.name = output.name if name is None else name
            publish_output(session, task.events, output)


def _require(session: Session, output_id: str) -> Output:
    output = session.get(Output, output_id)
    if output is None:
        raise NotFound(f"There is no output {output_id[:40]!r}.")
    return output
