"""A person's page as the server sees it: edits over HTTP."""

from __future__ import annotations

import uuid
from typing import Any

from tests.app.toy_server import Server


class EditClient:
    """One person's page."""

    def __init__(self, server: Server, run: str, author: str = "ann") -> None:
        self.client, self.run, self.author = server.client, run, author

    def send(self, command: dict[str, Any], match: str | None = None, op: str | None = None) -> Any:
        """Send an edit; ``match`` is its If-Match header."""
        headers = {} if match is None else {"If-Match": match}
        body = {"op_id": op or uuid.uuid4().hex, "author": self.author, "command": command}
        return self.client.post(f"/api/runs/{self.run}/edits", json=body, headers=headers)

    def annotation(self) -> Any:
        """The run's documents, and this person's undo target."""
        answer = self.client.get(f"/api/runs/{self.run}/annotation", params={"author": self.author})
        assert answer.status_code == 200
        return answer.json()

    def docs(self) -> dict[str, Any]:
        """Documents without the fields that every operation changes."""
        return {doc["key"]: {**doc, "revision": 0} for doc in self.annotation()["docs"]}

    def log(self, after: int = 0) -> list[Any]:
        """Edits of the run after a number in its log."""
        rows: list[Any] = self.client.get(f"/api/runs/{self.run}/edits", params={"after": after}).json()["edits"]
        return rows


def relabel(key: str, label: int | None) -> dict[str, Any]:
    """The command that gives a track a class."""
    return {"name": "relabel_track", "frame": 5, "key": key, "class_id": label}


def error_of(answer: Any) -> tuple[int, str]:
    """Status and code of a refusal."""
    return answer.status_code, answer.json()["error"]["code"]


def if_match_header(page: EditClient, tracks: list[str]) -> str:
    """An If-Match header with the newest revision of every track."""
    known = {**dict.fromkeys(tracks, 0), **{doc["key"]: doc["revision"] for doc in page.annotation()["docs"]}}
    return ", ".join(f'"{key}:{revision}"' for key, revision in known.items())
