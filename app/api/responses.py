"""Answers that several routes give, and their entries of the OpenAPI document."""

from __future__ import annotations

from collections.abc import Callable
from http import HTTPStatus

from fastapi.responses import Response

from app.body_model import ErrorAnswer, Model
from tsr_engine.json_shapes import JsonObject

_BYTES = {"schema": {"type": "string", "format": "binary"}}
PICTURE: JsonObject = {"content": dict.fromkeys(("image/jpeg", "image/webp", "image/png"), _BYTES)}
CACHED_PNG: dict[int | str, JsonObject] = {
    200: {"content": {"image/png": _BYTES}},
    304: {"description": "Not Modified"},
}
"""The responses of :func:`cached_png`."""


def failures(*statuses: int) -> dict[int | str, JsonObject]:
    """Return the error responses of a route, together with those that every route can give."""
    all_statuses = {400, 401, 403, 413, 422, 503, 507, *statuses}
    return {s: {"model": ErrorAnswer, "description": HTTPStatus(s).phrase} for s in sorted(all_statuses)}


def cached_png(
    make: Callable[[], bytes], tag: str, if_none_match: str | None, cache: str = "max-age=31536000, immutable"
) -> Response:
    """Answer with a picture, or that the picture with this tag, which the browser has, is still the same.

    Args:
        make: makes the picture; called only if it is sent.
        tag: changes with the picture.
        if_none_match: the ETag of the picture that the browser has.
        cache: how long a browser may use the picture without asking.
    """
    headers = {"ETag": f'"{tag}"', "Cache-Control": f"private, {cache}"}
    if if_none_match == headers["ETag"]:
        return Response(status_code=304, headers=headers)
    return Response(make(), media_type="image/png", headers=headers)


def json_answer(answer: Model) -> Response:
    """Encode an answer as JSON in the thread of its route.

    The framework would encode it on the event loop and so delay other requests.
    """
    return Response(answer.model_dump_json(), media_type="application/json")
