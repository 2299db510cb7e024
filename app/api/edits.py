"""Edits: read and apply corrections."""

from __future__ import annotations

import re
from typing import Annotated

from fastapi import Header, Path, Query
from fastapi.responses import Response
from pydantic import Field

from app.api.access import WhoDep
from app.api.responses import failures, json_answer
from app.api.routing import api_router
from app.api.runs import RunId
from app.body_model import PLAIN, Model
from app.context import ContextDep
from app.edits.commands import Command, Redo, Undo
from app.edits.documents import Key
from app.edits.earlier_run import Earlier, earlier_corrections
from app.edits.track_history import TrackHistory, track_history
from app.edits.views import Adopted, Annotation, EditAnswer, LogEntry
from app.errors import Invalid

router = api_router("edits")

Author = Annotated[str, Field(min_length=1, max_length=80, pattern=PLAIN)]
_TAG = re.compile(r'\s*"(m[0-9]{1,12}|h[0-9a-z]{6,40}):([0-9]{1,9})"\s*')


class Operation(Model):
    """One operation of one person."""

    op_id: Annotated[str, Field(pattern=r"^[0-9A-Za-z-]{8,64}$")]
    author: Author
    command: Annotated[Command | Undo | Redo, Field(discriminator="name")]


class AdoptFrom(Model):
    """Where the edits come from."""

    from_run: Annotated[str, Field(pattern="^[0-9a-f]{32}$")]
    author: Author | None = None


class Log(Model):
    """Rows of the log."""

    edits: list[LogEntry]


class EarlierCorrections(Model):
    """Corrections of an earlier run that can be carried over."""

    found: Earlier | None


@router.get(
    "/runs/{run_id}/annotation", operation_id="get_annotation", response_model=Annotation, responses=failures(404)
)
def get_annotation(
    run_id: RunId,
    context: ContextDep,
    who: WhoDep,
    author: Annotated[str | None, Query(max_length=80, pattern=PLAIN)] = None,
) -> Response:
    """Documents of all edited tracks, and the operations that the author can undo and redo."""
    return json_answer(context.edits.annotation(run_id, who.reader(author)))


@router.post("/runs/{run_id}/edits", operation_id="edit", response_model=EditAnswer, responses=failures(404, 409, 428))
def edit(
    run_id: RunId,
    operation: Operation,
    context: ContextDep,
    who: WhoDep,
    if_match: Annotated[
        str | None, Header(description='revision of each touched track: `"m7:3", "m9:1"`; 0: untouched so far')
    ] = None,
) -> Response:
    """Apply one operation. It is stored before the response is sent."""
    expected = None if if_match is None else _revisions(if_match)
    author = who.author(operation.author)
    return json_answer(context.edits.apply(run_id, operation.op_id, author, operation.command, expected))


@router.get("/runs/{run_id}/edits", operation_id="list_edits", responses=failures(404))
def list_edits(run_id: RunId, context: ContextDep, after: Annotated[int, Query(ge=0, le=2**62)] = 0) -> Log:
    """Rows of the log after a number, at most 1,000."""
    return Log(edits=context.edits.log(run_id, after))


@router.get("/runs/{run_id}/tracks/{track}/history", operation_id="get_track_history", responses=failures(404))
def get_track_history(
    run_id: RunId,
    track: Annotated[Key, Path()],
    context: ContextDep,
    before: Annotated[int | None, Query(ge=1, le=2**62, description="rows of the log before this number")] = None,
) -> TrackHistory:
    """Changes of a track, newest first: author, time, operation, state before and after."""
    with context.database.read() as session:
        return track_history(session, run_id, track, before)


@router.post("/runs/{run_id}/adopt", operation_id="adopt_edits", responses=failures(404, 409))
def adopt_edits(run_id: RunId, source: AdoptFrom, context: ContextDep, who: WhoDep) -> Adopted:
    """Copy the edits of another run of the same video to this one."""
    return context.bulk_edits.adopt(run_id, source.from_run, who.author(source.author))


@router.get("/runs/{run_id}/earlier", operation_id="get_earlier_corrections", responses=failures(404))
def get_earlier_corrections(run_id: RunId, context: ContextDep) -> EarlierCorrections:
    """Corrections of an earlier run of the same video that this run does not have."""
    with context.database.read() as session:
        return EarlierCorrections(found=earlier_corrections(session, context.evidence, run_id))


def _revisions(header: str) -> dict[str, int]:
    revisions = {}
    for part in header.split(","):
        match = _TAG.fullmatch(part)
        if match is None:
            raise Invalid('If-Match names tracks and revisions: "m7:3", "m9:1".', field="if-match")
        revisions[match[1]] = int(match[2])
    return revisions
