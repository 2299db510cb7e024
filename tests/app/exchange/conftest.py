"""A toy run, tracked once; each test has a copy with a server on it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.exchange.exchange_client import ExchangeClient, open_client, unzipped
from tests.app.toy_home import ToyHome, make_home


@pytest.fixture(scope="session")
def tracked(tmp_path_factory: pytest.TempPathFactory) -> ToyHome:
    """The home that is copied."""
    home = make_home(tmp_path_factory.mktemp("exchange"))
    home.evidence.close()
    home.database.close()
    return home


@pytest.fixture
def api(tracked: ToyHome, tmp_path: Path) -> Iterator[ExchangeClient]:
    """A served copy."""
    client = open_client(tracked, tmp_path)
    with client.server.client:
        yield client


@pytest.fixture(scope="session")
def untouched(tracked: ToyHome, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ExchangeClient]:
    """A served copy that no test changes."""
    client = open_client(tracked, tmp_path_factory.mktemp("untouched"))
    with client.server.client:
        yield client


@pytest.fixture(scope="module")
def annotations(untouched: ExchangeClient) -> bytes:
    """The run as a CVAT file, before anybody has corrected it; the same in every copy."""
    return unzipped(untouched.download(untouched.export()))["annotations.xml"]
