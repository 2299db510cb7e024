"""The classes with their pictograms, and the parameters of the engine."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Header, Path, Query
from fastapi.responses import Response

from app.api.responses import failures
from app.catalogue import Label, Parameter, labels, parameters
from app.context import ContextDep
from tsr_engine.version import __version__

__all__ = ["router"]

router = APIRouter(tags=["catalogue"])

_PNG: dict[str, Any] = {"content": {"image/png": {"schema": {"type": "string", "format": "binary"}}}}


@router.get("/labels", operation_id="list_labels", responses=failures())
def list_labels() -> list[Label]:
    """The 43 classes, by number."""
    return labels()


@router.get(
    "/labels/{class_id}.png",
    operation_id="get_pictogram",
    response_class=Response,
    responses={**failures(), 200: _PNG, 304: {"description": "Not Modified"}},
)
def get_pictogram(
    class_id: Annotated[int, Path(ge=0, le=42)],
    context: ContextDep,
    size: Annotated[int, Query(ge=8, le=512, description="side, px")] = 64,
    if_none_match: Annotated[str | None, Header()] = None,
) -> Response:
    """The sign itself, square, transparent around it."""
    tag = f'"{__version__}-{class_id}-{size}"'
    headers = {"ETag": tag, "Cache-Control": "private, max-age=86400"}
    if if_none_match == tag:
        return Response(status_code=304, headers=headers)
    return Response(context.pictograms.png(class_id, size), media_type="image/png", headers=headers)


@router.get("/parameters", operation_id="list_parameters", responses=failures())
def list_parameters() -> list[Parameter]:
    """Every parameter with its range, meaning and presets."""
    return parameters()
