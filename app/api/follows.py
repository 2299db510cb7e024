"""Following a sign: start, wait for proposals, drop. Accepting them is an edit (``follow`` of app.edits.commands)."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path, Query
from pydantic import Field

from app.api.access import WhoDep
from app.api.edits import Author
from app.api.responses import failures
from app.api.routing import api_router
from app.api.runs import RunId
from app.body_model import PLAIN, Model
from app.context import ContextDep
from app.edits.documents import Frame, Key
from app.follows.view import FollowAnchor, FollowView, Only

router = api_router("follows")

FollowId = Annotated[str, Path(pattern="^[0-9a-f]{32}$", description="name of the follow: 32 hexadecimal digits")]


class NewFollow(Model):
    """Boxes to follow from."""

    key: Key
    anchors: Annotated[list[FollowAnchor], Field(min_length=1, max_length=500)]
    only: Only | None = None
    first: Frame = 0
    last: Frame | None = None
    author: Author | None = None


class ExpectedFollow(Model):
    """A box that a person may follow soon."""

    frame: Frame


class FoundFollow(Model):
    """The open follow of an author in a run, if any."""

    found: FollowView | None


@router.post("/runs/{run_id}/follows", operation_id="start_follow", status_code=202, responses=failures(404, 409))
def start_follow(run_id: RunId, wanted: NewFollow, context: ContextDep, who: WhoDep) -> FollowView:
    """Follow a sign from boxes that a person has set. The author's earlier proposals in this run are dropped."""
    return context.follows.start(
        run_id, who.author(wanted.author), wanted.key, wanted.anchors, wanted.only, wanted.first, wanted.last
    )


@router.post("/runs/{run_id}/follows/expected", operation_id="expect_follow", status_code=204, responses=failures(404))
def expect_follow(run_id: RunId, expected: ExpectedFollow, context: ContextDep) -> None:
    """Prepare for a follow from this frame, so that its proposals come sooner. Pages send this for a selected box."""
    context.follows.expect(run_id, expected.frame)


@router.get("/runs/{run_id}/follows", operation_id="find_follow", responses=failures(404))
def find_follow(
    run_id: RunId,
    context: ContextDep,
    who: WhoDep,
    author: Annotated[str | None, Query(max_length=80, pattern=PLAIN)] = None,
) -> FoundFollow:
    """Proposals that wait for an author's decision, for example after a reload of the page."""
    return FoundFollow(found=context.follows.newest(run_id, who.reader(author)))


@router.get("/follows/{follow_id}", operation_id="get_follow", responses=failures(404))
async def get_follow(
    follow_id: FollowId,
    context: ContextDep,
    after: Annotated[int, Query(ge=0, le=2**31 - 1)] = 0,
    wait: Annotated[float, Query(ge=0, le=10, description="seconds to wait for something new")] = 0.0,
) -> FollowView:
    """Proposals since the number `after`.

    Follows that no client reads are dropped: after 20 seconds while in progress, after a day when finished.
    """
    return await context.follows.wait(follow_id, after, wait)


@router.delete("/follows/{follow_id}", operation_id="drop_follow", status_code=204, responses=failures())
def drop_follow(follow_id: FollowId, context: ContextDep) -> None:
    """Stop following and discard the proposals."""
    context.follows.drop(follow_id)
