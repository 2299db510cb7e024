"""The work of people: one person's operations, and an overview of all, from the edit log and its sums."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import cast

from sqlalchemy import ColumnElement, case, func, select, true
from sqlalchemy.orm import InstrumentedAttribute, Session

from app.body_model import Model
from app.edits.counters import day_of
from app.people.roles import Role
from app.people.service import person_named
from app.storage.database import Database
from app.storage.models import Assignment, Edit, Person, Run, SearchRun, Verdict, Video, WorkDay

DAYS = 30
"""Days that the figures of work cover, today included."""
_CLOCK_TOLERANCE_S = 60.0
"""Tolerated difference of clocks, seconds."""
_PAGE = 100


class Done(Model):
    """One operation of a person."""

    seq: int
    time: str
    name: str
    frame: int | None
    tracks: list[str]
    """Keys of its tracks; only the first few of many."""
    count: int
    """Number of its tracks."""
    run_id: str
    video_id: str
    video_name: str


class Worker(Model):
    """The work of a person in the last 30 days."""

    name: str
    role: Role | None
    """None: an author without an account, for example from before the library had people."""
    decided: int
    """Number of tracks accepted or rejected."""
    rejected: int
    """Number of tracks rejected."""
    hours: float
    """Time between operations; of a longer break five minutes."""
    assigned: int
    """Number of assignments that are not done."""
    in_review: int
    """Number of assignments that wait for a reviewer."""


class Activity(Model):
    """A person's operations, newest first."""

    worker: Worker
    done: list[Done]
    more: int | None
    """Request rows before this number for older operations; None: there are none."""


class Overview(Model):
    """The current runs of the videos in the search's tables, and the work of the last 30 days."""

    videos: int
    tracks: int
    """Number of tracks, without deleted ones and regions to ignore."""
    reviewed: int
    rejected: int
    notes: int
    unread: int
    """Number of runs whose tracks or newest edits are missing in these figures: not read yet, or unreadable."""
    decided_twice: int
    """Number of tracks with verdicts of two people."""
    agreed: int
    """Number of them with equal verdicts."""
    people: list[Worker]
    clocks: str | None
    """A sentence if times in the log are wrong."""


class ActivityService:
    """Reads the log."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def of(self, name: str, before: int | None = None) -> Activity:
        """Return the operations of a person.

        Args:
            name: name of the person.
            before: rows of the log before this number; None: from the newest on.

        Raises:
            NotFound: no such person.
        """
        with self._database.read() as session:
            person = person_named(session, name)
            query = (
                select(Edit, Run.video_id, Video.name)
                .join(Run, Run.id == Edit.run_id)
                .join(Video, Video.id == Run.video_id)
                .where(Edit.author == person.name)
                .order_by(Edit.seq.desc())
                .limit(_PAGE + 1)
            )
            rows = session.execute(query if before is None else query.where(Edit.seq < before)).all()
            done = [_done(*row) for row in rows[:_PAGE]]
            (worker,) = _workers(session, [person], person.name)
            return Activity(worker=worker, done=done, more=done[-1].seq if len(rows) > _PAGE else None)

    def overview(self, unread: int) -> Overview:
        """Return the progress of the library and of its people.

        Args:
            unread: number of runs that are not in the search's tables yet.
        """
        with self._database.read() as session:
            row = SearchRun
            query = select(
                _sum(row.tracks), _sum(row.accepted), _sum(row.rejected), _sum(row.notes), func.count(row.error)
            ).where(row.current == true())
            tracks, accepted, rejected, notes, unreadable = session.execute(query).one()
            twice, agreed = _agreement(session)
            people = session.scalars(select(Person).order_by(Person.key)).all()
            return Overview(
                videos=session.scalar(select(func.count()).select_from(Video)) or 0,
                tracks=tracks,
                reviewed=accepted + rejected,
                rejected=rejected,
                notes=notes,
                unread=unread + unreadable,
                decided_twice=twice,
                agreed=agreed,
                people=_workers(session, people),
                clocks=_clocks(session),
            )


def _done(edit: Edit, video_id: str, video_name: str) -> Done:
    keys = sorted(edit.after)
    return Done(
        seq=edit.seq,
        time=edit.created.isoformat(timespec="seconds"),
        name=edit.kind,
        frame=edit.frame,
        tracks=keys[:3],
        count=len(keys),
        run_id=edit.run_id,
        video_id=video_id,
        video_name=video_name,
    )


def _sum(column: InstrumentedAttribute[int]) -> ColumnElement[int]:
    """The sum of a column; 0 without rows."""
    return func.coalesce(func.sum(column), 0)


def _since() -> int:
    """First day of the figures of work; today is the last one."""
    return day_of(datetime.now(UTC)) - DAYS + 1


def _agreement(session: Session) -> tuple[int, int]:
    """Number of tracks with verdicts of two people, and how many of these verdicts are equal."""
    recent = Verdict.day >= _since()
    several = select(Verdict.run_id, Verdict.key).where(recent).group_by(Verdict.run_id, Verdict.key)
    verdicts = several.having(func.count() > 1)
    found = verdicts.add_columns((func.min(Verdict.verdict) == func.max(Verdict.verdict)).label("same")).subquery()
    twice, agreed = session.execute(select(func.count(), func.count(case((found.c.same, 1))))).one()
    return twice, agreed


def _workers(session: Session, people: Sequence[Person], author: str | None = None) -> list[Worker]:
    """The work of people and of authors without an account; ``author``: of this one only."""

    def recent(table: type[Verdict | WorkDay]) -> list[ColumnElement[bool]]:
        return [table.day >= _since(), *([] if author is None else [table.author == author])]

    days = select(WorkDay.author, func.sum(WorkDay.seconds)).where(*recent(WorkDay)).group_by(WorkDay.author)
    seconds = dict(session.execute(days).all())
    verdicts = select(Verdict.author, Verdict.verdict, func.count()).where(*recent(Verdict))
    decided: Counter[str] = Counter()
    rejected: Counter[str] = Counter()
    for name, verdict, count in session.execute(verdicts.group_by(Verdict.author, Verdict.verdict)):
        decided[name] += count
        rejected[name] += count if verdict == "rejected" else 0
    states = select(Assignment.person_id, Assignment.state, func.count()).group_by(
        Assignment.person_id, Assignment.state
    )
    open_count: Counter[str] = Counter()
    in_review: Counter[str] = Counter()
    for person_id, state, count in session.execute(states):
        open_count[person_id] += count if state != "done" else 0
        in_review[person_id] += count if state == "in_review" else 0
    accounts = {person.name: person for person in people}
    others = sorted(seconds.keys() - accounts.keys())
    workers = []
    for name in [*accounts, *others]:
        person = accounts.get(name)
        workers.append(
            Worker(
                name=name,
                role=None if person is None else cast(Role, person.role),
                decided=decided[name],
                rejected=rejected[name],
                hours=round(seconds.get(name, 0.0) / 3600, 2),
                assigned=0 if person is None else open_count[person.id],
                in_review=0 if person is None else in_review[person.id],
            )
        )
    return workers


def _clocks(session: Session) -> str | None:
    """A sentence if times in the log are before those of earlier rows, or in the future; else None."""
    back = session.scalar(select(func.max(WorkDay.back)).where(WorkDay.day >= _since())) or 0.0
    latest = session.scalar(select(func.max(WorkDay.latest)))
    in_future = 0.0 if latest is None else (latest - datetime.now(UTC)).total_seconds()
    difference = max(back, in_future)
    if difference <= _CLOCK_TOLERANCE_S:
        return None
    return (
        f"Clocks of servers differ, or were reset, by {round(difference / 60)} minutes: times in histories "
        "may be wrong. Their order is right."
    )
