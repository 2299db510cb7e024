"""The search across videos, and actions on its results."""

from __future__ import annotations

import re
from typing import Annotated

from fastapi import Header, Query
from fastapi.responses import Response
from pydantic import Field

from app.api.access import WhoDep
from app.api.edits import Author
from app.api.responses import CACHED_PNG, cached_png, failures
from app.api.routing import api_router
from app.body_model import Model
from app.context import ContextDep
from app.errors import Invalid
from app.search.actions import MAX_TRACKS, Operation, TrackAction, TracksDone, WantedTrack
from app.search.query import SearchAnswer, SearchRequest, answer
from app.videos.tags import TagRequest, change_tags

router = api_router("search")

_INDEX_WAIT_S = 0.1
"""Seconds that a search waits for edits that are not in its tables yet."""
_NUMBER = re.compile(r"-?[0-9]{1,7}(\.[0-9]{1,6})?")


class ActionRequest(Model):
    """An action of one person on tracks that were found."""

    action_id: Annotated[str, Field(pattern=r"^[0-9A-Za-z-]{8,64}$")]
    author: Author | None = None
    action: TrackAction
    tracks: Annotated[list[WantedTrack], Field(min_length=1, max_length=MAX_TRACKS)]


class UndoRequest(Model):
    """Operations to undo."""

    author: Author | None = None
    operations: Annotated[list[Operation], Field(min_length=1, max_length=MAX_TRACKS)]


class Tagged(Model):
    """Result of a change of tags."""

    changed: int
    """Videos whose tags changed."""


@router.get("/search", operation_id="search", responses=failures())
def search(request: Annotated[SearchRequest, Query()], context: ContextDep) -> SearchAnswer:
    """Tracks of the whole library that pass all filters, in pages."""
    unread = context.search.update(_INDEX_WAIT_S)
    with context.database.read() as session:
        return answer(session, request, unread)


@router.get(
    "/search/crop",
    operation_id="get_search_crop",
    response_class=Response,
    responses=failures(404, 409) | CACHED_PNG,
)
def get_search_crop(
    run: Annotated[str, Query(pattern="^[0-9a-f]{32}$")],
    frame: Annotated[int, Query(ge=0, le=2**31 - 2)],
    box: Annotated[str, Query(max_length=80, description="x1,y1,x2,y2, px")],
    context: ContextDep,
    size: Annotated[int, Query(ge=8, le=512, description="longer side, px")] = 96,
    if_none_match: Annotated[str | None, Header()] = None,
) -> Response:
    """The picture under a box of a run's video, with a margin of a tenth of its side."""
    edges = _edges(box)
    return cached_png(
        lambda: context.pixels.crop_of_box(run, frame, edges, size, context.frames.raw),
        f"{run}-{frame}-{box}-{size}",
        if_none_match,
    )


@router.post("/search/actions", operation_id="act_on_tracks", responses=failures(404, 409))
def act_on_tracks(wanted: ActionRequest, context: ContextDep, who: WhoDep) -> TracksDone:
    """Judge, relabel or ignore tracks of many runs: one operation per run, which one undo reverts.

    Tracks that somebody has changed since, or that cannot be changed this way, stay as they are and are listed.
    """
    author = who.author(wanted.author)
    return context.search_actions.apply(wanted.action, wanted.tracks, author, wanted.action_id)


@router.post("/search/undo", operation_id="undo_tracks", responses=failures(404, 409))
def undo_tracks(wanted: UndoRequest, context: ContextDep, who: WhoDep) -> TracksDone:
    """Undo an action in each run where it is still its author's newest operation."""
    return context.search_actions.undo(wanted.operations, who.author(wanted.author))


@router.post("/videos/tags", operation_id="tag_videos", responses=failures(404))
def tag_videos(wanted: TagRequest, context: ContextDep) -> Tagged:
    """Add tags to videos or remove them: for all named videos or for none."""
    return Tagged(changed=change_tags(context.database, context.events, wanted))


def _edges(text: str) -> tuple[float, float, float, float]:
    parts = text.split(",")
    if len(parts) == 4 and all(_NUMBER.fullmatch(part) for part in parts):
        x1, y1, x2, y2 = map(float, parts)
        if x1 < x2 and y1 < y2:
            return x1, y1, x2, y2
    raise Invalid(f"Expected a box: four numbers x1,y1,x2,y2 with x1 < x2 and y1 < y2. Got {text!r}.", field="box")
