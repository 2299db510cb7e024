"""A server with one tracked drive whose follows tests make."""

from __future__ import annotations

import pytest
from sqlalchemy import select

from app.follows import service
from app.storage.models import Run
from tests.app.follows.follow_requests import LEASE_S
from tests.app.toy_server import Server


@pytest.fixture
def server(server_of_copy: Server, monkeypatch: pytest.MonkeyPatch) -> Server:
    """A server that keeps unaccepted follows for the whole test."""
    monkeypatch.setattr(service, "LEASE_S", LEASE_S)
    return server_of_copy


@pytest.fixture
def run(server: Server) -> str:
    with server.context.database.read() as session:
        return str(session.scalars(select(Run.id)).one())
