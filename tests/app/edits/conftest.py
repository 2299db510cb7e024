"""Edits on both databases, over toy tracks."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parent))

from databases import cluster, database_url
from edit_desk import Desk, make_desk

__all__ = ["cluster", "database_url", "desk"]


@pytest.fixture
def desk(database_url: str) -> Iterator[Desk]:
    """A service with one complete run, on each kind of database."""
    made = make_desk(database_url)
    yield made
    made.database.close()
