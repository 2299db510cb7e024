"""Makes the shared toys importable, and a service on both kinds of database."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from databases import cluster, database, database_url
from evidence_fixtures import toy_homes

from app.events import EventBus
from app.labels.service import LabelService
from app.storage.database import Database

__all__ = ["cluster", "database", "database_url", "toy_homes"]


@pytest.fixture
def labels(database: Database) -> LabelService:
    """The sets of an empty library."""
    return LabelService(database, EventBus())
