"""Assignments of videos, or of frames of them, to people: their state, and who may change it.

::

    assigned ──► in_review ──► done
                  │     ▲
                  ▼     │
                 returned (with a comment)

The assignee hands an assignment in (``in_review``) and can take it back. A reviewer assigns work, and accepts or
returns what was handed in.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Final, Literal, cast

from sqlalchemy import Select, case, insert, select
from sqlalchemy.orm import Session

from app.body_model import Model
from app.errors import Conflict, Invalid, NotFound, Refused
from app.events import EventBus
from app.people.identity import Identity
from app.people.roles import Role, at_least
from app.people.service import person_named
from app.storage.database import Database
from app.storage.lookup import in_parts, require_video
from app.storage.models import Assignment, Person, Video

State = Literal["assigned", "in_review", "returned", "done"]
_ASSIGNEE_TRANSITIONS: Final[dict[State, tuple[State, ...]]] = {
    "assigned": ("in_review",),
    "returned": ("in_review",),
    "in_review": ("assigned",),
}
"""State -> the states that the assignee may change it to."""
_ORDER: Final = {"returned": 0, "assigned": 1, "in_review": 2, "done": 3}
_MAX_LISTED: Final = 10_000


class AssignmentView(Model):
    """One assignment; see ``Assignment`` in static/js/types.js."""

    id: int
    video_id: str
    video_name: str
    person: str
    first: int
    stop: int | None
    state: State
    comment: str
    changed_by: str
    revision: int
    created: str
    changed: str


class AssignmentService:
    """Assignments of a library."""

    def __init__(self, database: Database, events: EventBus) -> None:
        self._database = database
        self._events = events

    def views(
        self, *, video_id: str | None = None, person: str | None = None, state: State | None = None
    ) -> list[AssignmentView]:
        """Assignments: returned ones first, then those to do, in review, and done; each oldest first.

        Args:
            video_id: only of this video; None: of all.
            person: only of this person; None: of all.
            state: only in this state; None: in any.

        Raises:
            NotFound: no such person.
        """
        rank = case(_ORDER, value=Assignment.state, else_=9)
        query = _joined().order_by(rank, Assignment.id).limit(_MAX_LISTED)
        with self._database.read() as session:
            if video_id is not None:
                query = query.where(Assignment.video_id == video_id)
            if person is not None:
                query = query.where(Assignment.person_id == person_named(session, person).id)
            if state is not None:
                query = query.where(Assignment.state == state)
            return [_view(row, owner, name) for row, owner, name in session.execute(query)]

    def create(
        self, who: Identity, video_ids: Sequence[str], person: str, first: int, stop: int | None, comment: str
    ) -> list[AssignmentView]:
        """Assign videos, or the same frames of each, to a person; either all are assigned or none.

        Args:
            who: the caller.
            video_ids: the videos.
            person: name of the person.
            first: first frame.
            stop: frame after the last; None: to the end.
            comment: comment for the person.

        Raises:
            NotFound: no such video or person.
            Invalid: the range of frames is empty or outside of a video, or the person is a viewer.
            Conflict: the person already has an overlapping assignment.
        """
        made = []
        with self._database.write() as session:
            assignee = person_named(session, person)
            require_worker(assignee)
            for part in in_parts(list(dict.fromkeys(video_ids))):
                found = {video.id: video for video in session.scalars(select(Video).where(Video.id.in_(part)))}
                for video_id in part:
                    _require_frames(found.get(video_id) or require_video(session, video_id), first, stop)
                self._refuse_overlap(session, assignee, found, Assignment(first=first, stop=stop))
                fields = {"person_id": assignee.id, "first": first, "stop": stop, "comment": comment}
                rows = [{"video_id": video_id, "changed_by": _name(who), **fields} for video_id in part]
                stored = session.scalars(insert(Assignment).returning(Assignment), rows)  # one statement for all
                by_video = {row.video_id: _view(row, assignee.name, found[row.video_id].name) for row in stored}
                views = [by_video[video_id] for video_id in part]
                data = {str(view.id): view.model_dump(mode="json") for view in views}
                self._events.publish_all(session, "assignment", data)
                made += views
        return made

    def change(
        self,
        who: Identity,
        assignment_id: int,
        revision: int,
        *,
        state: State | None = None,
        comment: str | None = None,
        person: str | None = None,
    ) -> AssignmentView:
        """Change the state, the comment or the person of an assignment.

        Args:
            who: the caller.
            assignment_id: the assignment.
            revision: revision that the page knows.
            state: the new state; None: unchanged.
            comment: the new comment; None: unchanged.
            person: the new assignee, who starts with ``assigned``; None: unchanged.

        Raises:
            NotFound: no such assignment or person.
            Conflict: the assignment has changed since (``details`` holds its current state), or it would be open and
                overlap another one of its person.
            Refused: the caller may not do that.
            Invalid: it is returned without a comment.
        """
        with self._database.write() as session:
            row = session.get(Assignment, assignment_id, with_for_update=True)
            if row is None:
                raise NotFound("There is no such assignment (any more).")
            current = self._current_view(session, row)
            _require_allowed(who, row, current.person, state, comment, person)
            if row.revision != revision:
                raise Conflict(
                    f"{row.changed_by} has changed this assignment meanwhile: it is {_words(row.state)} now.",
                    code="stale",
                    details={"current": current.model_dump(mode="json")},
                )
            if state == "returned" and not (comment or "").strip():
                raise Invalid("Write in a comment what must be done again.", field="comment")
            videos = {row.video_id: session.get_one(Video, row.video_id)}
            if person is not None:
                assignee = person_named(session, person)
                require_worker(assignee)
                if state != "done":
                    self._refuse_overlap(session, assignee, videos, row)
                row.person_id, row.state = assignee.id, state or "assigned"
            elif state is not None:
                if row.state == "done" and state != "done":
                    owner = session.get_one(Person, row.person_id)
                    self._refuse_overlap(session, owner, videos, row)
                row.state = state
            if comment is not None:
                row.comment = comment.strip()
            row.changed_by, row.revision, row.changed = _name(who), row.revision + 1, datetime.now(UTC)
            session.flush()
            view = self._current_view(session, row)
            self._publish(session, view)
            return view

    def remove(self, assignment_id: int) -> None:
        """Remove an assignment; the work on its video is kept.

        Raises:
            NotFound: no such assignment.
        """
        with self._database.write() as session:
            row = session.get(Assignment, assignment_id)
            if row is None:
                raise NotFound("There is no such assignment (any more).")
            session.delete(row)
            self._events.publish(session, "removed", str(assignment_id), {"kind": "assignment", "id": assignment_id})

    def _current_view(self, session: Session, row: Assignment) -> AssignmentView:
        found, owner, name = session.execute(_joined().where(Assignment.id == row.id)).one()
        return _view(found, owner, name)

    def _refuse_overlap(self, session: Session, person: Person, videos: Mapping[str, Video], row: Assignment) -> None:
        """Refuse to give a person the frames of an assignment in videos if another open one of theirs has some."""
        same = Assignment.video_id.in_(videos), Assignment.person_id == person.id, Assignment.state != "done"
        for other in session.scalars(select(Assignment).where(*same).order_by(Assignment.id)):
            begins, ends = row.stop is None or other.first < row.stop, other.stop is None or row.first < other.stop
            if other is not row and begins and ends:
                raise Conflict(
                    f"{person.name} has {videos[other.video_id].name} already, {_frames(other)}. Change that "
                    "assignment instead.",
                    code="assigned_already",
                )

    def _publish(self, session: Session, view: AssignmentView) -> None:
        self._events.publish(session, "assignment", str(view.id), view.model_dump(mode="json"))


def _require_allowed(
    who: Identity, row: Assignment, owner: str, state: State | None, comment: str | None, person: str | None
) -> None:
    """Refuse a change that neither the role nor being the assignee allows."""
    if at_least(who.role, "reviewer"):
        return
    if who.person != row.person_id:
        raise Refused(f"This is the work of {owner}. Only a reviewer or {owner} can change it.", code="not_yours")
    if person is not None or comment is not None or state is None:
        raise Refused("Only a reviewer can assign work or comment on it.", code="role")
    if state not in _ASSIGNEE_TRANSITIONS.get(cast(State, row.state), ()):
        raise Refused(f"Your work is {_words(row.state)}. Only a reviewer can make it {_words(state)}.", code="role")


def require_worker(person: Person) -> None:
    """Refuse to assign work to a person who cannot change anything.

    Raises:
        Invalid: the person is a viewer.
    """
    if not at_least(cast(Role, person.role), "annotator"):
        raise Invalid(f"{person.name} is a viewer and cannot change anything. Choose another person.", field="person")


def _require_frames(video: Video, first: int, stop: int | None) -> None:
    last = video.frames if video.state == "ready" else None  # an import counts them up
    if (stop is not None and stop <= first) or (last is not None and (first >= last or (stop or 0) > last)):
        until = "" if last is None else f" and end by {last}"
        raise Invalid(
            f"The frames of {video.name} begin at 0{until}; {first} to {'the end' if stop is None else stop} are not "
            "all among them.",
            field="first",
        )


def _frames(row: Assignment) -> str:
    if row.stop is None:
        return "whole" if row.first == 0 else f"from frame {row.first}"
    return f"frames {row.first} to {row.stop - 1}"


def _words(state: str) -> str:
    return state.replace("_", " ")


def _name(who: Identity) -> str:
    return who.name or "the server"


def _joined() -> Select[Assignment, str, str]:
    return (
        select(Assignment, Person.name, Video.name)
        .join(Person, Person.id == Assignment.person_id)
        .join(Video, Video.id == Assignment.video_id)
    )


def _view(row: Assignment, person: str, video: str) -> AssignmentView:
    return AssignmentView.from_row(
        row,
        video_name=video,
        person=person,
        created=row.created.isoformat(timespec="seconds"),
        changed=row.changed.isoformat(timespec="seconds"),
    )
