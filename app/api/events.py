"""The stream of changes."""

from __future__ import annotations

from typing import Annotated, cast

from fastapi import Header, Request
from fastapi.responses import StreamingResponse

from app.api.access import WhoDep
from app.api.responses import failures
from app.api.routing import api_router
from app.context import ContextDep
from app.errors import Invalid
from app.startup import Running
from tsr_engine.json_shapes import JsonObject

router = api_router("events")
_SSE: JsonObject = {"content": {"text/event-stream": {"schema": {"type": "string"}}}}


@router.get(
    "/events", operation_id="follow_events", response_class=StreamingResponse, responses={200: _SSE, **failures()}
)
async def follow_events(
    request: Request,
    context: ContextDep,
    who: WhoDep,
    last_event_id: Annotated[str | None, Header()] = None,
    after: str | None = None,
) -> StreamingResponse:
    """Server-sent events: ``change`` with seq, kind, subject and data; ``reset``: the page must reload everything."""
    last = after if last_event_id is None else last_event_id
    if last is not None and not (last.isascii() and last.isdigit() and len(last) < 19):
        raise Invalid("Last-Event-ID must be the number of an event.", field="last-event-id")
    running = cast(Running, request.app.state.running)

    async def has_access() -> bool:
        return await context.access.has_access(who.identity)

    stream = running.stream.follow(None if last is None else int(last), has_access)
    return StreamingResponse(stream, media_type="text/event-stream", headers={"X-Accel-Buffering": "no"})
