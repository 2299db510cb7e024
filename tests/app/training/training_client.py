"""A server on a toy home, with requests for training."""

from __future__ import annotations

import uuid
from typing import Any

from tests.app import toy_home
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server


class TrainingClient:
    """One server on a toy home, with helpers."""

    def __init__(self, home: toy_home.ToyHome, server: Server) -> None:
        self.home, self.server, self.client = home, server, server.client

    def accept(self) -> None:
        """Label the engine's tracks as limits of 50 and accept them."""
        with self.home.reader() as reader:
            tracks = [t for t in reader.tracks() if t.confirmed]
        assert tracks
        for track in tracks:
            for command in ({"name": "relabel_track", "class_id": 2}, {"name": "set_review", "review": "accepted"}):
                body = {"key": f"m{track.track_id}", "frame": track.first_frame, **command}
                answer = self.client.post(
                    f"/api/runs/{self.home.run_id}/edits",
                    json={"op_id": uuid.uuid4().hex, "author": "ann", "command": body},
                    headers={"If-Match": f'"m{track.track_id}:{0 if command["name"] == "relabel_track" else 1}"'},
                )
                assert answer.status_code == 200, answer.text

    def export(self, **params: Any) -> str:
        answer = self.client.post("/api/exports", json={"runs": [self.home.run_id], "format": "cvat-video", **params})
        assert answer.status_code == 202, answer.text
        run_jobs(self.server.context, "export")
        return str(answer.json()["id"])

    def ask(self, **body: Any) -> Any:
        return self.client.post("/api/models", json=body)

    def train(self, **body: Any) -> dict[str, Any]:
        answer = self.ask(**body)
        assert answer.status_code == 202, answer.text
        run_jobs(self.server.context, "retrain")
        return self.view(answer.json()["id"])

    def view(self, version: str) -> dict[str, Any]:
        found: dict[str, Any] = self.client.get(f"/api/models/{version}").json()
        return found

    def active(self) -> str:
        return str(self.client.get("/api/models").json()["active"])
