"""A toy run that was tracked once; each test has a copy with a server on it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.exchange.exchange_client import ExchangeClient, open_client
from tests.app.toy_home import ToyHome, make_home


@pytest.fixture(scope="session")
def checked_home(tmp_path_factory: pytest.TempPathFactory) -> ToyHome:
    """The home that is copied."""
    home = make_home(tmp_path_factory.mktemp("check"))
    home.evidence.close()
    home.database.close()
    return home


@pytest.fixture
def api(checked_home: ToyHome, tmp_path: Path) -> Iterator[ExchangeClient]:
    """A served copy."""
    client = open_client(checked_home, tmp_path)
    with client.server.client:
        yield client
