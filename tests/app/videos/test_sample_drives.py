"""Events about the shipped drives that a new user's page receives, from the start."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from app.storage.models import Event, Job
from sample_videos import SHIPPED
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server

NAMES = [clip.video.name for clip in SHIPPED]


def newest_events(server: Server) -> dict[str, dict[str, Any]]:
    """The newest event of each video by name; events of runs are ignored."""
    with server.context.database.read() as session:
        events = session.query(Event).where(Event.kind == "video").order_by(Event.seq).all()
        return {event.data["name"]: event.data for event in events}


def listed_videos(server: Server) -> dict[str, dict[str, Any]]:
    return {video["name"]: video for video in server.client.get("/api/videos").json()["videos"]}


@pytest.fixture
def server(tmp_path: Path) -> Server:
    return Server(tmp_path / "home", sample=True)


def test_events_and_requests_give_the_same_state(server: Server) -> None:
    with server.client:
        run_jobs(server.context, "import")
        assert sorted(newest_events(server)) == sorted(NAMES)
        assert newest_events(server) == listed_videos(server)
        for video in listed_videos(server).values():
            run = server.client.get(f"/api/runs/{video['latest_run']}").json()
            assert (run["state"], video["runs"]) == ("queued", 1)

        run = newest_events(server)[NAMES[1]]["latest_run"]
        server.client.post(f"/api/runs/{run}/cancel").raise_for_status()
        server.client.delete(f"/api/runs/{run}").raise_for_status()
        assert newest_events(server)[NAMES[1]]["latest_run"] is None
        assert newest_events(server) == listed_videos(server)


def test_the_drive_of_the_first_screen_is_run_first(server: Server) -> None:
    with server.client:
        second = listed_videos(server)[NAMES[1]]["id"]
        with server.context.database.write() as session:
            session.query(Job).where(Job.subject == second).one().priority = 20
        run_jobs(server.context, "import")
        with server.context.database.read() as session:
            tracking = session.query(Job).where(Job.kind == "track").order_by(Job.priority.desc(), Job.order)
            runs = [job.subject for job in tracking]
        assert runs == [listed_videos(server)[name]["latest_run"] for name in NAMES]
