"""What routes answer besides success, for the OpenAPI document."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any

from pydantic import BaseModel, ConfigDict

__all__ = ["PICTURE", "ErrorAnswer", "Model", "failures"]


class Model(BaseModel):
    """Base of all bodies: nothing unknown, nothing infinite."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)


class ErrorDetail(Model):
    """One failure."""

    code: str
    message: str
    field: str | None
    details: dict[str, Any] | None


class ErrorAnswer(Model):
    """The shape of every answer of status 400 and above."""

    error: ErrorDetail


_BYTES = {"schema": {"type": "string", "format": "binary"}}
PICTURE: dict[str, Any] = {"content": dict.fromkeys(("image/jpeg", "image/webp", "image/png"), _BYTES)}


def failures(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The failures of a route; those that every route can give are added."""
    every = {400, 401, 403, 413, 422, 503, 507, *statuses}
    return {s: {"model": ErrorAnswer, "description": HTTPStatus(s).phrase} for s in sorted(every)}
