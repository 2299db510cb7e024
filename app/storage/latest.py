"""Chooses the run of a video when a request names none."""

from __future__ import annotations

from sqlalchemy import UnaryExpression

from app.storage.models import Run

__all__ = ["latest_last"]


def latest_last() -> tuple[UnaryExpression[bool] | UnaryExpression[int], ...]:
    """Sort the current run of a video last: complete after incomplete, the engine's after imported, then by age.

    Imported tracks of others are only used if a request names their run.
    """
    return (Run.state == "complete").asc(), (Run.kind == "engine").asc(), Run.order.asc()
