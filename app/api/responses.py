"""Error answers of routes, for the OpenAPI document."""

from __future__ import annotations

from http import HTTPStatus

from fastapi.responses import Response

from app.shapes import ErrorAnswer, Model
from tsr_engine.json_shapes import JsonObject

__all__ = ["PICTURE", "failures", "json_answer"]


_BYTES = {"schema": {"type": "string", "format": "binary"}}
PICTURE: JsonObject = {"content": dict.fromkeys(("image/jpeg", "image/webp", "image/png"), _BYTES)}


def failures(*statuses: int) -> dict[int | str, JsonObject]:
    """The failures of a route; those that every route can give are added."""
    every = {400, 401, 403, 413, 422, 503, 507, *statuses}
    return {s: {"model": ErrorAnswer, "description": HTTPStatus(s).phrase} for s in sorted(every)}


def json_answer(answer: Model) -> Response:
    """An answer as JSON, made in the thread of its route; the framework would make it where it holds others up."""
    return Response(answer.model_dump_json(), media_type="application/json")
