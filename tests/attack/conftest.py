"""The attack on the server as tests: what it did, in seconds. The tools are those of ``tests/app``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.databases import cluster
from tests.app.toy_server import Server

__all__ = ["cluster", "server"]


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    """A server without workers and samples."""
    made = Server(tmp_path / "home")
    with made.client:
        yield made
