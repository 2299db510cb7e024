"""A toy run, tracked once; each test has a copy with a server on it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.exchange.exchange_client import ExchangeClient, open_client, unzipped
from tests.app.toy_home import ToyHome, make_home


@pytest.fixture(scope="session")
def tracked_home(tmp_path_factory: pytest.TempPathFactory) -> ToyHome:
    """The home that is copied."""
    home = make_home(tmp_path_factory.mktemp("exchange"))
    home.evidence.close()
    home.database.close()
    return home


@pytest.fixture
def api(tracked_home: ToyHome, tmp_path: Path) -> Iterator[ExchangeClient]:
    """A served copy."""
    client = open_client(tracked_home, tmp_path)
    with client.server.client:
        yield client


@pytest.fixture(scope="session")
def read_only_api(tracked_home: ToyHome, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ExchangeClient]:
    """A served copy that no test changes."""
    client = open_client(tracked_home, tmp_path_factory.mktemp("untouched"))
    with client.server.client:
        yield client


@pytest.fixture(scope="module")
def annotations(read_only_api: ExchangeClient) -> bytes:
    """The run as a CVAT file, before anybody has corrected it; the same in every copy."""
    return unzipped(read_only_api.download(read_only_api.export()))["annotations.xml"]
