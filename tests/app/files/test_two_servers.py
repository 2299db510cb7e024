"""Two servers on one PostgreSQL with shared files: each shows the other's data."""

from __future__ import annotations

import json
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from app.files import shared as shared_module
from app.files.shared import shared_files
from app.files.store import SharedFilesError, SharedStore
from app.settings import load_settings
from app.storage.models import Run, Video
from tests import toy_pipeline
from tests.app.databases import new_database
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server
from tests.attack.server_process import TOKEN, ServerProcess, start_server
from tests.waiting import time_limit, wait_until
from tsr_engine.errors import UsageError

pytestmark = pytest.mark.slow


@dataclass
class TwoServers:
    """Both servers; the first has a video with a run."""

    first: Server
    second: Server
    mounted: Path
    video: str
    run: str
    url: str

    def request(self, server: Server, path: str) -> tuple[int, Any]:
        answer = server.client.get(path)
        return answer.status_code, answer.json()


@pytest.fixture
def servers(tmp_path: Path, cluster: str) -> Iterator[TwoServers]:
    (tmp_path / "mounted").mkdir()
    url = new_database(cluster)
    both = {"database_url": url, "files": str(tmp_path / "mounted")}
    first, second = Server(tmp_path / "first", **both), Server(tmp_path / "second", **both)
    drive = toy_pipeline.write_drive(tmp_path / "drive.mp4", 12)
    with first.client, second.client:
        video = first.client.put("/api/uploads/drive.mp4", content=drive.read_bytes()).json()["id"]
        run_jobs(first.context)
        run = first.client.post(f"/api/videos/{video}/runs", json={"stop": 2}).json()["id"]
        run_jobs(first.context)
        assert first.client.get(f"/api/runs/{run}").json()["state"] == "complete"
        yield TwoServers(first, second, tmp_path / "mounted", video, run, url)


def wait_until_shared(servers: TwoServers) -> None:
    """Wait until all files of the first server are in the shared files."""
    wait_until(lambda: server_ids(servers) == {servers.first.context.database.shared}, time_limit(20))


def remove_uploads(home: Path) -> None:
    """Pretend that a server's uploads are on another machine by removing them here."""
    for path in (home / "uploads").iterdir():
        path.unlink()


def server_ids(servers: TwoServers) -> set[str | None]:
    with servers.first.context.database.read() as session:
        return {session.get_one(Video, servers.video).place, session.get_one(Run, servers.run).place}


def test_a_damaged_file_is_reported_and_can_be_added_again(servers: TwoServers) -> None:
    wait_until_shared(servers)
    thing = servers.mounted / "videos" / servers.video
    whole = thing.read_bytes()
    remove_uploads(servers.first.settings.home)
    thing.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    status, answer = servers.request(servers.second, f"/api/videos/{servers.video}/frames/0")
    assert (status, answer["error"]["code"]) == (503, "files_damaged")
    assert f"videos/{servers.video} in the shared files" in answer["error"]["message"]
    assert not (servers.second.settings.home / "videos" / servers.video).exists(), "nothing half right is kept"
    assert servers.request(servers.second, f"/api/runs/{servers.run}/tracks")[0] == 200, "the others are not touched"
    assert servers.second.client.put("/api/uploads/drive.mp4", content=whole).json()["id"] == servers.video
    wait_until_shared(servers)
    assert thing.read_bytes() == whole
    assert servers.first.client.get(f"/api/videos/{servers.video}/frames/0").status_code == 200


def test_local_copies_are_evicted_and_fetched_again(servers: TwoServers, monkeypatch: pytest.MonkeyPatch) -> None:
    wait_until_shared(servers)
    home, file_sync = servers.first.settings.home, servers.first.context.file_sync
    assert file_sync is not None
    wait_until(lambda: len(list((home / "fetched").glob("runs-*"))) == 1)
    file_sync.evict()
    assert (home / "runs" / servers.run).is_dir(), "within the bound"
    file_sync.cache_mb = 0
    file_sync.evict()
    assert (home / "runs" / servers.run).is_dir(), "it was used just now"
    monkeypatch.setattr(shared_module, "MIN_UNUSED_S", -1.0)
    monkeypatch.setattr("app.file_sync.MIN_UNUSED_S", -1.0)
    (servers.mounted / "runs" / servers.run / "run.json").rename(servers.mounted / "aside")
    file_sync.evict()
    assert (home / "runs" / servers.run).is_dir(), "it is the only one"
    (servers.mounted / "aside").rename(servers.mounted / "runs" / servers.run / "run.json")
    file_sync.evict()
    assert not (home / "runs" / servers.run).exists()
    assert list((home / "uploads").iterdir()) == []
    assert servers.request(servers.first, f"/api/runs/{servers.run}/tracks")[0] == 200
    assert servers.first.client.get(f"/api/videos/{servers.video}/frames/0").status_code == 200
    assert servers.first.client.delete(f"/api/videos/{servers.video}").status_code < 300
    wait_until(
        lambda: [path.name for path in servers.mounted.rglob("*") if path.is_file()] == ["store.id"], time_limit(10)
    )


def test_a_temporarily_missing_folder(servers: TwoServers, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.file_sync.RETRY_DELAY_S", 0.5)
    wait_until_shared(servers)
    servers.mounted.rename(servers.mounted.with_name("away"))
    status, answer = servers.request(servers.second, f"/api/runs/{servers.run}/tracks")
    assert (status, answer["error"]["code"]) == (503, "files_away"), answer
    assert servers.request(servers.first, f"/api/runs/{servers.run}/tracks")[0] == 200, "it lies here"
    more = servers.first.client.post(f"/api/videos/{servers.video}/runs", json={"stop": 1}).json()["id"]
    run_jobs(servers.first.context)
    file_sync = servers.first.context.file_sync
    assert file_sync is not None
    wait_until(lambda: file_sync.problem is not None, time_limit(15))
    assert "Finished files stay on this server until then." in str(file_sync.problem)
    assert servers.request(servers.first, f"/api/runs/{more}/tracks")[0] == 200
    assert servers.request(servers.second, f"/api/runs/{more}/tracks")[1]["error"]["code"] == "elsewhere"
    assert not servers.mounted.exists(), "nothing is written to where they are not mounted"
    servers.mounted.with_name("away").rename(servers.mounted)
    wait_until(lambda: servers.request(servers.second, f"/api/runs/{more}/tracks")[0] == 200, time_limit(15))


def test_a_slow_fetch_blocks_nobody(servers: TwoServers, monkeypatch: pytest.MonkeyPatch) -> None:
    wait_until_shared(servers)
    files = shared_files(servers.second.settings)
    assert files is not None
    monkeypatch.setattr(shared_module, "FETCH_TIMEOUT_S", 0.05)
    get = files.store.get

    def slow(*arguments: Any) -> None:
        time.sleep(1.0)
        get(*arguments)

    monkeypatch.setattr(files.store, "get", slow)
    status, answer = servers.request(servers.second, f"/api/runs/{servers.run}/tracks")
    assert (status, answer["error"]["code"]) == (503, "files_coming")
    assert servers.request(servers.second, "/api/videos")[0] == 200
    wait_until(lambda: servers.request(servers.second, f"/api/runs/{servers.run}/tracks")[0] == 200, time_limit(15))


def test_silent_shared_files_are_reported_while_a_copy_waits(
    servers: TwoServers, monkeypatch: pytest.MonkeyPatch
) -> None:
    wait_until_shared(servers)
    files, file_sync = shared_files(servers.second.settings), servers.first.context.file_sync
    assert files is not None
    assert file_sync is not None
    answers, put = threading.Event(), SharedStore.put

    def slow_put(*arguments: Any) -> Any:
        assert answers.wait(time_limit(60))
        return put(*arguments)

    def slow_get(*_: Any) -> None:
        assert answers.wait(time_limit(60))
        raise SharedFilesError("It is too late for this test.")

    def require_answer(_: SharedStore) -> None:
        if not answers.is_set():
            raise SharedFilesError("The shared files do not answer.", code="files_away")

    monkeypatch.setattr(shared_module, "FETCH_TIMEOUT_S", 0.05)
    monkeypatch.setattr(SharedStore, "require_answer", require_answer)
    monkeypatch.setattr(SharedStore, "get", slow_get)
    monkeypatch.setattr(SharedStore, "put", slow_put)
    status, answer = servers.request(servers.second, f"/api/runs/{servers.run}/tracks")
    assert (status, answer["error"]["code"]) == (503, "files_away")
    servers.first.client.post(f"/api/videos/{servers.video}/runs", json={"stop": 1})
    run_jobs(servers.first.context)
    wait_until(lambda: file_sync.problem is not None, time_limit(10))
    assert file_sync.problem == "The shared files do not answer. Finished files stay on this server until then."
    answers.set()
    wait_until(lambda: file_sync.problem is None, time_limit(10))


def test_a_server_without_the_shared_files_says_where_they_are(servers: TwoServers, tmp_path: Path) -> None:
    wait_until_shared(servers)
    third = Server(tmp_path / "third", database_url=servers.url)
    with third.client:
        status, answer = servers.request(third, f"/api/runs/{servers.run}/tracks")
        assert (status, answer["error"]["code"]) == (503, "elsewhere")
        assert answer["error"]["message"].endswith("Set TSR_FILES to them for this server.")
        assert third.client.delete(f"/api/videos/{servers.video}").status_code == 503
        refused = third.client.post(f"/api/videos/{servers.video}/runs", json={})
        assert (refused.status_code, refused.json()["error"]["code"]) == (503, "elsewhere")
        assert refused.json()["error"]["message"].startswith("The files of drive.mp4 are in shared files (")
        assert third.client.get("/api/run-queue").json()["runs"] == [], "no run waits for a server that has the files"


def test_shared_files_need_a_shared_database(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="are for servers that share a PostgreSQL"):
        load_settings(home=tmp_path, files=str(tmp_path))


def test_two_processes_and_s3(tmp_path: Path, cluster: str, bucket: str) -> None:
    """Added and run on one, reviewed and exported on the other, downloaded from the first."""
    drive = toy_pipeline.write_drive(tmp_path / "drive.mp4", 12)
    more = {"TSR_DATABASE_URL": new_database(cluster), "TSR_FILES": bucket, "TSR_WORKERS": "1"}
    with start_server(tmp_path / "a", more, forked=True) as a, start_server(tmp_path / "b", more, forked=True) as b:
        _, video = upload(a, drive)
        wait_until(lambda: a.request(f"/api/videos/{video['id']}")[1]["state"] == "ready", time_limit(60))
        run = a.request(f"/api/videos/{video['id']}/runs", b'{"stop": 2}', more=JSON)[1]["id"]
        wait_until(lambda: a.request(f"/api/runs/{run}")[1]["state"] == "complete", time_limit(60))
        wait_until(lambda: b.request(f"/api/runs/{run}/tracks")[0] == 200, time_limit(30))
        assert b.request(f"/api/runs/{run}/tracks")[1] == a.request(f"/api/runs/{run}/tracks")[1]
        wait_until(lambda: b.request(f"/api/videos/{video['id']}/table")[0] == 200, time_limit(30))
        wait_until(lambda: list((tmp_path / "a" / "fetched").glob("videos-*")), time_limit(30))
        remove_uploads(tmp_path / "a")
        assert len(raw(b, f"/api/videos/{video['id']}/frames/0")) > 100
        assert len(raw(b, f"/api/videos/{video['id']}/thumbnail")) > 100
        box = {"name": "create_track", "frame": 1, "key": "h1234567", "box": [1, 1, 20, 20]}
        edit = json.dumps({"op_id": "op-00000001", "author": "ada", "command": box}).encode()
        assert b.request(f"/api/runs/{run}/edits", edit, more=JSON)[0] == 200
        asked = f'{{"runs": ["{run}"], "format": "mot"}}'.encode()
        made = b.request("/api/exports", asked, more=JSON)[1]["id"]
        wait_until(lambda: b.request(f"/api/outputs/{made}")[1]["state"] == "complete", time_limit(60))
        wait_until(lambda: "error" not in str(status(a, f"/api/outputs/{made}/download")), time_limit(30))
        assert raw(a, f"/api/outputs/{made}/download") == raw(b, f"/api/outputs/{made}/download")


JSON = {"Content-Type": "application/json"}


def upload(server: ServerProcess, path: Path) -> tuple[int, Any]:
    request = urllib.request.Request(f"{server.base}/api/uploads/{path.name}", data=path.read_bytes(), method="PUT")
    request.add_header("Authorization", f"Bearer {TOKEN}")
    with urllib.request.urlopen(request) as answer:
        return answer.status, json.load(answer)


def raw(server: ServerProcess, path: str) -> bytes:
    request = urllib.request.Request(f"{server.base}{path}", headers={"Authorization": f"Bearer {TOKEN}"})
    with urllib.request.urlopen(request) as answer:
        return answer.read()


def status(server: ServerProcess, path: str) -> object:
    try:
        return len(raw(server, path))
    except urllib.error.HTTPError as error:
        return f"error {error.code}"
