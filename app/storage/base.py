"""What all tables are built on."""

from __future__ import annotations

from datetime import UTC, datetime

from sqlalchemy import BigInteger, Integer
from sqlalchemy.orm import DeclarativeBase

__all__ = ["Base", "Sequence", "now"]

Sequence = BigInteger().with_variant(Integer, "sqlite")
"""Whole numbers that count up; SQLite counts only INTEGER keys."""


def now() -> datetime:
    """This moment, UTC."""
    return datetime.now(UTC)


class Base(DeclarativeBase):
    """All tables."""
