"""What tests of the server share: an empty server, databases, a data folder with one tracked drive.

Fixtures of a session are imported here and nowhere below: pytest sets one up again for each module that imports it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.databases import bare_database_url, cluster, database, database_url
from tests.app.evidence_fixtures import home, server_of_copy
from tests.app.toy_server import Server

__all__ = ["bare_database_url", "cluster", "database", "database_url", "home", "server", "server_of_copy"]


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    """A server without workers and samples."""
    server = Server(tmp_path / "home")
    with server.client:
        yield server
