"""People on both kinds of database: the service, and a server that they talk to."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from app.events import EventBus
from app.people.directory import Directory
from app.people.service import PeopleService
from app.storage.database import Database
from tests.app.databases import new_database
from tests.app.people.team import Team, make_team
from tests.app.toy_home import ToyHome, make_home
from tests.app.toy_server import Server

__all__ = ["directory", "people", "server_without_people", "team", "team_server", "tracked_home"]


@pytest.fixture
def people(database: Database) -> PeopleService:
    """Accounts of an empty library."""
    return PeopleService(database, EventBus())


@pytest.fixture
def directory(database: Database) -> Directory:
    """Looks them up."""
    return Directory(database)


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def tracked_home(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ToyHome]:
    """One tracked toy drive for all tests of a module, on each kind of database."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "postgresql":
            patch.setenv("TSR_DATABASE_URL", new_database(request.getfixturevalue("cluster")))
        home = make_home(tmp_path_factory.mktemp("team"))
        yield home
        home.evidence.close()
        home.database.close()


@pytest.fixture(scope="module")
def team_server(tracked_home: ToyHome) -> Iterator[Server]:
    """A server on it; its database is the one that the environment names."""
    server = Server(
        tracked_home.settings.home, roots=(tracked_home.video.parent,), trusted_proxies=("10.0.0.0/24", "::1")
    )
    with server.client:
        yield server


@pytest.fixture
def team(team_server: Server) -> Iterator[Team]:
    """A person of each role; they are removed after the test."""
    made = make_team(team_server)
    yield made
    made.leave()


@pytest.fixture
def server_without_people(tmp_path: Path) -> Iterator[Server]:
    """A server without people."""
    server = Server(tmp_path / "home", database_url=None)  # not the one of ``made``
    with server.client:
        yield server
