"""The attack on the server as tests: what it did, in seconds. The tools are those of ``tests/app``."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "app" / "bundles"))
sys.path.insert(0, str(Path(__file__).parents[1] / "app" / "exchange"))
sys.path.insert(0, str(Path(__file__).parents[1] / "app"))
sys.path.insert(0, str(Path(__file__).parent))

from databases import cluster
from toy_server import Server

__all__ = ["cluster", "server"]


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    """A server without workers and samples."""
    made = Server(tmp_path / "home")
    with made.client:
        yield made
