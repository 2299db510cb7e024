"""Bug bundles: made from a run by a job, and imported into the library."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query, Request
from pydantic import Field

from app.api.access import WhoDep
from app.api.request_body import RAW_BODY, received_file, run_while_connected
from app.api.responses import failures
from app.api.routing import api_router
from app.api.runs import RunId
from app.body_model import PLAIN, Model
from app.bundles.importing import BundleImport
from app.context import ContextDep
from app.edits.documents import Frame, Key
from app.outputs.view import OutputView

router = api_router("bundles")


class BundleOrder(Model):
    """Frames to pack, and what the bundle is about."""

    first: Frame
    stop: Annotated[int, Field(ge=1, le=2**31 - 1, strict=True)]
    note: Annotated[str, Field(max_length=8000, pattern=PLAIN)] = ""
    tracks: Annotated[tuple[Key, ...], Field(max_length=200)] = ()
    """Keys of the tracks with the problem; empty: all corrected tracks."""
    max_eq7: Annotated[float, Field(ge=0, lt=1)] | None = None
    """Error of Eq. 7 that a corrected box may have; unset: 0.25."""


@router.post("/runs/{run_id}/bundles", operation_id="bundle_run", status_code=202, responses=failures(404, 409))
def bundle_run(run_id: RunId, order: BundleOrder, context: ContextDep) -> OutputView:
    """Pack a range of frames with output and corrections. Returns the output that will hold the bundle."""
    return context.bundles.start(
        run_id, order.first, order.stop, note=order.note, tracks=order.tracks, max_eq7=order.max_eq7
    )


@router.post("/bundles", operation_id="import_bundle", status_code=201, responses=failures(), openapi_extra=RAW_BODY)
async def import_bundle(
    request: Request,
    context: ContextDep,
    who: WhoDep,
    name: Annotated[str, Query(min_length=1, max_length=255, description="what the file is called")] = "bundle.zip",
    author: Annotated[str | None, Query(min_length=1, max_length=80, pattern=PLAIN)] = None,
) -> BundleImport:
    """Import a bundle: its clip as a video, its run and its corrections. Either all of it is imported or nothing."""
    person = who.author(author)
    async with received_file(request, context, name) as (path, work):
        return await run_while_connected(
            request, lambda is_disconnected: context.bundle_imports.import_bundle(path, work, person, is_disconnected)
        )
