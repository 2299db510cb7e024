"""A server on a real run for tests of the search, on each kind of database."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from uuid import uuid4

import pytest

from app.storage.models import Run
from tests.app.edits.conftest import run, server, tracked_home
from tests.app.edits.edit_client import EditClient
from tests.app.toy_home import ToyHome
from tests.app.toy_server import Server
from tests.waiting import wait_until

__all__ = ["library", "run", "server", "tracked_home"]


@dataclass
class Library:
    """Requests that tests make to the server."""

    server: Server
    home: ToyHome
    run: str

    def search(self, **params: Any) -> dict[str, Any]:
        """A page of tracks, as soon as no run is missing from it."""

        def whole_answer() -> dict[str, Any] | None:
            answer = self.server.client.get("/api/search", params=params)
            assert answer.status_code == 200, answer.text
            return dict(answer.json()) if answer.json()["unread"] == 0 else None

        found: dict[str, Any] = wait_until(whole_answer)
        return found

    def keys(self, **params: Any) -> list[str]:
        """Keys of what is found."""
        return [track["key"] for track in self.search(**params)["tracks"]]

    def refused(self, **params: Any) -> str:
        """The sentence of a refusal."""
        answer = self.server.client.get("/api/search", params=params)
        assert answer.status_code == 422, answer.text
        return str(answer.json()["error"]["message"])

    def act(self, action: dict[str, Any], tracks: list[dict[str, Any]], **further: Any) -> dict[str, Any]:
        """Do something with tracks that were found."""
        wanted = [{name: track[name] for name in ("run", "key", "revision")} for track in tracks]
        request = {"action_id": uuid4().hex, "action": action, "tracks": wanted, **further}
        answer = self.server.client.post("/api/search/actions", json=request)
        assert answer.status_code == 200, answer.text
        return dict(answer.json())

    def undo(self, done: dict[str, Any], **further: Any) -> dict[str, Any]:
        """Take an action back."""
        answer = self.server.client.post("/api/search/undo", json={"operations": done["operations"], **further})
        assert answer.status_code == 200, answer.text
        return dict(answer.json())

    def remove_run(self) -> None:
        """Remove the run; its evidence files stay, because all runs of the toy drive share them."""
        with self.home.database.write() as session:
            session.delete(session.get_one(Run, self.run))
            self.home.events.publish(session, "removed", self.run, {"run": self.run})

    def page(self) -> EditClient:
        """Somebody who corrects the run at the same time."""
        return EditClient(self.server, self.run)


@pytest.fixture
def library(server: Server, tracked_home: ToyHome, run: str) -> Iterator[Library]:
    """A library whose newest run is fresh; it is removed at the end."""
    with tracked_home.database.write() as session:
        tracked_home.events.publish(session, "run", run, {"state": "complete"})
    library = Library(server, tracked_home, run)
    yield library
    with tracked_home.database.read() as session:
        left = session.get(Run, run) is not None
    if left:
        library.remove_run()
