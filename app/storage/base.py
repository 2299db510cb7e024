"""Base class of all tables."""

from __future__ import annotations

from datetime import UTC, datetime

from sqlalchemy import BigInteger, Integer
from sqlalchemy.engine.default import DefaultExecutionContext
from sqlalchemy.orm import DeclarativeBase

__all__ = ["Base", "Sequence", "here", "now"]

Sequence = BigInteger().with_variant(Integer, "sqlite")
"""Whole numbers that count up; SQLite counts only INTEGER keys."""


def now() -> datetime:
    """This moment, UTC."""
    return datetime.now(UTC)


def here(context: DefaultExecutionContext) -> str | None:
    """The server that writes; see ``app.storage.database``."""
    found: str | None = context.connection.get_execution_options().get("tsr_here")
    return found


class Base(DeclarativeBase):
    """All tables."""
