"""Base class of all tables."""

from __future__ import annotations

from datetime import UTC, datetime

from sqlalchemy import BigInteger, Integer
from sqlalchemy.engine.default import DefaultExecutionContext
from sqlalchemy.orm import DeclarativeBase

Sequence = BigInteger().with_variant(Integer, "sqlite")
"""Integers with autoincrement; SQLite supports that only for INTEGER keys."""


def now() -> datetime:
    """The current time, UTC."""
    return datetime.now(UTC)


def current_server(context: DefaultExecutionContext) -> str | None:
    """The server that writes the row; see ``app.storage.database``."""
    server: str | None = context.connection.get_execution_options().get("tsr_server")
    return server


class Base(DeclarativeBase):
    """All tables."""
