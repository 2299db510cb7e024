"""The base of all bodies that go in and out."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict

__all__ = ["PLAIN", "ErrorAnswer", "ErrorDetail", "Model"]

PLAIN = r"^[^\x00]*$"
"""Pattern of texts that go into the database: anything but NUL, which PostgreSQL cannot hold."""


class Model(BaseModel):
    """Nothing unknown, nothing infinite, nothing changed afterwards."""

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
