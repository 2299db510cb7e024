"""A toy run on a server with sockets, made once; the tests of 3-D views share it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.app.scene3d.scene3d_client import Scene3dClient, open_client
from tests.app.toy_home import ToyHome, make_home


@pytest.fixture(scope="session")
def toy(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ToyHome]:
    """A data folder with one tracked toy drive."""
    home = make_home(tmp_path_factory.mktemp("scene3d"))
    yield home
    home.evidence.close()
    home.database.close()


@pytest.fixture(scope="session")
def api(toy: ToyHome) -> Iterator[Scene3dClient]:
    """A server on that folder."""
    with open_client(toy) as client:
        yield client
