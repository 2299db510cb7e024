"""Removal of a run: its dependent jobs, and its folders."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from app.storage.models import Run
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server


@pytest.fixture
def server(server_of_copy: Server) -> Server:
    """A server of the toy home, which these tests change."""
    return server_of_copy


@pytest.mark.parametrize(
    ("path", "order"),
    [
        ("/api/runs/{}/recordings", {"first": 0, "stop": 5}),
        ("/api/runs/{}/bundles", {"first": 0, "stop": 5}),
        ("/api/runs/{}/scenes", {}),
        ("/api/exports", {"format": "mot"}),
    ],
)
def test_jobs_waiting_for_a_removed_run_say_so(server: Server, home: Any, path: str, order: dict[str, Any]) -> None:
    runs = {"runs": [home.run_id]} if "exports" in path else {}
    requested = server.client.post(path.format(home.run_id), json={**order, **runs})
    assert requested.status_code == 202, requested.text
    assert server.client.delete(f"/api/runs/{home.run_id}").status_code == 204
    run_jobs(server.context)
    made = server.client.get(f"/api/outputs/{requested.json()['id']}").json()
    assert (made["state"], made["error"]) == ("failed", "The run has been removed in the meantime.")


@pytest.mark.parametrize("working", [True, False])
def test_a_run_cannot_be_removed_during_its_what_if(server: Server, home: Any, working: bool) -> None:
    context = server.context
    requested = server.client.post(f"/api/runs/{home.run_id}/whatif", json={"parameters": {"tau": 4}}).json()
    with context.database.write() as session:
        job = context.jobs.claim(session, context.jobs.waiting_ids(session)[0])
        assert job is not None
        session.get_one(Run, requested["id"]).state = "running" if working else "queued"
    refused = server.client.delete(f"/api/runs/{home.run_id}")
    assert refused.status_code == 409
    state = "running" if working else "queued"
    assert refused.json()["error"]["message"] == f"The what-if tau = 4 of Run 1 is {state}. Cancel it first."
    assert server.client.get(f"/api/runs/{requested['id']}").status_code == 200
    with context.database.write() as session:
        context.jobs.release(session, job.id, job.token)
    server.client.post(f"/api/runs/{requested['id']}/cancel")
    assert server.client.delete(f"/api/runs/{home.run_id}").status_code == 204
    assert server.client.get(f"/api/runs/{requested['id']}").status_code == 404


def test_what_is_open_of_removed_runs_is_closed(server: Server, home: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    whatif = server.client.post(f"/api/runs/{home.run_id}/whatif", json={"parameters": {"tau": 4}}).json()["id"]
    runs = server.context.settings.home / "runs"
    shutil.copytree(runs / home.run_id, runs / whatif)
    with server.context.database.write() as session:
        server.context.jobs.cancel(session, whatif)
        session.get_one(Run, whatif).state = "complete"
    for run in (home.run_id, whatif):
        assert server.client.get(f"/api/runs/{run}/tracks").json()["id"]
    assert open_files_of(whatif)
    viewed: list[str] = []
    monkeypatch.setattr(server.context.scene3d, "forget", viewed.append)
    assert server.client.delete(f"/api/runs/{home.run_id}").status_code == 204
    assert sorted(viewed) == sorted([home.run_id, whatif])
    assert not open_files_of(whatif)


def test_views_of_a_removed_video_are_closed(server: Server, home: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    viewed: list[str] = []
    monkeypatch.setattr(server.context.scene3d, "forget", viewed.append)
    assert server.client.delete(f"/api/videos/{home.video_id}").status_code == 204
    assert viewed == [home.run_id]


def open_files_of(run_id: str) -> list[str]:
    """Paths of the files in a run's folder that this process has open."""
    paths = [str(entry.readlink()) for entry in Path("/proc/self/fd").iterdir() if entry.is_symlink()]
    return [path for path in paths if run_id in path]


def test_the_start_of_a_server_removes_only_folders_of_removed_runs(server: Server, home: Any) -> None:
    context = server.context
    gone, working, strange = "a" * 32, "b" * 32, "c" * 32
    for name in (gone, working, strange, ".placing-d"):
        (context.settings.home / "runs" / name).mkdir()
    with context.database.write() as session:
        for subject in (gone, working, home.run_id):
            job = context.jobs.claim(session, context.jobs.submit(session, "whatif", subject).id)
            assert job is not None
            session.flush()
            if subject != working:
                context.jobs.finish(session, job.id, job.token, "failed", "The run is gone.")
    context.runs.sweep()
    left = {path.name for path in (context.settings.home / "runs").iterdir()}
    assert left == {working, strange, ".placing-d", home.run_id}


def test_leftover_folders_are_removed_at_start(server: Server) -> None:
    folder = server.context.settings.home / "runs" / ("a" * 32)
    folder.mkdir()
    with server.context.database.write() as session:
        server.context.jobs.submit(session, "whatif", folder.name).state = "done"
    with Server(server.context.settings.home).client:
        assert not folder.exists()
