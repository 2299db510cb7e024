"""Artefacts: list, look at, download, cancel, remove."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Path, Query
from fastapi.responses import FileResponse

from app.api.responses import failures
from app.artefacts.view import ArtefactView, artefact_view
from app.context import ContextDep
from app.shapes import Model

__all__ = ["ArtefactId", "router"]

router = APIRouter(tags=["artefacts"])

ArtefactId = Annotated[str, Path(pattern="^[0-9a-f]{32}$", description="name of the artefact: 32 hexadecimal digits")]
_FILE = {"content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}}}


class Artefacts(Model):
    """Artefacts, the newest first."""

    artefacts: list[ArtefactView]


@router.get("/artefacts", operation_id="list_artefacts", responses=failures())
def list_artefacts(
    context: ContextDep,
    kind: Annotated[Literal["export", "recording", "bundle", "scene"] | None, Query()] = None,
    run: Annotated[str | None, Query(pattern="^[0-9a-f]{32}$", description="made from this run alone")] = None,
) -> Artefacts:
    """Files that were made from runs, or are being made."""
    return Artefacts(artefacts=context.artefacts.list(kind, run))


@router.get("/artefacts/{artefact_id}", operation_id="get_artefact", responses=failures(404))
def get_artefact(artefact_id: ArtefactId, context: ContextDep) -> ArtefactView:
    """One artefact."""
    return artefact_view(context.artefacts.get(artefact_id))


@router.delete(
    "/artefacts/{artefact_id}", operation_id="remove_artefact", status_code=204, responses=failures(404, 409)
)
def remove_artefact(artefact_id: ArtefactId, context: ContextDep) -> None:
    """Remove an artefact and its file."""
    context.artefacts.remove(artefact_id)


@router.post(
    "/artefacts/{artefact_id}/cancel", operation_id="cancel_artefact", status_code=202, responses=failures(404)
)
def cancel_artefact(artefact_id: ArtefactId, context: ContextDep) -> ArtefactView:
    """Stop its making; nothing of it stays."""
    return artefact_view(context.artefacts.cancel(artefact_id))


@router.get(
    "/artefacts/{artefact_id}/download",
    operation_id="download_artefact",
    response_class=FileResponse,
    responses={200: _FILE, 206: _FILE, **failures(404, 409, 416)},
)
def download_artefact(artefact_id: ArtefactId, context: ContextDep) -> FileResponse:
    """The file, under its own name; parts of it by ``Range``."""
    path, name = context.artefacts.open(artefact_id)
    return FileResponse(
        path,
        filename=name,
        media_type="application/octet-stream",
        content_disposition_type="attachment",
        headers={"Content-Encoding": "identity"},  # parts of a file must be parts of the same bytes
    )
