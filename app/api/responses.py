"""Error answers of routes, for the OpenAPI document."""

from __future__ import annotations

from http import HTTPStatus

from fastapi.responses import Response

from app.body_model import ErrorAnswer, Model
from tsr_engine.json_shapes import JsonObject

_BYTES = {"schema": {"type": "string", "format": "binary"}}
PICTURE: JsonObject = {"content": dict.fromkeys(("image/jpeg", "image/webp", "image/png"), _BYTES)}


def failures(*statuses: int) -> dict[int | str, JsonObject]:
    """Return the error responses of a route, together with those that every route can give."""
    all_statuses = {400, 401, 403, 413, 422, 503, 507, *statuses}
    return {s: {"model": ErrorAnswer, "description": HTTPStatus(s).phrase} for s in sorted(all_statuses)}


def json_answer(answer: Model) -> Response:
    """Encode an answer as JSON in the thread of its route.

    The framework would encode it on the event loop and so delay other requests.
    """
    return Response(answer.model_dump_json(), media_type="application/json")
