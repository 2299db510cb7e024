"""The people of the library: accounts, assignments, activity."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path, Query
from pydantic import Field

from app.api.access import WhoDep
from app.api.responses import failures
from app.api.routing import api_router
from app.body_model import PLAIN, Model
from app.context import ContextDep
from app.edits.documents import Frame
from app.people.activity import Activity, Overview
from app.people.assignments import AssignmentView, State
from app.people.service import PersonView

router = api_router("people")

PersonName = Annotated[str, Field(min_length=1, max_length=80, pattern=PLAIN)]
_INDEX_WAIT_S = 0.1
"""Seconds that an overview waits for edits that are not in the tables of the search yet."""
_Video = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
AssignmentId = Annotated[int, Path(ge=1, le=2**31 - 1)]
Comment = Annotated[str, Field(max_length=2000, pattern=PLAIN)]


class People(Model):
    """Everybody."""

    people: list[PersonView]


class Assignments(Model):
    """Some assignments."""

    assignments: list[AssignmentView]


class NewAssignments(Model):
    """Videos or frames to assign, and the person."""

    videos: Annotated[list[_Video], Field(min_length=1, max_length=10_000)]
    person: PersonName
    first: Frame = 0
    stop: Annotated[int, Field(ge=1, le=2**31 - 1, strict=True)] | None = None
    comment: Comment = ""


class AssignmentChange(Model):
    """Fields to change; omitted fields stay."""

    revision: Annotated[int, Field(ge=1, le=2**31 - 1)]
    state: State | None = None
    comment: Comment | None = None
    person: PersonName | None = None


@router.get("/people", operation_id="list_people", responses=failures())
def list_people(context: ContextDep) -> People:
    """All people with an account, by name."""
    return People(people=context.people.views())


@router.get("/people/{name}/activity", operation_id="get_activity", responses=failures(404))
def get_activity(
    name: Annotated[str, Path(min_length=1, max_length=80, pattern=PLAIN)],
    context: ContextDep,
    who: WhoDep,
    before: Annotated[int | None, Query(ge=1, le=2**62, description="rows of the log before this number")] = None,
) -> Activity:
    """Operations of a person, newest first. Reading those of other people requires a reviewer."""
    if who.identity.name != name:
        who.identity.require("reviewer")
    return context.activity.of(name, before)


@router.get("/overview", operation_id="get_overview", responses=failures())
def get_overview(context: ContextDep) -> Overview:
    """Progress of the library and of its people."""
    return context.activity.overview(context.search.update(_INDEX_WAIT_S))


@router.get("/assignments", operation_id="list_assignments", responses=failures(404))
def list_assignments(
    context: ContextDep,
    video: Annotated[str | None, Query(pattern="^[0-9a-f]{64}$")] = None,
    person: Annotated[str | None, Query(min_length=1, max_length=80, pattern=PLAIN)] = None,
    state: State | None = None,
) -> Assignments:
    """Assignments: returned ones first, then those to do, in review, and done."""
    return Assignments(assignments=context.assignments.views(video_id=video, person=person, state=state))


@router.post("/assignments", operation_id="create_assignments", status_code=201, responses=failures(404, 409))
def create_assignments(wanted: NewAssignments, context: ContextDep, who: WhoDep) -> Assignments:
    """Assign videos, or the same frames of each, to a person. Either all are assigned or none."""
    made = context.assignments.create(
        who.identity, wanted.videos, wanted.person, wanted.first, wanted.stop, wanted.comment
    )
    return Assignments(assignments=made)


@router.patch("/assignments/{assignment_id}", operation_id="change_assignment", responses=failures(404, 409))
def change_assignment(
    assignment_id: AssignmentId, wanted: AssignmentChange, context: ContextDep, who: WhoDep
) -> AssignmentView:
    """Hand an assignment in, take it back, return it with a comment, close it or give it to another person."""
    return context.assignments.change(
        who.identity, assignment_id, wanted.revision, state=wanted.state, comment=wanted.comment, person=wanted.person
    )


@router.delete(
    "/assignments/{assignment_id}", operation_id="remove_assignment", status_code=204, responses=failures(404)
)
def remove_assignment(assignment_id: AssignmentId, context: ContextDep) -> None:
    """Remove an assignment; the work on its video is kept."""
    context.assignments.remove(assignment_id)
