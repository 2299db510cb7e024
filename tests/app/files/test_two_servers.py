"""Two servers on one PostgreSQL with shared files: each shows the other's data."""

from __future__ import annotations

import json
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
from app.settings import load_settings
from app.storage.models import Run, Video
from tests import pipeline_toys as toys
from tests.app.databases import new_database
from tests.app.import_now import work_off
from tests.app.toy_server import Server
from tests.attack.own_server import TOKEN, Running, running
from tests.patience import until, within
from tsr_engine.errors import UsageError

pytestmark = pytest.mark.slow


@dataclass
class Two:
    """Both servers; the first has a video with a run."""

    first: Server
    second: Server
    mounted: Path
    video: str
    run: str
    url: str

    def ask(self, server: Server, path: str) -> tuple[int, Any]:
        answer = server.client.get(path)
        return answer.status_code, answer.json()


@pytest.fixture
def two(tmp_path: Path, cluster: str) -> Iterator[Two]:
    (tmp_path / "mounted").mkdir()
    url = new_database(cluster)
    both = {"database_url": url, "files": str(tmp_path / "mounted")}
    first, second = Server(tmp_path / "first", **both), Server(tmp_path / "second", **both)
    drive = toys.write_drive(tmp_path / "drive.mp4", 12)
    with first.client, second.client:
        video = first.client.put("/api/uploads/drive.mp4", content=drive.read_bytes()).json()["id"]
        work_off(first.context)
        run = first.client.post(f"/api/videos/{video}/runs", json={"stop": 2}).json()["id"]
        work_off(first.context)
        assert first.client.get(f"/api/runs/{run}").json()["state"] == "complete"
        yield Two(first, second, tmp_path / "mounted", video, run, url)


def sent(two: Two) -> None:
    """Wait until all files of the first server are in the shared files."""
    until(lambda: places(two) == {two.first.context.database.shared}, within(20))


def apart(home: Path) -> None:
    """Pretend that a server's uploads are on another machine by removing them here."""
    for path in (home / "uploads").iterdir():
        path.unlink()


def places(two: Two) -> set[str | None]:
    with two.first.context.database.read() as session:
        return {session.get_one(Video, two.video).place, session.get_one(Run, two.run).place}


def test_a_damaged_file_is_reported_and_can_be_added_again(two: Two) -> None:
    sent(two)
    thing = two.mounted / "videos" / two.video
    whole = thing.read_bytes()
    apart(two.first.settings.home)
    thing.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    status, answer = two.ask(two.second, f"/api/videos/{two.video}/frames/0")
    assert (status, answer["error"]["code"]) == (503, "files_damaged")
    assert f"videos/{two.video} in the shared files" in answer["error"]["message"]
    assert not (two.second.settings.home / "videos" / two.video).exists(), "nothing half right is kept"
    assert two.ask(two.second, f"/api/runs/{two.run}/tracks")[0] == 200, "the others are not touched"
    assert two.second.client.put("/api/uploads/drive.mp4", content=whole).json()["id"] == two.video
    sent(two)
    assert thing.read_bytes() == whole
    assert two.first.client.get(f"/api/videos/{two.video}/frames/0").status_code == 200


def test_local_copies_are_evicted_and_fetched_again(two: Two, monkeypatch: pytest.MonkeyPatch) -> None:
    sent(two)
    home, sending = two.first.settings.home, two.first.context.sending
    assert sending is not None
    until(lambda: len(list((home / "fetched").glob("runs-*"))) == 1)
    sending.tidy()
    assert (home / "runs" / two.run).is_dir(), "within the bound"
    sending.cache_mb = 0
    sending.tidy()
    assert (home / "runs" / two.run).is_dir(), "it was used just now"
    monkeypatch.setattr(shared_module, "UNUSED", -1.0)
    monkeypatch.setattr("app.sending.UNUSED", -1.0)
    (two.mounted / "runs" / two.run / "run.json").rename(two.mounted / "aside")
    sending.tidy()
    assert (home / "runs" / two.run).is_dir(), "it is the only one"
    (two.mounted / "aside").rename(two.mounted / "runs" / two.run / "run.json")
    sending.tidy()
    assert not (home / "runs" / two.run).exists()
    assert list((home / "uploads").iterdir()) == []
    assert two.ask(two.first, f"/api/runs/{two.run}/tracks")[0] == 200
    assert two.first.client.get(f"/api/videos/{two.video}/frames/0").status_code == 200
    assert two.first.client.delete(f"/api/videos/{two.video}").status_code < 300
    until(lambda: [path.name for path in two.mounted.rglob("*") if path.is_file()] == ["store.id"], within(10))


def test_a_temporarily_missing_folder(two: Two, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.sending.AGAIN", 0.5)
    sent(two)
    two.mounted.rename(two.mounted.with_name("away"))
    status, answer = two.ask(two.second, f"/api/runs/{two.run}/tracks")
    assert (status, answer["error"]["code"]) == (503, "files_away"), answer
    assert two.ask(two.first, f"/api/runs/{two.run}/tracks")[0] == 200, "it lies here"
    more = two.first.client.post(f"/api/videos/{two.video}/runs", json={"stop": 1}).json()["id"]
    work_off(two.first.context)
    sending = two.first.context.sending
    assert sending is not None
    until(lambda: sending.trouble is not None, within(15))
    assert "Finished files stay on this server until then." in str(sending.trouble)
    assert two.ask(two.first, f"/api/runs/{more}/tracks")[0] == 200
    assert two.ask(two.second, f"/api/runs/{more}/tracks")[1]["error"]["code"] == "elsewhere"
    assert not two.mounted.exists(), "nothing is written to where they are not mounted"
    two.mounted.with_name("away").rename(two.mounted)
    until(lambda: two.ask(two.second, f"/api/runs/{more}/tracks")[0] == 200, within(15))


def test_a_slow_fetch_blocks_nobody(two: Two, monkeypatch: pytest.MonkeyPatch) -> None:
    sent(two)
    files = shared_files(two.second.settings)
    assert files is not None
    monkeypatch.setattr(shared_module, "PATIENCE", 0.05)
    get = files.store.get

    def slow(*arguments: Any) -> None:
        time.sleep(1.0)
        get(*arguments)

    monkeypatch.setattr(files.store, "get", slow)
    status, answer = two.ask(two.second, f"/api/runs/{two.run}/tracks")
    assert (status, answer["error"]["code"]) == (503, "files_coming")
    assert two.ask(two.second, "/api/videos")[0] == 200
    until(lambda: two.ask(two.second, f"/api/runs/{two.run}/tracks")[0] == 200, within(15))


def test_a_server_without_the_shared_files_says_where_they_are(two: Two, tmp_path: Path) -> None:
    sent(two)
    third = Server(tmp_path / "third", database_url=two.url)
    with third.client:
        status, answer = two.ask(third, f"/api/runs/{two.run}/tracks")
        assert (status, answer["error"]["code"]) == (503, "elsewhere")
        assert answer["error"]["message"].endswith("Set TSR_FILES to them for this server.")
        assert third.client.delete(f"/api/videos/{two.video}").status_code == 503
        refused = third.client.post(f"/api/videos/{two.video}/runs", json={})
        assert (refused.status_code, refused.json()["error"]["code"]) == (503, "elsewhere")
        assert refused.json()["error"]["message"].startswith("The files of drive.mp4 are in shared files (")
        assert third.client.get("/api/run-queue").json()["runs"] == [], "no run waits for a server that has the files"


def test_shared_files_need_a_shared_database(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="are for servers that share a PostgreSQL"):
        load_settings(home=tmp_path, files=str(tmp_path))


def test_two_processes_and_s3(tmp_path: Path, cluster: str, bucket: str) -> None:
    """Added and run on one, reviewed and exported on the other, downloaded from the first."""
    drive = toys.write_drive(tmp_path / "drive.mp4", 12)
    more = {"TSR_DATABASE_URL": new_database(cluster), "TSR_FILES": bucket, "TSR_WORKERS": "1"}
    with running(tmp_path / "a", more, forked=True) as a, running(tmp_path / "b", more, forked=True) as b:
        _, video = upload(a, drive)
        until(lambda: a.ask(f"/api/videos/{video['id']}")[1]["state"] == "ready", within(60))
        run = a.ask(f"/api/videos/{video['id']}/runs", b'{"stop": 2}', more=JSON)[1]["id"]
        until(lambda: a.ask(f"/api/runs/{run}")[1]["state"] == "complete", within(60))
        until(lambda: b.ask(f"/api/runs/{run}/tracks")[0] == 200, within(30))
        assert b.ask(f"/api/runs/{run}/tracks")[1] == a.ask(f"/api/runs/{run}/tracks")[1]
        until(lambda: b.ask(f"/api/videos/{video['id']}/table")[0] == 200, within(30))
        until(lambda: list((tmp_path / "a" / "fetched").glob("videos-*")), within(30))
        apart(tmp_path / "a")
        assert len(raw(b, f"/api/videos/{video['id']}/frames/0")) > 100
        assert len(raw(b, f"/api/videos/{video['id']}/thumbnail")) > 100
        box = {"name": "create_track", "frame": 1, "key": "h1234567", "box": [1, 1, 20, 20]}
        edit = json.dumps({"op_id": "op-00000001", "author": "ada", "command": box}).encode()
        assert b.ask(f"/api/runs/{run}/edits", edit, more=JSON)[0] == 200
        asked = f'{{"runs": ["{run}"], "format": "mot"}}'.encode()
        made = b.ask("/api/exports", asked, more=JSON)[1]["id"]
        until(lambda: b.ask(f"/api/outputs/{made}")[1]["state"] == "complete", within(60))
        until(lambda: "error" not in str(status(a, f"/api/outputs/{made}/download")), within(30))
        assert raw(a, f"/api/outputs/{made}/download") == raw(b, f"/api/outputs/{made}/download")


JSON = {"Content-Type": "application/json"}


def upload(server: Running, path: Path) -> tuple[int, Any]:
    request = urllib.request.Request(f"{server.base}/api/uploads/{path.name}", data=path.read_bytes(), method="PUT")
    request.add_header("Authorization", f"Bearer {TOKEN}")
    with urllib.request.urlopen(request) as answer:
        return answer.status, json.load(answer)


def raw(server: Running, path: str) -> bytes:
    request = urllib.request.Request(f"{server.base}{path}", headers={"Authorization": f"Bearer {TOKEN}"})
    with urllib.request.urlopen(request) as answer:
        return answer.read()


def status(server: Running, path: str) -> object:
    try:
        return len(raw(server, path))
    except urllib.error.HTTPError as error:
        return f"error {error.code}"
