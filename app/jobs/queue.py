"""The durable queue: rows in the database, claimed with a fencing token.

A claim raises the job's token; whoever holds an older one may write nothing any more. So a job may be executed twice,
after a crash, but takes effect once.
"""

from __future__ import annotations

import uuid
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.events import EventBus
from app.jobs.kinds import JobKinds
from app.jobs.lanes import Lane
from app.storage.models import Job

__all__ = ["MOST_CRASHES", "STRIDE", "Fenced", "JobQueue"]

MOST_CRASHES = 3
"""A job that kills this many processes at one place is given up."""
STRIDE = 32
"""Frames that count as getting on: the engine stores that many at once, and positions are noted now and then only."""


class Fenced(Exception):
    """The job belongs to another process by now."""


class JobQueue:
    """Operations on the queue; each runs in the caller's transaction.

    Args:
        events: where pages hear of jobs.
        kinds: what can be submitted.
    """

    def __init__(self, events: EventBus, kinds: JobKinds) -> None:
        self.events = events
        self.kinds = kinds

    def submit(
        self, session: Session, kind: str, subject: str, payload: dict[str, Any] | None = None, priority: int = 0
    ) -> Job:
        """Put work into the queue."""
        order = (session.scalar(select(func.max(Job.order))) or 0) + 1
        job = Job(
            id=uuid.uuid4().hex,
            kind=kind,
            subject=subject,
            payload=payload or {},
            priority=priority,
            order=order,
            state="queued",
            token=0,
            crashes=0,
            cancel=False,
        )
        session.add(job)
        session.flush()
        return job

    def waiting(self, session: Session, lane: Lane | None = None) -> Sequence[str]:
        """Jobs that can be claimed, the next first; those of one lane."""
        query = select(Job.id).where(Job.state == "queued").order_by(Job.priority.desc(), Job.order)
        if lane == "long":  # and what a newer version has submitted
            query = query.where(Job.kind.not_in(self.kinds.beside(lane)))
        elif lane is not None:
            query = query.where(Job.kind.in_(self.kinds.within(lane)))
        return session.scalars(query).all()

    def claim(self, session: Session, job_id: str, place: str = "") -> Job | None:
        """Take one job, for a process at a place (:func:`app.jobs.locks.place_of`); None: somebody was faster."""
        query = select(Job).where(Job.id == job_id, Job.state == "queued").with_for_update(skip_locked=True)
        job = session.scalars(query).first()
        if job is None:
            return None
        job.state, job.token, job.started = "running", job.token + 1, datetime.now(UTC)
        job.payload = {**job.payload, "place": place}
        return job

    def held(self, session: Session, job_id: str, token: int) -> Job:
        """The job, if the token is still the newest.

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
        job = self.held(session, job_id, token)
        job.state, job.error, job.finished = state, error, datetime.now(UTC)

    def release(self, session: Session, job_id: str, token: int) -> None:
        """Give a claimed job back unharmed, as a server does that shuts down."""
        job = self.held(session, job_id, token)
        job.state = "queued"

    def cancel(self, session: Session, subject: str) -> list[Job]:
        """Ask the jobs of a subject to stop; those that have not begun are cancelled at once."""
        active = select(Job).where(Job.subject == subject, Job.state.in_(("queued", "running"))).with_for_update()
        jobs = list(session.scalars(active))
        for job in jobs:
            job.cancel = True
            if job.state == "queued":
                job.state, job.finished = "cancelled", datetime.now(UTC)
        return jobs

    def running(self, session: Session) -> list[Job]:
        """Jobs that some process holds, or died holding."""
        return list(session.scalars(select(Job).where(Job.state == "running")))

    def bury(self, session: Session, job_id: str, token: int) -> Job | None:
        """A process died with this job: queue it again, or give it up when it keeps dying at one place.

        Returns:
            The job if it is given up or was cancelled; None if it goes on.

        Raises:
            Fenced: it ended after all, or belongs to another process.
        """
        job = self.held(session, job_id, token)
        place = -1 if job.position is None else job.position
        furthest = job.payload.get("died_at")
        further = furthest is not None and place >= furthest + STRIDE
        job.crashes = 1 if further else job.crashes + 1
        job.payload = {**job.payload, "died_at": place if further or furthest is None else furthest}
        if job.cancel:
            job.state, job.finished = "cancelled", datetime.now(UTC)
            return job
        if job.crashes >= MOST_CRASHES:
            job.state, job.finished = "failed", datetime.now(UTC)
            kind = self.kinds.get(job.kind)
            job.error = _died(job, by_frame=kind is not None and kind.by_frame)
            return job
        job.state = "queued"
        return None


def _died(job: Job, *, by_frame: bool) -> str:
    if not by_frame:
        return (
            f"The process that makes this died {job.crashes} times. Its memory may not suffice: ask for less at once."
        )
    where = "before its first frame" if job.position is None else f"at frame {job.position}"
    return f"The engine died {job.crashes} times {where}. The file may be damaged there."
