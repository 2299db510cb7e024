"""What people have done: one person's operations, and how the work of all goes, from the log of edits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from typing import Any, cast

from sqlalchemy import func, select, true
from sqlalchemy.orm import Session

from app.people.roles import Role
from app.people.service import person_named
from app.people.work import Decision, agreement, clocks_differ, decided, decisions, hours_of
from app.search.filters import noted
from app.shapes import Model
from app.storage.database import Database
from app.storage.models import Assignment, Edit, Person, Run, SearchRun, SearchTrack, Video

__all__ = ["Activity", "ActivityService", "Done", "Overview", "Worker"]

DAYS = 30
"""Days that figures of work look back."""
_PAGE = 100


class Done(Model):
    """One operation of a person."""

    seq: int
    time: str
    name: str
    frame: int | None
    tracks: list[str]
    """Keys; the first few of many."""
    count: int
    """How many tracks."""
    run_id: str
    video_id: str
    video_name: str


class Worker(Model):
    """How the work of a person goes; the figures are of the last 30 days."""

    name: str
    role: Role | None
    """None: an author without an account, as from before there were people."""
    decided: int
    """Tracks accepted or rejected."""
    rejected: int
    """Those of them that were rejected."""
    hours: float
    """Time between operations, five minutes of a break."""
    assigned: int
    """Assignments that are not done."""
    in_review: int
    """Assignments that wait for a reviewer."""


class Activity(Model):
    """A person's operations, the newest first."""

    worker: Worker
    done: list[Done]
    more: int | None
    """Ask for what came before this number; None: this is all."""


class Overview(Model):
    """The runs that stand for the videos, as the search knows them, and the work of the last 30 days."""

    videos: int
    tracks: int
    """Those that are there; regions that nobody counts are left out."""
    reviewed: int
    rejected: int
    notes: int
    unread: int
    """Runs whose tracks or newest edits are not in these figures: not read yet, or unreadable."""
    decided_twice: int
    """Tracks that two people have decided."""
    agreed: int
    """Those of them on which they say the same."""
    people: list[Worker]
    clocks: str | None
    """A sentence where times of the log cannot be right."""


class ActivityService:
    """Reads the log."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def of(self, name: str, before: int | None = None) -> Activity:
        """What a person has done.

        Args:
            name: of the person.
            before: rows of the log before this number; None: from the newest on.

        Raises:
            NotFound: there is nobody of that name.
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
            (worker,) = _workers(session, _decisions(session, person.name), _moments(session, person.name), [person])
            return Activity(worker=worker, done=done, more=done[-1].seq if len(rows) > _PAGE else None)

    def overview(self, unread: int) -> Overview:
        """How far the library is, and how the work goes.

        Args:
            unread: runs that the tables of the search lack so far.
        """
        with self._database.read() as session:
            states = _states(session)
            broken = select(func.count()).where(SearchRun.error.is_not(None), SearchRun.current == true())
            found, moments = _decisions(session), _moments(session)
            twice, agreed = agreement(found)
            people = session.scalars(select(Person).order_by(Person.key)).all()
            return Overview(
                videos=session.scalar(select(func.count()).select_from(Video)) or 0,
                tracks=states.total(),
                reviewed=states["accepted"] + states["rejected"],
                rejected=states["rejected"],
                notes=_notes(session),
                unread=unread + (session.scalar(broken) or 0),
                decided_twice=twice,
                agreed=agreed,
                people=_workers(session, found, moments, people),
                clocks=_clocks([moment for _, moment in moments]),
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


def _recent(author: str | None) -> list[Any]:
    since = [Edit.created >= datetime.now(UTC) - timedelta(days=DAYS)]
    return since if author is None else [*since, Edit.author == author]


def _decisions(session: Session, author: str | None = None) -> list[Decision]:
    """Verdicts of the last days, without those that were undone."""
    recent = _recent(author)
    stands: dict[str, str] = {}
    reverting = select(Edit.reverts, Edit.kind).where(*recent, Edit.kind.in_(["undo", "redo"])).order_by(Edit.seq)
    for reverted, kind in session.execute(reverting):
        stands[str(reverted)] = kind
    query = select(Edit.op_id, Edit.author, Edit.run_id, Edit.command)
    verdicts = query.where(*recent, Edit.kind.in_(["set_review", "review_tracks"])).order_by(Edit.seq)
    rows = ((op_id, by, run, command) for op_id, by, run, command in session.execute(verdicts))
    return decisions(rows, (op_id for op_id, kind in stands.items() if kind == "undo"))


def _moments(session: Session, author: str | None = None) -> list[tuple[str, datetime]]:
    """Author and time of the operations of the last days, in the order of the log."""
    query = select(Edit.author, Edit.created).where(*_recent(author)).order_by(Edit.seq)
    return [(by, created) for by, created in session.execute(query)]


def _workers(
    session: Session, found: Sequence[Decision], moments: Sequence[tuple[str, datetime]], people: Sequence[Person]
) -> list[Worker]:
    by_author: dict[str, list[datetime]] = {}
    for author, moment in moments:
        by_author.setdefault(author, []).append(moment)
    tracks = decided(found)
    rejected = decided(one for one in found if one.verdict == "rejected")
    states = select(Assignment.person_id, Assignment.state, func.count()).group_by(
        Assignment.person_id, Assignment.state
    )
    left: Counter[str] = Counter()
    in_review: Counter[str] = Counter()
    for person_id, state, count in session.execute(states):
        left[person_id] += count if state != "done" else 0
        in_review[person_id] += count if state == "in_review" else 0
    accounts = {person.name: person for person in people}
    others = sorted(by_author.keys() - accounts.keys())
    workers = []
    for name in [*accounts, *others]:
        person = accounts.get(name)
        workers.append(
            Worker(
                name=name,
                role=None if person is None else cast(Role, person.role),
                decided=len(tracks.get(name, ())),
                rejected=len(rejected.get(name, ())),
                hours=round(hours_of(by_author.get(name, [])), 2),
                assigned=0 if person is None else left[person.id],
                in_review=0 if person is None else in_review[person.id],
            )
        )
    return workers


def _states(session: Session) -> Counter[str]:
    """How many tracks are in which state of review."""
    row = SearchTrack
    counted = select(row.state, func.count()).where(row.current == true(), row.state != "ignored").group_by(row.state)
    return Counter(dict(session.execute(counted).all()))


def _notes(session: Session) -> int:
    """How many notes there are on tracks."""
    text = SearchTrack.notes
    lines = func.length(text) - func.length(func.replace(text, "\n", "")) + 1
    return session.scalar(select(func.sum(lines)).where(SearchTrack.current == true(), noted())) or 0


def _clocks(moments: Sequence[datetime]) -> str | None:
    apart = clocks_differ(moments, datetime.now(UTC))
    if apart is None:
        return None
    minutes = round(apart / timedelta(minutes=1))
    return (
        f"The clocks of servers or of the past differ by {minutes} minutes: times in histories may be wrong. Their "
        "order is right."
    )
