"""Supervises the workers: starts them for waiting jobs, cleans up after dead ones, ends them with the server."""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from app.jobs.exit_causes import ExitCause, count_oom_kills, exit_cause
from app.jobs.lanes import LANES, MAX_WORKERS, STANDBY, Lane
from app.jobs.locks import holder_pid, is_alive, last_holder_pid
from app.jobs.outcome import clear_subject, notify_subject, requeue
from app.jobs.queue import Fenced, JobQueue, notify_nobody
from app.jobs.wakeup import WakeupSender
from app.log_once import LogOnce
from app.settings import Settings
from app.storage.database import Database
from app.storage.identity import lock_place
from app.storage.models import Job

_TURN_S = 0.25
_CANCEL_SECONDS = 4.0
"""Seconds that a cancelled worker gets until it is asked to leave, and again until it is killed."""
_STOP_SECONDS = 0.6
"""Seconds that workers get when the server ends, so that Ctrl-C takes at most two."""
_EXIT_SECONDS = 0.5
"""Seconds that the kernel may take to end a process whose lock is already free."""
_MAX_CAUSES = 256
"""Number of dead workers whose cause of death is remembered."""
_DESCRIPTIONS: dict[ExitCause, str] = {
    "crashed": "crashed",
    "starved": "ran out of memory",
    "killed": "was ended from outside",
}
_log = logging.getLogger("tsr.supervisor")


class Supervisor:
    """A thread of the server that watches the workers.

    For jobs of this machine and data folder (on SQLite all are) the lock file shows whether the worker is alive. On
    PostgreSQL other machines may hold jobs: these are dead if their heartbeat did not change for a minute by our own
    steady clock. Its value does not matter, because clocks of machines differ.

    While a page is open, one worker of the short lane stands by: starting a process and loading the engine takes two to
    four seconds, longer than most short jobs.

    Attributes:
        heartbeat_timeout: seconds without a heartbeat after which a worker of another machine counts as dead.
        linger: seconds that the standby worker outlives the last open page, because a page may be reloaded.
        restart_delay: seconds before a standby worker that has died is replaced.
    """

    heartbeat_timeout = 60.0
    linger = 60.0
    restart_delay = 10.0

    def __init__(
        self,
        settings: Settings,
        database: Database,
        jobs: JobQueue,
        is_page_open: Callable[[], bool] = lambda: False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._settings = settings
        self._database = database
        self._jobs = jobs
        self._lanes: dict[Lane, list[subprocess.Popen[bytes]]] = {lane: [] for lane in LANES}
        self._is_page_open = is_page_open
        self._clock = clock
        self._page_seen_at = self._standby_started_at = -self.linger
        self._standby: subprocess.Popen[bytes] | None = None
        self._wakeup = WakeupSender()
        self._stop = threading.Event()
        self._cancelled_since: dict[str, float] = {}
        self._heartbeats: dict[str, tuple[object, float]] = {}
        self._causes: dict[int, ExitCause] = {}
        """Causes of death of this server's workers, by process id."""
        self._memory_kills = count_oom_kills()
        self._place = lock_place(settings.home)
        self._queue = database.polled(self._read_queue)
        self._log_once = LogOnce(_log, "The workers cannot be supervised")
        self._thread = threading.Thread(target=self.watch, args=(self._stop.wait,), name="supervisor", daemon=True)

    @property
    def _workers(self) -> list[subprocess.Popen[bytes]]:
        """The processes of all lanes."""
        return [worker for lane in LANES for worker in self._lanes[lane]]

    @property
    def standby_pid(self) -> int | None:
        """Process id of the standby worker; None: there is none."""
        standby = self._standby
        return None if standby is None else standby.pid

    def start(self) -> None:
        """Start the thread."""
        self._jobs.notify_standby = self._wakeup.send
        self._thread.start()

    def stop(self) -> None:
        """Ask the workers to end, then kill them; the next server continues their jobs."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()
        for worker in self._workers:
            worker.terminate()
        deadline = time.monotonic() + _STOP_SECONDS
        for worker in self._workers:
            try:
                worker.wait(max(0.05, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                self._kill_and_requeue(worker)
        self._jobs.notify_standby = notify_nobody
        self._wakeup.close()

    def _kill_and_requeue(self, worker: subprocess.Popen[bytes]) -> None:
        """Kill a worker that is too slow and queue its job again; a kill by the server does not count as a crash."""
        try:
            with self._database.read() as session:
                running = self._jobs.running_jobs(session)
            held_jobs = [job for job in running if holder_pid(self._settings.home, job.id) == worker.pid]
        except SQLAlchemyError:
            held_jobs = []  # the next server finds the job and its dead worker
        worker.kill()
        worker.wait()
        for job in held_jobs:
            try:
                with self._database.write() as session:
                    requeue(session, self._jobs, job)
            except (Fenced, SQLAlchemyError):
                _log.warning("Job %s was not queued again; the next server finds it.", job.id)

    def watch(self, wait: Callable[[float], bool]) -> None:
        """Take turns until the end.

        Args:
            wait: waits for so many seconds; returns True at the end.
        """
        while not wait(_TURN_S):
            try:
                self.check_workers()
            except (SQLAlchemyError, OSError) as error:
                self._log_once.failed(error)
                self._heartbeats.clear()  # workers that could not write a heartbeat meanwhile get another minute
                wait(2.0)
            else:
                self._log_once.recovered()

    def check_workers(self) -> None:
        """Clean up after dead workers, stop cancelled ones, and start missing ones."""
        self._reap()
        running, waiting = self._queue()
        for job in running:
            if self.is_dead(job):
                self.requeue_dead(job, self.cause_of_death(job))
            elif job.cancel:
                self._enforce_cancel(job)
        kinds = self._jobs.kinds
        for lane in LANES:
            workers = self._lanes[lane]
            busy = sum(kinds.lane_of(job.kind) == lane and is_alive(self._settings.home, job.id) for job in running)
            max_workers = self._settings.workers if lane == "long" else MAX_WORKERS
            if waiting[lane] > max(0, len(workers) - busy) and len(workers) < max_workers:
                workers.append(self.spawn(lane))
        self._update_standby(running)

    def _read_queue(self, session: Session) -> tuple[Sequence[Job], Mapping[Lane, int]]:
        """Jobs that a process holds, or died with, and the number of waiting ones by lane."""
        return self._jobs.running_jobs(session), {lane: len(self._jobs.waiting_ids(session, lane)) for lane in LANES}

    def _update_standby(self, running: Sequence[Job]) -> None:
        """Keep one short worker while a page is open, and end it when no page has come back."""
        now, workers, is_page_open = self._clock(), self._lanes["short"], self._is_page_open()
        if is_page_open:
            self._page_seen_at = now
        if self._standby is not None and self._standby not in workers:
            self._standby = None
        if self._standby is None:
            if is_page_open and now - self._standby_started_at > self.restart_delay:
                self._standby, self._standby_started_at = self.spawn("short", STANDBY, stdin=self._wakeup.receiver), now
                workers.append(self._standby)
        elif now - self._page_seen_at > self.linger and not any(
            holder_pid(self._settings.home, job.id) == self._standby.pid for job in running
        ):
            self._standby.terminate()
            self._standby = None

    def is_dead(self, job: Job) -> bool:
        """Whether the process of a running job is dead."""
        if is_alive(self._settings.home, job.id):
            return False
        if self._database.is_sqlite or (self._place is not None and job.payload.get("place") == self._place):
            return True
        state = job.token, job.position, job.heartbeat
        last_state, since = self._heartbeats.get(job.id, (None, self._clock()))
        if last_state != state:
            since = self._clock()
        self._heartbeats[job.id] = state, since
        return self._clock() - since > self.heartbeat_timeout

    def _reap(self) -> None:
        """Drop the workers that have ended, and remember their causes of death."""
        kills, kills_before = count_oom_kills(), self._memory_kills
        self._memory_kills = kills
        for lane, workers in self._lanes.items():
            on_cluster = lane == "long" and self._settings.executor != "local"
            still_running = []
            for worker in workers:
                code = worker.poll()
                if code is None:
                    still_running.append(worker)
                else:
                    self._causes[worker.pid] = exit_cause(code, kills > kills_before, on_cluster)
            self._lanes[lane] = still_running
        while len(self._causes) > _MAX_CAUSES:
            del self._causes[next(iter(self._causes))]

    def cause_of_death(self, job: Job) -> ExitCause:
        """Cause of death of a dead job's last worker; a worker of another server died with that server."""
        pid = last_holder_pid(self._settings.home, job.id)
        for worker in self._workers:
            # the lock is free just before the process ends, or the process lives on without the job
            if worker.pid == pid:
                with suppress(subprocess.TimeoutExpired):
                    worker.wait(_EXIT_SECONDS)
                self._reap()
                break
        return "killed" if pid is None else self._causes.get(pid, "killed")

    def requeue_dead(self, job: Job, cause: ExitCause) -> None:
        """Queue the job of a dead worker again, or end the job if that happened too often."""
        with self._database.write() as session:
            try:
                ended = self._jobs.requeue_dead(session, job.id, job.token, cause)
            except Fenced:
                return  # the job ended between the checks of the queue and of its lock
            if ended is not None:
                notify_subject(session, self._jobs, ended, ended.state, ended.error)
            else:
                notify_subject(session, self._jobs, job, "queued", None)
        if ended is not None:
            clear_subject(self._settings.home, self._jobs, job)
            return
        _log.warning("A worker %s in job %s; the job is tried again.", _DESCRIPTIONS[cause], job.id)

    def _enforce_cancel(self, job: Job) -> None:
        """End a cancelled job that does not stop by itself, at last by force."""
        waited = time.monotonic() - self._cancelled_since.setdefault(job.id, time.monotonic())
        pid = holder_pid(self._settings.home, job.id)
        if waited > _CANCEL_SECONDS and pid in {worker.pid for worker in self._workers}:
            assert pid is not None
            os.kill(pid, signal.SIGKILL if waited > 2 * _CANCEL_SECONDS else signal.SIGTERM)

    def spawn(self, lane: Lane, *extra: str, stdin: int = subprocess.DEVNULL) -> subprocess.Popen[bytes]:
        """Start a worker of a lane; for ``extra`` arguments and ``stdin`` see :mod:`app.jobs.worker`."""
        variables = {f"TSR_{name.upper()}": value for name, value in as_environment(self._settings).items()}
        threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        command = [sys.executable, "-m", self._jobs.kinds.worker, str(os.getpid()), lane, *extra]
        environment = {**os.environ, **threads, **variables}
        return subprocess.Popen(command, env=environment, stdin=stdin)


def as_environment(settings: Settings) -> dict[str, str]:
    """Convert settings to the environment variables that give the same settings."""
    values: dict[str, str] = {}
    for name, value in settings:
        if value is None:
            continue
        # JSON, because a folder's name may contain any separator
        values[name] = json.dumps([str(part) for part in value]) if isinstance(value, tuple) else str(value)
    return values
