"""A run whose end cannot be stored, as on a full disk, says so in lists and on open pages."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
import requests
from sqlalchemy.orm import Session

from app.jobs.locks import JobLock, note_unstored_end
from app.runs.unstored_ends import runs_with_unstored_ends
from app.storage.models import Job, Run, Video
from tests.app.test_streams import AUTHORISED
from tests.app.threaded_server import ThreadedServer, serve_in_thread
from tests.app.toy_server import Server

VIDEO, RUN, JOB = "f" * 64, "a" * 32, "b" * 32
NOTE = "over, but this cannot be stored: the disk is full"


@pytest.fixture
def live_server(tmp_path: Path) -> Iterator[ThreadedServer]:
    """A server with a running run, whose job this process holds."""
    with serve_in_thread(Server(tmp_path / "home")) as live:
        with live.server.context.database.write() as session:
            session.add(Video(id=VIDEO, name="v.mp4", path="/v", size=1, state="ready", warnings=[]))
            session.flush()
            session.add(Run(id=RUN, video_id=VIDEO, name="Run 1", state="running", rate=9.0))
            session.add(Job(id=JOB, kind="track", subject=RUN, state="running", payload={}, token=1))
        lock = JobLock(tmp_path / "home", JOB)
        assert lock.acquire()
        yield live
        lock.release()


def notes(live: ThreadedServer) -> set[str]:
    client = live.server.client
    runs = [client.get(f"/api/runs/{RUN}").json(), *client.get("/api/run-queue").json()["runs"]]
    return {run["note"] for run in (*runs, *client.get(f"/api/videos/{VIDEO}/runs").json()["runs"])}


def test_nothing_is_queried_while_all_ends_are_stored(tmp_path: Path) -> None:
    lock = JobLock(tmp_path, JOB)
    assert lock.acquire()
    assert runs_with_unstored_ends(Session(), tmp_path) == []  # a query would fail: the session has no database
    lock.release()


def test_lists_and_open_pages_say_so(live_server: ThreadedServer) -> None:
    url = live_server.url + "/api/events"
    assert notes(live_server) == {""}
    with closing(requests.get(url, headers=AUTHORISED, stream=True, timeout=60)) as before:
        lines = before.iter_lines(chunk_size=None, decode_unicode=True)
        assert next(lines).startswith("id: ")
        note_unstored_end(live_server.server.settings.home, JOB, "the disk is full")
        assert notes(live_server) == {NOTE}
        assert any(line == "event: unstored" for line in lines)
        assert NOTE in next(lines)
        with closing(requests.get(url, headers=AUTHORISED, stream=True, timeout=60)) as later:
            assert any(NOTE in line for line in later.iter_lines(chunk_size=None, decode_unicode=True)), "a new page"
    with live_server.server.context.database.write() as session:
        session.get_one(Run, RUN).state = session.get_one(Job, JOB).state = "failed"
    assert notes(live_server) == {""}
