"""Edits on both databases, over toy tracks and on a real run."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.app.databases import new_database
from tests.app.edits.edit_client import EditClient
from tests.app.edits.edit_services import EditServices, make_edit_services
from tests.app.toy_home import ToyHome, make_home
from tests.app.toy_server import Server

__all__ = ["ann", "edits", "run", "server", "tracked_home", "tracks"]


@pytest.fixture
def edits(database_url: str) -> Iterator[EditServices]:
    """A service with one complete run, on each kind of database."""
    services = make_edit_services(database_url)
    yield services
    services.database.close()


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def tracked_home(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ToyHome]:
    """One tracked toy drive for all tests here, on each kind of database."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "postgresql":
            patch.setenv("TSR_DATABASE_URL", new_database(request.getfixturevalue("cluster")))
        home = make_home(tmp_path_factory.mktemp("http"))
        yield home
        home.evidence.close()
        home.database.close()


@pytest.fixture(scope="module")
def server(tracked_home: ToyHome) -> Iterator[Server]:
    """A server on it; its database is the one that the environment names."""
    server = Server(tracked_home.settings.home, roots=(tracked_home.video.parent,))
    with server.client:
        yield server


@pytest.fixture
def run(tracked_home: ToyHome) -> str:
    """A fresh run with the evidence of the first: edits belong to a run."""
    return tracked_home.add_run(folder=f"runs/{tracked_home.run_id}", parameters={}, tracks=2)


@pytest.fixture
def ann(server: Server, run: str) -> EditClient:
    """A person."""
    return EditClient(server, run)


@pytest.fixture
def tracks(server: Server, run: str) -> list[str]:
    """Keys of the run's tracks."""
    found = [f"m{number}" for number in server.client.get(f"/api/runs/{run}/tracks").json()["id"]]
    assert len(found) >= 2
    return found
