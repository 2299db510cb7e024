"""Requests about follows to a server, and what they leave in its database."""

from __future__ import annotations

from typing import Any

from sqlalchemy import func, select

from app.storage.models import Event, Follow, FollowPiece, Job
from tests.app.toy_server import Server

LEASE_S = 600.0
"""Seconds that the server of the tests keeps a follow in progress which nobody reads."""


def anchor_of(server: Server, run: str) -> dict[str, Any]:
    """A box in the middle of the engine's first track."""
    tracks = server.client.get(f"/api/runs/{run}/tracks").json()
    frame = (tracks["first"][0] + tracks["last"][0]) // 2
    overlay = server.client.get(f"/api/runs/{run}/overlays", params={"first": frame, "last": frame}).json()
    rows = overlay["overlays"]
    box = next(track["box"] for track in rows[0]["tracks"] if track["id"] == tracks["id"][0])
    return {"frame": frame, "box": box}


def start_follow(server: Server, run: str, anchors: list[dict[str, Any]], **more: Any) -> dict[str, Any]:
    answer = server.client.post(f"/api/runs/{run}/follows", json={"key": "m1", "anchors": anchors, **more})
    assert answer.status_code == 202, answer.text
    found: dict[str, Any] = answer.json()
    return found


def edit(server: Server, run: str, op_id: str, command: dict[str, Any], revision: int) -> None:
    answer = server.client.post(
        f"/api/runs/{run}/edits",
        headers={"If-Match": f'"{command["key"]}:{revision}"'},
        json={"op_id": op_id, "author": "ada", "command": command},
    )
    assert answer.status_code == 200, answer.text


def stored_rows(server: Server) -> dict[str, int]:
    """Rows that a follow may leave behind."""
    with server.context.database.read() as session:
        counts = {
            table.__tablename__: session.scalar(select(func.count()).select_from(table))
            for table in (Follow, FollowPiece)
        }
        jobs = session.scalar(select(func.count()).select_from(Job).where(Job.kind == "follow"))
        events = session.scalar(select(func.count()).select_from(Event).where(Event.kind == "follow"))
    return {name: count or 0 for name, count in {**counts, "jobs": jobs, "events": events}.items()}


NO_ROWS = {"follows": 0, "follow_pieces": 0, "jobs": 0, "events": 0}
