"""The durable queue: rows in the database, claimed with a fencing token.

A claim raises the job's token; a process with an older token may no longer write. After a crash a job may run twice,
but it takes effect once.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.events import EventBus
from app.jobs.exit_causes import ExitCause
from app.jobs.kinds import JobKind, JobKinds
from app.jobs.lanes import Lane
from app.jobs.wakeup import ExpectedJob
from app.storage.models import Job
from app.storage.servers import is_local
from tsr_engine.json_shapes import JsonObject

MAX_CRASHES = 3
"""Crashes, or lacks of memory, at one position after which a job is given up."""
MAX_KILLS = 100
"""Kills from outside at one position after which a job is given up, because it may be what kills a whole container."""
PROGRESS_FRAMES = 32
"""Frames that count as progress: the engine stores that many at once, and positions are recorded only now and then."""


class Fenced(Exception):
    """The job now belongs to another process."""


def notify_nobody(_expected: ExpectedJob | None = None) -> None:
    """Notify nobody: there is no standby worker, and other workers poll."""


class JobQueue:
    """Operations on the queue; each runs in the caller's transaction.

    Attributes:
        notify_standby: notifies the standby worker of a committed job, or of one that a person may request soon.
    """

    def __init__(self, events: EventBus, kinds: JobKinds[JobKind]) -> None:
        self.events = events
        self.kinds = kinds
        self.notify_standby: Callable[[ExpectedJob | None], None] = notify_nobody

    def submit(
        self,
        session: Session,
        kind: str,
        subject: str,
        payload: JsonObject | None = None,
        priority: int = 0,
        place: str | None = None,
    ) -> Job:
        """Put a job into the queue.

        Args:
            session: writes.
            kind: see :mod:`app.job_kinds`.
            subject: id of the object that it works on.
            payload: further data for the task.
            priority: higher goes first.
            place: the server with the files; unset: this one.
        """
        order = (session.scalar(select(func.max(Job.order))) or 0) + 1
        job = Job(
            id=uuid.uuid4().hex,
            kind=kind,
            subject=subject,
            payload=payload or {},
            priority=priority,
            order=order,
        )
        if place is not None:
            job.place = place
        session.add(job)
        session.flush()
        return job

    def waiting_ids(self, session: Session, lane: Lane | None = None) -> Sequence[str]:
        """Ids of jobs that can be claimed here, the next one first; of one lane or all."""
        is_waiting = Job.state == "queued", is_local(session, Job.place)
        query = select(Job.id).where(*is_waiting).order_by(Job.priority.desc(), Job.order)
        if lane == "long":  # includes kinds of newer versions
            query = query.where(Job.kind.not_in(self.kinds.outside_lane(lane)))
        elif lane is not None:
            query = query.where(Job.kind.in_(self.kinds.in_lane(lane)))
        return session.scalars(query).all()

    def move(self, session: Session, subject: str, before: str | None) -> bool:
        """Move a waiting job right before another one of its kind and server, or after all of them.

        Args:
            session: writes.
            subject: subject of the job to move.
            before: subject of the other job; None: the end of the line.

        Returns:
            Whether both wait in one line.
        """
        is_waiting = Job.state == "queued", Job.subject == subject
        moved = session.scalars(select(Job).where(*is_waiting).with_for_update()).first()
        if moved is None:
            return False
        in_line = Job.state == "queued", Job.kind == moved.kind, Job.place == moved.place
        query = select(Job).where(*in_line).order_by(Job.priority.desc(), Job.order).with_for_update()
        jobs = list(session.scalars(query))
        positions = [(job.priority, job.order) for job in jobs]
        jobs.remove(moved)
        subjects = [job.subject for job in jobs]
        if before is not None and before not in subjects:
            return False
        jobs.insert(len(jobs) if before is None else subjects.index(before), moved)
        for job, (priority, order) in zip(jobs, positions, strict=True):
            job.priority, job.order = priority, order
        return True

    def claim(self, session: Session, job_id: str, place: str = "") -> Job | None:
        """Claim a job for a process at a :func:`app.storage.identity.lock_place`; None: it was claimed before."""
        is_free = Job.id == job_id, Job.state == "queued", is_local(session, Job.place)
        query = select(Job).where(*is_free).with_for_update(skip_locked=True)
        job = session.scalars(query).first()
        if job is None:
            return None
        job.state, job.token, job.started = "running", job.token + 1, datetime.now(UTC)
        job.payload = {**job.payload, "place": place}
        return job

    def require_claim(self, session: Session, job_id: str, token: int) -> Job:
        """Return the job if the token is still the newest.

        Raises:
            Fenced: it is not.
        """
        job = session.scalars(select(Job).where(Job.id == job_id).with_for_update()).first()
        if job is None or job.token != token or job.state != "running":
            raise Fenced(job_id)
        return job

    def finish(self, session: Session, job_id: str, token: int, state: str, error: str | None = None) -> None:
        """End a claimed job.

        Raises:
            Fenced: it belongs to another process.
        """
        job = self.require_claim(session, job_id, token)
        job.state, job.error, job.finished = state, error, datetime.now(UTC)

    def note(self, session: Session, job: Job, note: str) -> None:
        """Tell people what a worker does for a job besides its progress, if its kind has notes.

        Args:
            session: writes.
            job: waits or runs.
            note: a few words for a progress line; empty: nothing to say.
        """
        kind = self.kinds.get(job.kind)
        if kind is not None and kind.on_note is not None:
            kind.on_note(session, self.events, job, note)

    def release(self, session: Session, job_id: str, token: int) -> None:
        """Give a claimed job back without counting a crash, as when the server shuts down."""
        job = self.require_claim(session, job_id, token)
        job.state = "queued"

    def cancel(self, session: Session, subject: str) -> list[Job]:
        """Cancel the jobs of a subject: running ones are asked to stop, waiting ones end at once."""
        active = select(Job).where(Job.subject == subject, Job.state.in_(("queued", "running"))).with_for_update()
        jobs = list(session.scalars(active))
        for job in jobs:
            job.cancel = True
            if job.state == "queued":
                job.state, job.finished = "cancelled", datetime.now(UTC)
        return jobs

    def running_jobs(self, session: Session) -> list[Job]:
        """Jobs that a process holds, or died with."""
        return list(session.scalars(select(Job).where(Job.state == "running")))

    def requeue_dead(self, session: Session, job_id: str, token: int, cause: ExitCause = "crashed") -> Job | None:
        """Queue the job of a dead process again, or give it up if it keeps dying at one position.

        Args:
            session: writes.
            job_id: the job.
            token: token of the dead process.
            cause: only crashes count against the file; other causes are counted separately.

        Returns:
            The job if it is given up or was cancelled; None if it is queued again.

        Raises:
            Fenced: it ended after all, or belongs to another process.
        """
        job = self.require_claim(session, job_id, token)
        position = -1 if job.position is None else job.position
        furthest = job.payload.get("died_at")
        has_progressed = furthest is not None and position >= furthest + PROGRESS_FRAMES
        other_exits = {} if has_progressed else dict(job.payload.get("ends", {}))
        job.crashes = (0 if has_progressed else job.crashes) + (cause == "crashed")
        if cause != "crashed":
            other_exits[cause] = other_exits.get(cause, 0) + 1
        furthest = position if has_progressed or furthest is None else furthest
        job.payload = {**job.payload, "died_at": furthest, "ends": other_exits}
        if job.cancel:
            job.state, job.finished = "cancelled", datetime.now(UTC)
            return job
        kind = self.kinds.get(job.kind)
        error = _reason_to_give_up(job, other_exits, by_frame=kind is not None and kind.by_frame)
        if error is not None:
            job.state, job.finished, job.error = "failed", datetime.now(UTC), error
            return job
        job.state = "queued"
        return None


def _reason_to_give_up(job: Job, other_exits: Mapping[str, int], *, by_frame: bool) -> str | None:
    """The reason to give the job up; None: try it again."""
    where = _describe_position(job.position, by_frame)
    starved, killed = other_exits.get("starved", 0), other_exits.get("killed", 0)
    if job.crashes >= MAX_CRASHES and by_frame:
        return f"The engine died {job.crashes} times {where}. The file may be damaged there."
    if job.crashes >= MAX_CRASHES:
        return (
            f"The process for this died {job.crashes} times {where}. It may need more memory than it has: request less "
            "at once."
        )
    if starved >= MAX_CRASHES:
        return (
            f"The machine had no memory left {starved} times {where}. Close other programs, have fewer workers "
            "(TSR_WORKERS), or request less at once."
        )
    if killed >= MAX_KILLS:
        return (
            f"The process was ended from outside {killed} times {where}. Find out what ends it, then start this again."
        )
    return None


def _describe_position(position: int | None, by_frame: bool) -> str:
    if by_frame:
        return "before its first frame" if position is None else f"at frame {position}"
    return "at its beginning" if position is None else f"at step {position}"
