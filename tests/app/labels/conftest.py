"""The label service on both kinds of database."""

from __future__ import annotations

import pytest

from app.events import EventBus
from app.labels.service import LabelService
from app.storage.database import Database


@pytest.fixture
def labels(database: Database) -> LabelService:
    """The sets of an empty library."""
    return LabelService(database, EventBus())
