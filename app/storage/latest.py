"""Chooses the run of a video when a request names none."""

from __future__ import annotations

from sqlalchemy import UnaryExpression

from app.storage.models import Run

__all__ = ["latest_last"]


def latest_last() -> tuple[UnaryExpression[bool] | UnaryExpression[int], ...]:
    """How to sort runs of a video so that the one it stands for comes last: a complete one, the engine's, the newest.

    Somebody else's tracks, which were imported, are asked for by the run's own name.
    """
    return (Run.state == "complete").asc(), (Run.kind == "engine").asc(), Run.order.asc()
