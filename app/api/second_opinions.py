"""Second opinions by sample: give them out, answer them, and how well people agree."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path
from pydantic import Field

from app.api.access import WhoDep
from app.api.people import PersonName
from app.api.responses import failures
from app.api.routing import api_router
from app.body_model import Model
from app.context import ContextDep
from app.people.second_opinion import Given, NextLook, SecondOpinions

router = api_router("people")

_INDEX_WAIT_S = 10.0
"""Seconds that figures and samples wait for edits that are not in the tables of the search yet."""


class NewSecondOpinions(Model):
    """A person, and the share of the accepted tracks to look at."""

    person: PersonName
    share: Annotated[float, Field(gt=0, le=1)]


class SecondAnswer(Model):
    """The second person's label of a sign."""

    label: Annotated[int, Field(ge=-1, le=2**31 - 1, strict=True)] | None
    """-1: none of the set; None: it is no sign."""


@router.get("/second-opinions", operation_id="list_second_opinions", responses=failures())
def list_second_opinions(context: ContextDep) -> SecondOpinions:
    """How often the second answer equals the first, by label and by person, and the tracks where it does not."""
    context.search.update(_INDEX_WAIT_S)
    return context.second_opinions.report()


@router.post("/second-opinions", operation_id="give_second_opinions", status_code=201, responses=failures(404))
def give_second_opinions(wanted: NewSecondOpinions, context: ContextDep) -> Given:
    """Give a person a sample of the tracks that others have accepted.

    A repeated request samples only tracks that were accepted since.
    """
    unread = context.search.update(_INDEX_WAIT_S)
    return context.second_opinions.give(wanted.person, wanted.share, unread)


@router.get("/second-opinions/next", operation_id="get_second_opinion", responses=failures())
def get_second_opinion(context: ContextDep, who: WhoDep) -> NextLook:
    """The next sign for the caller to look at, without the first answer."""
    return context.second_opinions.next(who.identity)


@router.post(
    "/second-opinions/{look_id}/answer",
    operation_id="answer_second_opinion",
    status_code=204,
    responses=failures(404, 409),
)
def answer_second_opinion(
    look_id: Annotated[int, Path(ge=1, le=2**31 - 1)], said: SecondAnswer, context: ContextDep, who: WhoDep
) -> None:
    """Store the answer to a second opinion; the track stays as it is."""
    context.second_opinions.answer(who.identity, look_id, said.label)
