"""Four people, one of each role, and their programs."""

from __future__ import annotations

from dataclasses import dataclass, field

from starlette.testclient import TestClient

from app.people.roles import ROLES, Role
from tests.app.toy_server import Server

NAMES: dict[Role, str] = {"viewer": "Vera", "annotator": "Anna", "reviewer": "Rolf", "admin": "Adam"}


@dataclass
class Team:
    """People of a server.

    Attributes:
        server: their server.
        tokens: by name.
    """

    server: Server
    tokens: dict[str, str] = field(default_factory=dict)

    def client(self, name: str) -> TestClient:
        """A program of a person."""
        client = self.server.stranger()
        client.headers["Authorization"] = f"Bearer {self.tokens[name]}"
        return client

    def browser(self, name: str) -> TestClient:
        """A browser in which a person has signed in."""
        client = self.server.stranger()
        answer = client.post("/api/session", json={"token": self.tokens[name]})
        assert answer.status_code == 200, answer.text
        return client

    def leave(self) -> None:
        """Remove everybody, the administrators last."""
        service = self.server.context.people
        for person in sorted(service.views(), key=lambda one: one.role == "admin"):
            service.remove(person.name)
        self.server.context.directory.invalidate()


def make_team(server: Server) -> Team:
    """Add a person of each role."""
    team = Team(server)
    for role in ROLES:
        team.tokens[NAMES[role]] = server.context.people.add(NAMES[role], role)[1]
    server.context.directory.invalidate()
    return team
