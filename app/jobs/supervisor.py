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

from app.jobs.bell import Bell
from app.jobs.deaths import Cause, cause_of, memory_kills
from app.jobs.lanes import AT_ONCE, LANES, Lane
from app.jobs.locks import holder, is_alive, last_holder
from app.jobs.outcome import clear_subject, notify_subject, take_back
from app.jobs.queue import Fenced, JobQueue, silent
from app.jobs.readiness import STAY
from app.log_once import LogOnce
from app.settings import Settings
from app.storage.database import Database
from app.storage.identity import place_of
from app.storage.models import Job

__all__ = ["Supervisor", "as_environment"]

_TURN = 0.25
_CANCEL_SECONDS = 4.0
"""Seconds that a cancelled worker gets until it is asked to leave, and again until it is killed."""
_STOP_SECONDS = 0.6
"""Seconds that workers get when the server ends, so that Ctrl-C takes at most two."""
_EXIT_SECONDS = 0.5
"""Seconds that the kernel may take to end a process whose lock is already free."""
_REMEMBERED = 256
"""Number of dead workers whose cause of death is remembered."""
_WORDS: dict[Cause, str] = {"crashed": "crashed", "starved": "ran out of memory", "killed": "was ended from outside"}
_log = logging.getLogger("tsr.supervisor")


class Supervisor:
    """A thread of the server that watches the workers.

    For jobs of this machine and data folder (on SQLite all are) the lock file shows whether the worker is alive. On
    PostgreSQL other machines may hold jobs: these are dead if their heartbeat did not change for a minute by our own
    steady clock. Its value does not matter, because clocks of machines differ.

    While a page is open, one worker of the short lane stands by: starting a process and loading the engine takes two to
    four seconds, longer than most short jobs.

    Attributes:
        silence: seconds without a heartbeat after which a worker of another machine counts as dead.
        linger: seconds that the standby worker outlives the last open page, because a page may be reloaded.
        again: seconds before a standby worker that has died is replaced.
    """

    silence = 60.0
    linger = 60.0
    again = 10.0

    def __init__(
        self,
        settings: Settings,
        database: Database,
        jobs: JobQueue,
        watched: Callable[[], bool] = lambda: False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare the thread.

        Args:
            settings: of the server.
            database: with the queue.
            jobs: the queue.
            watched: returns whether a page is open.
            clock: monotonic, seconds.
        """
        self._settings = settings
        self._database = database
        self._jobs = jobs
        self._lanes: dict[Lane, list[subprocess.Popen[bytes]]] = {lane: [] for lane in LANES}
        self._watched = watched
        self._clock = clock
        self._watched_at = self._stood_at = -self.linger
        self._standing: subprocess.Popen[bytes] | None = None
        self._bell = Bell()
        self._stop = threading.Event()
        self._overdue: dict[str, float] = {}
        self._beats: dict[str, tuple[object, float]] = {}
        self._causes: dict[int, Cause] = {}
        """Causes of death of our workers, by process id."""
        self._memory_kills = memory_kills()
        self._place = place_of(settings.home)
        self._queue = database.polled(self._read_queue)
        self._log_once = LogOnce(_log, "The workers cannot be supervised")
        self._thread = threading.Thread(target=self.watch, args=(self._stop.wait,), name="supervisor", daemon=True)

    @property
    def _workers(self) -> list[subprocess.Popen[bytes]]:
        """The processes of all lanes."""
        return [worker for lane in LANES for worker in self._lanes[lane]]

    @property
    def standing(self) -> int | None:
        """Process id of the standby worker; None: there is none."""
        standing = self._standing
        return None if standing is None else standing.pid

    def start(self) -> None:
        """Start the thread."""
        self._jobs.ring = self._bell.ring
        self._thread.start()

    def stop(self) -> None:
        """Ask the workers to end, then kill them; the next server continues their jobs."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()
        for worker in self._workers:
            worker.terminate()
        until = time.monotonic() + _STOP_SECONDS
        for worker in self._workers:
            try:
                worker.wait(max(0.05, until - time.monotonic()))
            except subprocess.TimeoutExpired:
                self._end(worker)
        self._jobs.ring = silent
        self._bell.close()

    def _end(self, worker: subprocess.Popen[bytes]) -> None:
        """Kill a worker that is too slow and queue its job again; this kill is ours and does not count as a crash."""
        try:
            with self._database.read() as session:
                held = [job for job in self._jobs.running(session) if holder(self._settings.home, job.id) == worker.pid]
        except SQLAlchemyError:
            held = []  # the next server finds the job and its dead worker
        worker.kill()
        worker.wait()
        for job in held:
            try:
                with self._database.write() as session:
                    take_back(session, self._jobs, job)
            except (Fenced, SQLAlchemyError):
                _log.warning("Job %s was not taken back; the next server finds it.", job.id)

    def watch(self, wait: Callable[[float], bool]) -> None:
        """Take turns until the end.

        Args:
            wait: waits for so many seconds; returns True at the end.
        """
        while not wait(_TURN):
            try:
                self.turn()
            except (SQLAlchemyError, OSError) as error:
                self._log_once.failed(error)
                self._beats.clear()  # workers that could not write a heartbeat meanwhile get another minute
                wait(2.0)
            else:
                self._log_once.recovered()

    def turn(self) -> None:
        """Clean up after dead workers, stop cancelled ones, and start missing ones."""
        self._reap()
        running, waiting = self._queue()
        for job in running:
            if self.is_dead(job):
                self.bury(job, self.cause_of_death(job))
            elif job.cancel:
                self._press(job)
        kinds = self._jobs.kinds
        for lane in LANES:
            workers = self._lanes[lane]
            busy = sum(kinds.lane(job.kind) == lane and is_alive(self._settings.home, job.id) for job in running)
            most = self._settings.workers if lane == "long" else AT_ONCE
            if waiting[lane] > max(0, len(workers) - busy) and len(workers) < most:
                workers.append(self.spawn(lane))
        self._stand_by(running)

    def _read_queue(self, session: Session) -> tuple[Sequence[Job], Mapping[Lane, int]]:
        """Jobs that a process holds, or died with, and the number of waiting ones by lane."""
        return self._jobs.running(session), {lane: len(self._jobs.waiting(session, lane)) for lane in LANES}

    def _stand_by(self, running: Sequence[Job]) -> None:
        """Keep one short worker while a page is open, and end it when no page has come back."""
        now, workers, watched = self._clock(), self._lanes["short"], self._watched()
        if watched:
            self._watched_at = now
        if self._standing is not None and self._standing not in workers:
            self._standing = None
        if self._standing is None:
            if watched and now - self._stood_at > self.again:
                self._standing, self._stood_at = self.spawn("short", STAY, stdin=self._bell.heard), now
                workers.append(self._standing)
        elif now - self._watched_at > self.linger and not any(
            holder(self._settings.home, job.id) == self._standing.pid for job in running
        ):
            self._standing.terminate()
            self._standing = None

    def is_dead(self, job: Job) -> bool:
        """Whether the process of a running job is dead."""
        if is_alive(self._settings.home, job.id):
            return False
        if self._database.is_sqlite or (self._place is not None and job.payload.get("place") == self._place):
            return True
        sign = job.token, job.position, job.heartbeat
        beat, since = self._beats.get(job.id, (None, self._clock()))
        if beat != sign:
            since = self._clock()
        self._beats[job.id] = sign, since
        return self._clock() - since > self.silence

    def _reap(self) -> None:
        """Drop the workers that have ended, and remember their causes of death."""
        kills, before = memory_kills(), self._memory_kills
        self._memory_kills = kills
        for lane, workers in self._lanes.items():
            on_cluster = lane == "long" and self._settings.executor != "local"
            living = []
            for worker in workers:
                code = worker.poll()
                if code is None:
                    living.append(worker)
                else:
                    self._causes[worker.pid] = cause_of(code, kills > before, on_cluster)
            self._lanes[lane] = living
        while len(self._causes) > _REMEMBERED:
            del self._causes[next(iter(self._causes))]

    def cause_of_death(self, job: Job) -> Cause:
        """Cause of death of a dead job's last worker; a worker that is not ours died with its server, or elsewhere."""
        process = last_holder(self._settings.home, job.id)
        for worker in self._workers:
            # the lock is free just before the process ends, or the process lives on without the job
            if worker.pid == process:
                with suppress(subprocess.TimeoutExpired):
                    worker.wait(_EXIT_SECONDS)
                self._reap()
                break
        return "killed" if process is None else self._causes.get(process, "killed")

    def bury(self, job: Job, cause: Cause) -> None:
        """Queue the job of a dead worker again, or end the job if that happened too often."""
        with self._database.write() as session:
            try:
                ended = self._jobs.bury(session, job.id, job.token, cause)
            except Fenced:
                return  # the job ended between the checks of the queue and of its lock
            if ended is not None:
                notify_subject(session, self._jobs, ended, ended.state, ended.error)
            else:
                notify_subject(session, self._jobs, job, "queued", None)
        if ended is not None:
            clear_subject(self._settings.home, self._jobs, job)
            return
        _log.warning("A worker %s in job %s; the job is tried again.", _WORDS[cause], job.id)

    def _press(self, job: Job) -> None:
        """End a cancelled job that does not stop by itself, at last by force."""
        waited = time.monotonic() - self._overdue.setdefault(job.id, time.monotonic())
        process = holder(self._settings.home, job.id)
        if waited > _CANCEL_SECONDS and process in {worker.pid for worker in self._workers}:
            assert process is not None
            os.kill(process, signal.SIGKILL if waited > 2 * _CANCEL_SECONDS else signal.SIGTERM)

    def spawn(self, lane: Lane, *further: str, stdin: int = subprocess.DEVNULL) -> subprocess.Popen[bytes]:
        """Start a worker of a lane; for ``further`` arguments and ``stdin`` see :mod:`app.jobs.worker`."""
        passed = {f"TSR_{name.upper()}": value for name, value in as_environment(self._settings).items()}
        threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        command = [sys.executable, "-m", self._jobs.kinds.worker, str(os.getpid()), lane, *further]
        environment = {**os.environ, **threads, **passed}
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
