"""The parameters of the engine."""

from __future__ import annotations

from app.api.responses import failures
from app.api.routing import api_router
from app.parameter_catalogue import Parameter, parameters

router = api_router("catalogue")


@router.get("/parameters", operation_id="list_parameters", responses=failures())
def list_parameters() -> list[Parameter]:
    """Every parameter with its range, meaning and presets."""
    return parameters()
