"""The note of a job that compiles kernels: written while they are compiled, shown to people, and gone afterwards."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba
import pytest
from sqlalchemy import select

from app.job_kinds import KINDS
from app.jobs import compilation_notes
from app.jobs.compilation_notes import note_preparation
from app.jobs.context import TaskContext
from app.jobs.kinds import JobKind, JobKinds
from app.jobs.outcome import end_stopped_task
from app.jobs.queue import JobQueue
from app.jobs.tasks import TaskKind
from app.jobs.worker import execute, work
from app.storage.models import Event, Follow, Job, ModelVersion, Run
from tests.app.toy_home import ToyHome, make_home
from tests.app.toy_server import Server
from tsr_engine import compilation
from tsr_engine.compilation import COMPILING

KINDS_WITH_NOTES = ("follow", "whatif", "track", "retrain")
"""Kinds of jobs that compile kernels while a person waits for them."""


class JobApi:
    """A server on a toy home, whose jobs this process claims."""

    def __init__(self, home: ToyHome, server: Server) -> None:
        self.home, self.context, self.client = home, server.context, server.client

    def subject(self, kind: str) -> Run | Follow | ModelVersion:
        """A new subject for a job of a kind."""
        name = uuid.uuid4().hex
        match kind:
            case "follow":
                request = {"anchors": [], "only": None, "first": 0, "last": None}
                return Follow(id=name, run_id=self.home.run_id, author="ada", key="m1", request=request, endings=[])
            case "retrain":
                return ModelVersion(id=name, name="Second", lineage={"asked": {}}, figures={}, models={})
            case _:
                return Run(id=name, video_id=self.home.video_id, name=kind, kind=kind if kind == "whatif" else "engine")

    def claimed(self, kind: str, kinds: JobKinds[JobKind] = KINDS) -> TaskContext:
        """A running job with a running subject."""
        c, jobs = self.context, JobQueue(self.context.events, kinds)
        subject = self.subject(kind)
        subject.state = "running"
        with c.database.write() as session:
            session.merge(subject)
            job = jobs.claim(session, jobs.submit(session, kind, subject.id).id)
        assert job is not None
        return TaskContext(c.settings, c.database, c.events, jobs, job, lambda: False)

    def view(self, kind: str, subject: str) -> Any:
        """What a page reads about a subject."""
        rooms = {"follow": "follows", "retrain": "models"}
        return self.client.get(f"/api/{rooms.get(kind, 'runs')}/{subject}").json()


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[JobApi]:
    home = make_home(tmp_path_factory.mktemp("noting"), 80)
    server = Server(home.settings.home, roots=(home.video.parent,))
    with server.client:
        yield JobApi(home, server)
    home.evidence.close()
    home.database.close()


def test_kinds_that_people_wait_for_have_notes() -> None:
    assert {kind.name for kind in KINDS if kind.on_note is not None} == set(KINDS_WITH_NOTES)


@pytest.mark.parametrize("kind", KINDS_WITH_NOTES)
def test_a_note_is_shown_while_the_job_runs(api: JobApi, kind: str) -> None:
    task = api.claimed(kind)
    subject = task.job.subject
    task.note("it compiles")
    assert api.view(kind, subject)["note"] == "it compiles"
    with api.context.database.read() as session:
        events = session.scalars(select(Event).where(Event.subject == subject)).all()
    notes = [event.data["note"] for event in events if "note" in event.data]
    assert notes == ([] if kind == "follow" else ["it compiles"]), "a page polls for its follow"
    end_stopped_task(task)
    view = api.view(kind, subject)
    assert (view["state"], view["note"]) == ("queued", "")


@pytest.mark.parametrize("kind", KINDS_WITH_NOTES)
def test_a_job_that_is_over_has_no_note(api: JobApi, kind: str) -> None:
    task = api.claimed(kind)
    task.note("it compiles")
    table = {"follow": Follow, "retrain": ModelVersion}.get(kind, Run)
    with task.complete() as session:
        session.get_one(table, task.job.subject).state = "complete"  # type: ignore[attr-defined]
    assert api.view(kind, task.job.subject)["note"] == ""


class CompilingJob:
    """A kind of job that calls a kernel."""

    def __init__(self, api: JobApi, monkeypatch: pytest.MonkeyPatch) -> None:
        self.notes: list[str] = []
        self.kernel: Any = numba.njit(lambda x: x + 1)
        self.noted, self.cleared = threading.Event(), threading.Event()
        self.waits = True
        kind = TaskKind(name="track", lane="long", load=lambda: self.work, on_failed=lambda *_: None, on_note=self.note)
        self.kinds = JobKinds([kind], worker="no.such.module")
        self.task = api.claimed("track", self.kinds)
        monkeypatch.setattr(compilation_notes, "CHECK_INTERVAL_S", 0.01)
        monkeypatch.setattr(compilation, "NEXT_KERNEL_S", 0.3)

    def note(self, _session: Any, _events: Any, job: Job, note: str) -> None:
        if job.subject == self.task.job.subject:  # other tests leave jobs in the queue
            self.notes.append(note)
            (self.noted if note else self.cleared).set()

    def work(self, _task: TaskContext) -> None:
        self.kernel(1)
        if self.waits:
            assert self.noted.wait(60)
            assert self.cleared.wait(60)


@pytest.fixture
def compiling_job(api: JobApi, monkeypatch: pytest.MonkeyPatch) -> CompilingJob:
    return CompilingJob(api, monkeypatch)


def test_a_job_notes_that_it_compiles_and_then_that_it_is_over(compiling_job: CompilingJob) -> None:
    execute(compiling_job.task, compiling_job.kinds)
    assert compiling_job.task.completed
    assert compiling_job.notes == [COMPILING, ""]


def test_a_job_that_finds_its_kernels_notes_nothing(compiling_job: CompilingJob) -> None:
    compiling_job.kernel(1)
    compiling_job.waits = False
    execute(compiling_job.task, compiling_job.kinds)
    assert (compiling_job.task.completed, compiling_job.notes) == (True, [])


def test_a_job_without_notes_does_not_watch_the_compiler(
    api: JobApi, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    watched = []
    monkeypatch.setattr(compilation, "watch_compilation", lambda: watched.append(1))
    kind = TaskKind(name="track", lane="long", load=lambda: lambda _: None, on_failed=lambda *_: None)
    kinds = JobKinds([kind], worker="no.such.module")
    task = api.claimed("track", kinds)
    execute(task, kinds)
    assert (task.completed, watched) == (True, [])


def test_jobs_that_wait_for_a_preparation_have_the_note_meanwhile(compiling_job: CompilingJob, api: JobApi) -> None:
    jobs, database = compiling_job.task.jobs, api.context.database
    with database.write() as session:
        jobs.submit(session, "track", compiling_job.task.job.subject)
    with note_preparation(database, jobs, "imports"):
        compiling_job.kernel(1)
    with note_preparation(database, jobs, "long"):
        compiling_job.kernel(1.5)
        assert compiling_job.noted.wait(60)
        assert compiling_job.cleared.wait(60)
    assert compiling_job.notes == [COMPILING, ""], "once for each job, and not for those of other workers"


def test_a_worker_that_stands_by_notes_what_its_preparations_compile() -> None:
    done: list[str] = []

    @contextmanager
    def noting() -> Iterator[None]:
        done.append("begins")
        yield
        done.append("ends")

    def step(name: str) -> Any:
        return lambda: done.append(name)

    kind = TaskKind(name="bake", lane="short", load=step("load"), on_failed=lambda *_: None, prepare=(step("prepare"),))
    kinds = JobKinds([kind], worker="no.such.module")
    work(lambda: False, lambda _: None, kinds, lambda: len(done) == 6, is_standby=True, noting=noting)
    assert done == ["begins", "load", "ends", "begins", "prepare", "ends"]
