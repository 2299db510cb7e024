"""The route that compares two results of one video."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query

from app.api.responses import failures
from app.api.routing import api_router
from app.compare.service import Comparison
from app.context import ContextDep

router = api_router("compare")

Side = Annotated[
    str,
    Query(
        pattern="^(run|annotation|truth):[0-9a-f]{32}$",
        description="run:ID, annotation:RUN (the run as people have corrected it) or truth:ID",
    ),
]


@router.get("/compare", operation_id="compare", responses=failures(404, 409))
def compare(reference: Side, candidate: Side, context: ContextDep) -> Comparison:
    """Compare a candidate with a reference. Every figure lists the places behind it."""
    return context.compare.compare(reference, candidate)
