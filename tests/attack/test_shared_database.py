"""Two servers on one PostgreSQL share rows, not files: each names the server that has the files."""

from __future__ import annotations

import shutil
import socket
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from sqlalchemy import text, update

from app.jobs.outcome import notify_subject
from app.storage import servers
from app.storage.database import Database
from app.storage.id_lock import IdLock
from app.storage.models import Job, Run, Video
from app.storage.models import Server as ServerRow
from app.storage.servers import Servers, assign_local_files
from tests import toy_pipeline
from tests.app.databases import new_database
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server
from tests.waiting import wait_until
from tsr_engine.errors import StorageError


@dataclass
class TwoServers:
    """Both servers; the first has a video with a run."""

    first: Server
    second: Server
    video: str
    run: str
    path: Path


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory, cluster: str) -> Iterator[TwoServers]:
    """A drive that the first server has tracked; both servers run."""
    folder = tmp_path_factory.mktemp("two")
    drive = toy_pipeline.write_drive(folder / "drive.mp4", 12)
    url = new_database(cluster)
    first = Server(folder / "first", roots=(folder,), database_url=url)
    second = Server(folder / "second", roots=(folder,), database_url=url)
    with first.client, second.client:
        video = first.client.post("/api/videos", json={"path": str(drive)}).json()["id"]
        run_jobs(first.context)
        run = first.client.post(f"/api/videos/{video}/runs", json={"stop": 2}).json()["id"]
        run_jobs(first.context)
        assert first.client.get(f"/api/runs/{run}").json()["state"] == "complete"
        yield TwoServers(first, second, video, run, drive)


def edit(op: str) -> dict[str, Any]:
    box = {"name": "create_track", "frame": 1, "key": "h" + op[-8:], "box": [1, 1, 20, 20]}
    return {"op_id": op, "author": "ada", "command": box}


def test_files_of_the_other_server_are_answered_with_503_and_its_name(two: TwoServers) -> None:
    run, video, client = f"/api/runs/{two.run}", f"/api/videos/{two.video}", two.second.client
    request = {
        "tracks": client.get(f"{run}/tracks"),
        "lanes": client.get(f"{run}/lanes"),
        "overlays": client.get(f"{run}/overlays", params={"first": 0, "last": 1}),
        "frame": client.get(f"{video}/frames/0"),
        "thumbnail": client.get(f"{video}/thumbnail"),
        "edit": client.post(f"{run}/edits", json=edit("op-00000001")),
        "export": client.post("/api/exports", json={"runs": [two.run], "format": "mot"}),
        "recording": client.post(f"{run}/recordings", json={"first": 0, "stop": 2}),
        "whatif": client.post(f"{run}/whatif", json={"parameters": {"tau": 20}}),
        "remove run": client.delete(run),
        "remove video": client.delete(video),
        "add": client.post("/api/videos", json={"path": str(two.path)}),
        "upload": client.put("/api/uploads/same.mp4", content=two.path.read_bytes()),
        "import": client.post(f"{video}/imports", content=b"x", params={"name": "a.csv", "as": "truth"}),
    }
    for what, answer in request.items():
        if answer.status_code == 404 and "There is no" not in answer.text:
            pytest.fail(f"{what}: no such route")
        body = answer.json()["error"]
        assert (answer.status_code, body["code"]) == (503, "elsewhere"), (what, answer.text)
        assert body["details"]["server"] == two.first.context.database.server, what
        assert str(two.first.settings.home) in body["message"], what
        assert answer.headers["retry-after"], what
    assert list((two.second.settings.home / "uploads").glob("*")) == []
    # the same edit, sent to the server that has the files
    assert two.first.client.post(f"{run}/edits", json=edit("op-00000001")).status_code == 200
    # data in the database is the same on both
    assert [v["id"] for v in client.get("/api/videos").json()["videos"]] == [two.video]
    assert not client.get(video).json()["missing"]
    assert client.get(f"{run}/annotation").json()["seq"] == two.first.client.get(f"{run}/annotation").json()["seq"] > 0
    assert client.get(f"{video}/table").status_code == 200


def test_jobs_run_on_the_server_that_has_the_files(two: TwoServers) -> None:
    run = two.second.client.post(f"/api/videos/{two.video}/runs", json={"stop": 1}).json()["id"]
    run_jobs(two.second.context)
    waiting = two.second.client.get(f"/api/runs/{run}").json()
    first = f"{socket.gethostname()}:{two.first.settings.home}"
    assert (waiting["state"], waiting["note"]) == ("queued", f"the server {first} has the video")
    two.second.client.post(f"/api/runs/{run}/cancel")
    assert two.second.client.post(f"/api/runs/{run}/resume").json()["note"] == waiting["note"]
    with two.second.context.database.write() as session:
        job = session.query(Job).filter(Job.subject == run, Job.state == "queued").one()
        notify_subject(session, two.second.context.jobs, job, "queued", None)  # as for a worker that has died there
        assert session.get_one(Run, run).note == waiting["note"]
        assert two.second.context.jobs.claim(session, job.id) is None, "not even by its name"
    run_jobs(two.first.context)
    assert two.second.client.get(f"/api/runs/{run}").json()["state"] == "complete"
    assert two.first.client.get(f"/api/runs/{run}/tracks").status_code == 200
    made = two.first.client.post("/api/exports", json={"runs": [run], "format": "mot"}).json()
    run_jobs(two.second.context)
    assert two.first.client.get(f"/api/outputs/{made['id']}").json()["state"] == "queued"
    run_jobs(two.first.context)
    assert two.first.client.get(f"/api/outputs/{made['id']}/download").status_code == 200
    away = two.second.client.get(f"/api/outputs/{made['id']}/download")
    assert (away.status_code, away.json()["error"]["code"]) == (503, "elsewhere")


def test_a_video_of_a_lost_server_can_be_added_again(two: TwoServers, monkeypatch: pytest.MonkeyPatch) -> None:
    other = toy_pipeline.write_drive(two.path.with_name("other.mp4"), 6)
    video = two.first.client.post("/api/videos", json={"path": str(other)}).json()["id"]
    run_jobs(two.first.context)
    assert two.second.client.post("/api/videos", json={"path": str(other)}).status_code == 503
    monkeypatch.setattr(Servers, "heartbeat_timeout", -1.0)
    assert two.second.client.post("/api/videos", json={"path": str(other)}).json()["id"] == video
    assert two.second.client.get(f"/api/videos/{video}/frames/0").status_code == 200
    monkeypatch.undo()
    assert two.first.client.get(f"/api/videos/{video}/frames/0").status_code == 503


def test_a_server_with_a_recent_heartbeat_is_not_lost(two: TwoServers, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    # not of the module `time` itself: the event loops of other servers in this process would sleep for hours
    monkeypatch.setattr(servers, "time", SimpleNamespace(monotonic=lambda: now))
    one, other = (Servers(s.context.database, s.settings.home) for s in (two.first, two.second))
    here = two.first.context.database.server
    assert other.is_dead(here), "never seen"
    for _ in range(3):
        one.beat()
        other.beat()
        now += 0.9 * Servers.heartbeat_timeout
        assert not other.is_dead(here)
    other.beat()
    now += 0.2 * Servers.heartbeat_timeout
    assert other.is_dead(here)


def test_rows_of_an_older_version_belong_to_the_server_with_the_files(two: TwoServers) -> None:
    database = two.second.context.database
    with database.write() as session:
        session.execute(update(Run).where(Run.id == two.run).values(place=None))
        session.execute(update(Video).where(Video.id == two.video).values(place=None))
        shown = session.get(ServerRow, two.first.context.database.server)
        assert shown is not None
    moved = two.path.rename(two.path.with_name("moved.mp4"))
    assign_local_files(database, two.second.settings.home)
    moved.rename(two.path)
    with database.read() as session:
        assert (session.get_one(Run, two.run).place, session.get_one(Video, two.video).place) == (None, None)
    assign_local_files(two.first.context.database, two.first.settings.home)
    assert two.second.client.get(f"/api/runs/{two.run}/tracks").status_code == 503
    assert two.first.client.get(f"/api/runs/{two.run}/tracks").status_code == 200


def test_on_sqlite_all_files_are_local(tmp_path: Path) -> None:
    """A copied library is complete, with or without its id."""
    drive = toy_pipeline.write_drive(tmp_path / "drive.mp4", 4)
    first = Server(tmp_path / "home", roots=(tmp_path,))
    with first.client:
        video = first.client.post("/api/videos", json={"path": str(drive)}).json()["id"]
        run_jobs(first.context)
    shutil.copytree(tmp_path / "home", tmp_path / "copy")
    (tmp_path / "copy" / "server.id").write_text("f" * 32)
    second = Server(tmp_path / "copy", roots=(tmp_path,))
    with second.client:
        assert second.client.get(f"/api/videos/{video}/frames/0").status_code == 200


def test_a_copied_data_folder_does_not_start_beside_the_original(tmp_path: Path, cluster: str) -> None:
    url = new_database(cluster)
    first = Server(tmp_path / "home", database_url=url)
    with first.client:
        first.context.servers.beat()
        shutil.copytree(tmp_path / "home", tmp_path / "copy")
        with pytest.raises(StorageError, match=r"is a copy of the other.*Delete server.id in the copy") as refused:
            Server(tmp_path / "copy", database_url=url)
        assert str(tmp_path / "home") in str(refused.value)
        (tmp_path / "copy" / "server.id").unlink()
        with Server(tmp_path / "copy", database_url=url).client as other:
            assert other.get("/api/videos").status_code == 200
    with Server(tmp_path / "home", database_url=url).client as again:
        assert again.get("/api/videos").status_code == 200


@pytest.mark.parametrize(("delay", "is_reported"), [(60.0, False), (0.0, True)])
def test_a_lost_connection_of_its_own_is_not_another_server(
    tmp_path: Path,
    cluster: str,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    delay: float,
    is_reported: bool,
) -> None:
    """After an outage of the network the database takes half a minute to end the connection that holds the id."""
    refused: list[bool] = []
    taken = SimpleNamespace(ensure=lambda: refused.append(True))
    monkeypatch.setattr("app.storage.servers.IdLock", lambda _: taken)
    monkeypatch.setattr(Servers, "heartbeat_interval", 0.05)
    monkeypatch.setattr(Servers, "refusal_delay", delay)
    database = Database(new_database(cluster), "0" * 32)
    with Servers(database, tmp_path).heartbeat():
        wait_until(lambda: len(refused) > 2)
    assert ("Another server uses the id" in caplog.text) is is_reported
    database.close()


def test_the_id_is_locked_again_after_the_database_has_restarted(tmp_path: Path, cluster: str) -> None:
    url = new_database(cluster)
    one, other = Database(url, "0" * 32), Database(url, "0" * 32)
    one.migrate()
    held, wanted = IdLock(one), IdLock(other)
    held.acquire()
    assert held.ensure()
    assert not wanted.ensure()
    with other.engine.connect() as connection:
        here = "(SELECT oid FROM pg_database WHERE datname = current_database())"
        cut = f"SELECT pg_terminate_backend(pid) FROM pg_locks WHERE locktype = 'advisory' AND database = {here}"
        connection.execute(text(cut))
    wait_until(held.ensure)
    assert not wanted.ensure()
    held.release()
    wait_until(wanted.ensure)
    for lock, database in ((held, one), (wanted, other)):
        lock.release()
        database.close()
