"""A server in this process, on a data folder of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.toy_server import Server


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    """A server without workers and samples."""
    made = Server(tmp_path / "home")
    with made.client:
        yield made
