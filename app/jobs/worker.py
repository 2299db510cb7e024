"""A process that takes jobs from the queue until none are left. Its arguments are ``PARENT LANE [stay]``.

It ends with its server, has a limit on memory, works at low priority, and can start no other program: a broken or
malicious video costs only this process. With ``stay`` it waits for further jobs until it is asked to leave, and loads
their modules meanwhile.
"""

from __future__ import annotations

import logging
import os
import resource
import signal
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial

from sqlalchemy.exc import DBAPIError

from app.errors import Busy, StorageFull
from app.events import EventBus
from app.jobs.compilation_notes import note_compilation, note_preparation
from app.jobs.context import Stopped, TaskContext
from app.jobs.exit_causes import TERMINATED
from app.jobs.heartbeat import heartbeat
from app.jobs.kinds import JobKinds
from app.jobs.lanes import LANES, STANDBY, Lane
from app.jobs.locks import JobLock, note_unstored_end
from app.jobs.outcome import end_stopped_task, report_failure
from app.jobs.queue import Fenced, JobQueue
from app.jobs.tasks import TaskKind, preparations
from app.jobs.wakeup import ExpectedJob, WakeupListener
from app.log_once import LogOnce
from app.sandbox.confine import die_with_parent, restrict_process
from app.sandbox.limits import writable_folders
from app.settings import Settings, load_settings
from app.storage.database import Database, sqlite_file, storage_failure
from app.storage.identity import lock_place, open_database
from tsr_engine.errors import InputError, TsrError
from tsr_engine.extras import explained
from tsr_engine.io.storage_problems import TOO_LARGE_MESSAGE, storage_problem

IDLE_TIMEOUT_S = 30.0
"""Idle seconds after which the process ends."""
GRACE_S = 6.0
"""Seconds that a worker has to finish when it is asked to end."""
_POLL_S = 0.1
"""Seconds between queries of the queue."""
_STANDBY_POLL_S = 0.03
"""Seconds between queries of a standby worker, because a person with an open page may request a job."""
RETRY_DELAY_S = 1.0
"""Seconds between attempts while the data folder or the database cannot be written."""
_FULL = "The disk is full. Free some space, then try again."
_log = logging.getLogger("tsr.worker")


class _Termination:
    """Set by SIGTERM: finish the current write, then end.

    The signal also comes when the server dies. A decoder that hangs must not outlive the server, so a separate thread
    waits for the signal and ends the process after ``grace`` seconds; that is as safe as a kill.
    """

    def __init__(self, grace: float = GRACE_S) -> None:
        self.requested = False
        receiver, sender = os.pipe()
        os.set_blocking(sender, False)
        signal.set_wakeup_fd(sender, warn_on_full_buffer=False)
        threading.Thread(target=self._exit_after_grace, args=(receiver, grace), name="leaving", daemon=True).start()
        signal.signal(signal.SIGTERM, self._on_signal)
        # Ctrl-C reaches the whole process group; the server then asks this process to end
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    @staticmethod
    def _exit_after_grace(receiver: int, grace: float) -> None:
        while signal.SIGTERM not in os.read(receiver, 64):
            pass
        time.sleep(grace)
        os._exit(TERMINATED)

    def _on_signal(self, *_: object) -> None:
        self.requested = True

    def __call__(self) -> bool:
        return self.requested


def main(kinds: JobKinds[TaskKind], arguments: Sequence[str]) -> int:
    """Work until idle or asked to leave; returns exit code 0 then.

    Args:
        kinds: the kinds of jobs.
        arguments: id of the parent process, lane, and ``stay`` to wait for jobs.
    """
    parent, lane = int(arguments[0]), LANES[LANES.index(arguments[1])]  # type: ignore[arg-type]
    is_standby = STANDBY in arguments[2:]
    logging.basicConfig(level=logging.INFO, format="%(name)s: %(message)s")
    settings = load_settings()
    _restrict_process(settings, lane)  # before any thread starts
    leaving = _Termination()
    if not die_with_parent(parent, signal.SIGTERM):
        return 0
    limit = settings.worker_memory_mb * 2**20
    hard_limit = limit if settings.executor == "local" else resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard_limit))
    os.nice(10)
    database = open_database(settings)
    jobs = JobQueue(EventBus(), kinds)

    def expect(expected: ExpectedJob) -> None:
        kind = kinds.get(expected[0])
        if kind is not None and kind.expect is not None:
            kind.expect(settings, database, expected[1])

    waiting_ids = database.polled(lambda session: jobs.waiting_ids(session, lane))
    noting = partial(note_preparation, database, jobs, lane)
    one_job = partial(do_next, settings, database, kinds, jobs, leaving, waiting_ids)
    work(one_job, expect, kinds, leaving, is_standby, noting)
    database.close()
    return 0


def _restrict_process(settings: Settings, lane: Lane) -> None:
    """Give up rights that a worker does not need, because it decodes files from outside.

    With SQLite, only two kinds of work open connections: scenes, which a server in the same process makes, and runs on
    a cluster. A worker for imports decodes a video for the first time and writes only in the data folder. Other workers
    may compile code, whose caches lie elsewhere.
    """
    database = sqlite_file(settings.database)
    writable = writable_folders(settings.home, database) if database is not None and lane == "imports" else None
    restrict_process(writable, network=database is None or lane == "scenes" or settings.executor != "local")


def work(
    one_job: Callable[[], bool],
    expect: Callable[[ExpectedJob], None],
    kinds: JobKinds[TaskKind],
    leaving: Callable[[], bool],
    is_standby: bool,
    noting: Callable[[], AbstractContextManager[None]] = nullcontext,
) -> None:
    """Do jobs one after the other until there are none for a while, or until asked to leave.

    Args:
        one_job: does the next job; False: there is none.
        expect: prepares for a job that a person may request soon.
        kinds: the kinds of jobs.
        leaving: whether to leave.
        is_standby: whether to wait for jobs and prepare for them, instead of ending when idle.
        noting: makes a block in which jobs that wait for a preparation get notes.
    """
    idle_since = time.monotonic()
    listener = WakeupListener()
    steps = preparations(kinds) if is_standby else iter(())
    log_once = LogOnce(_log, "Jobs cannot be taken from the queue")
    while not leaving() and (is_standby or time.monotonic() - idle_since < IDLE_TIMEOUT_S):
        try:
            did_job = one_job()
        except (OSError, DBAPIError) as error:
            # an ended worker would be restarted at once, so wait here for free space
            log_once.failed(error)
            idle_since = time.monotonic()
            time.sleep(RETRY_DELAY_S)
            continue
        log_once.recovered()
        if did_job:
            idle_since = time.monotonic()
        elif (step := next(steps, None)) is not None:
            with noting():
                steps = steps if run_preparation(step) else iter(())
        elif not is_standby:
            time.sleep(_POLL_S)
        elif (expected := listener.wait(_STANDBY_POLL_S)) is not None:
            run_preparation(partial(expect, expected))


def run_preparation(step: Callable[[], object]) -> bool:
    """Do one preparation and return whether it succeeded. A failure is only logged; a job that needs it reports it."""
    try:
        step()
    except Exception:
        _log.exception("A worker could not prepare everything in advance; it continues without.")
        return False
    return True


def do_next(
    settings: Settings,
    database: Database,
    kinds: JobKinds[TaskKind],
    jobs: JobQueue,
    leaving: Callable[[], bool],
    waiting_ids: Callable[[], Sequence[str]],
) -> bool:
    """Do the next job; False: there was none.

    Args:
        settings: of the server.
        database: with the queue.
        kinds: the kinds of jobs.
        jobs: the queue.
        leaving: whether the process is asked to end.
        waiting_ids: returns the ids of the jobs that can be claimed, the next one first.
    """
    for job_id in waiting_ids():
        lock = JobLock(settings.home, job_id)
        if not lock.acquire():
            continue
        try:
            # need not survive a loss of power, which ends this process too
            with database.write(durable=False) as session:
                job = jobs.claim(session, job_id, lock_place(settings.home) or "")
            if job is not None:
                with heartbeat(database, job):
                    execute(TaskContext(settings, database, jobs.events, jobs, job, leaving), kinds)
                return True
        finally:
            lock.release()
    return False


def perform(task: TaskContext, kinds: JobKinds[TaskKind]) -> None:
    """Do a claimed job up to its end as done.

    Raises:
        InputError: no such kind of job.
        Stopped, Fenced, TsrError, ...: it has another end; see :func:`execute`.
    """
    kind = kinds.get(task.job.kind)
    if kind is None:
        raise InputError(f'This server cannot do jobs of the kind "{task.job.kind}". Update tsr, then start it again.')
    function = kind.load()
    with note_compilation(task):
        function(task)
    if not task.completed:
        with task.complete():
            pass  # the task had nothing to store at its end


def execute(task: TaskContext, kinds: JobKinds[TaskKind]) -> None:
    """Do a claimed job, and store its end."""
    job = task.job
    try:
        with explained():
            perform(task, kinds)
    except Fenced:
        _log.warning("Job %s now belongs to another process.", job.id)
    except Stopped:
        _retry_until_stored(task, end_stopped_task)
    except TsrError as error:
        _report_failure(task, str(error))
    except MemoryError:
        _report_failure(task, f"The file needs more than {task.settings.worker_memory_mb} MiB of memory.")
    except DBAPIError as error:
        _log.warning("The database failed in job %s: %s.", job.id, error.orig)
        failure = storage_failure(error)
        if isinstance(failure, Busy):
            _retry_until_stored(task, end_stopped_task)  # the database was unavailable: the job itself is unharmed
            return
        is_full = failure is not None and failure.code == StorageFull.default_code
        _report_failure(task, _FULL if is_full else f"The database could not be written: {error.orig}.")
    except Exception as error:
        kind = storage_problem(error)
        if kind != "failed":
            _report_failure(task, _FULL if kind == "full" else f"A file could not be written: {TOO_LARGE_MESSAGE}.")
            return
        _log.exception("Job %s failed.", job.id)
        name = type(error).__name__
        _report_failure(task, f"Something unexpected went wrong ({name}). The server's log has the details.")


def _report_failure(task: TaskContext, message: str) -> None:
    _retry_until_stored(task, lambda task: report_failure(task, message))


def _retry_until_stored(task: TaskContext, store: Callable[[TaskContext], None]) -> None:
    """Store the end of a job as soon as possible: a full disk or an unavailable database is no crash of the job."""
    log_once = LogOnce(_log, f"The end of job {task.job.id} cannot be stored")
    while True:
        try:
            store(task)
        except DBAPIError as error:
            log_once.failed(error)
            failure = storage_failure(error)
            is_full = failure is not None and failure.code == StorageFull.default_code
            note_unstored_end(task.settings.home, task.job.id, "the disk is full" if is_full else str(error.orig))
        else:
            return
        if task.leaving():
            return  # the next server finds the job and its dead worker
        time.sleep(RETRY_DELAY_S)
