"""The queue of waiting runs, and its order."""

from __future__ import annotations

from typing import Any

import pytest

from app.storage.models import Job
from tests.app.toy_server import Server


@pytest.fixture
def server(server_of_copy: Server) -> Server:
    """A server of the toy home, which these tests change."""
    return server_of_copy


def start(server: Server, home: Any, *names: str) -> list[str]:
    url = f"/api/videos/{home.video_id}/runs"
    return [server.client.post(url, json={"name": name}).json()["id"] for name in names]


def line(server: Server) -> list[str]:
    return [run["name"] for run in server.client.get("/api/run-queue").json()["runs"]]


def move(server: Server, run: str, before: str | None) -> Any:
    return server.client.post(f"/api/runs/{run}/turn", json={"before": before})


def test_a_waiting_run_is_moved_before_another_or_to_the_end(server: Server, home: Any) -> None:
    a, b, c = start(server, home, "a", "b", "c")
    assert line(server) == ["a", "b", "c"]
    assert move(server, c, a).json()["name"] == "c"
    assert line(server) == ["c", "a", "b"]
    assert move(server, c, b).status_code == 200
    assert line(server) == ["a", "c", "b"]
    assert move(server, a, None).status_code == 200
    assert line(server) == ["c", "b", "a"]
    with server.context.database.read() as session:
        waiting = [session.get_one(Job, job).subject for job in server.context.jobs.waiting_ids(session, "long")]
    assert waiting == [c, b, a], "workers take them in that order"


def test_a_run_moved_to_the_front_passes_higher_priorities(server: Server, home: Any) -> None:
    a, b = start(server, home, "a", "b")
    with server.context.database.write() as session:
        for job in session.query(Job).where(Job.subject == a):
            job.priority = 5
    assert line(server) == ["a", "b"]
    assert move(server, b, a).status_code == 200
    assert line(server) == ["b", "a"]


def test_running_runs_are_listed_first_and_not_moved(server: Server, home: Any) -> None:
    a, b, c = start(server, home, "a", "b", "c")
    context = server.context
    with context.database.write() as session:
        for job in session.query(Job).where(Job.subject == b):
            assert context.jobs.claim(session, job.id) is not None
    assert line(server) == ["b", "a", "c"]
    for run, before in ((b, a), (c, b), (c, c), (c, "0" * 32)):
        refused = move(server, run, before)
        assert refused.status_code == 409
        assert refused.json()["error"]["code"] == "not_waiting"
    assert line(server) == ["b", "a", "c"]
    assert move(server, "0" * 32, None).status_code == 404
