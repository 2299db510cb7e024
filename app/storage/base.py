"""Base class of all tables."""

from __future__ import annotations

from datetime import UTC, datetime

from sqlalchemy import BigInteger, Integer
from sqlalchemy.engine.default import DefaultExecutionContext
from sqlalchemy.orm import DeclarativeBase

__all__ = ["Base", "Sequence", "here", "now"]

Sequence = BigInteger().with_variant(Integer, "sqlite")
"""Integers with autoincrement; SQLite supports that only for INTEGER keys."""


def now() -> datetime:
    """The current time, UTC."""
    return datetime.now(UTC)


def here(context: DefaultExecutionContext) -> str | None:
    """The server that writes the row; see ``app.storage.database``."""
    found: str | None = context.connection.get_execution_options().get("tsr_here")
    return found


class Base(DeclarativeBase):
    """All tables."""
