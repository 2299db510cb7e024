"""Fixtures that tests of evidence, what-ifs, comparisons and ground truths share."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app import toy_home
from tests.app.toy_server import Server


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[toy_home.ToyHome]:
    """A data folder with one tracked toy drive."""
    home = toy_home.make_home(tmp_path_factory.mktemp("evidence"))
    yield home
    home.pixels.close()
    home.evidence.close()
    home.database.close()


@pytest.fixture
def server_of_copy(home: toy_home.ToyHome, tmp_path: Path) -> Iterator[Server]:
    """A server on a copy of the toy home, which a test may change."""
    folder = tmp_path / "home"
    shutil.copytree(home.settings.home, folder)
    server = Server(folder, roots=(home.video.parent,))
    with server.client:
        yield server
