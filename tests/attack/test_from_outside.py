"""The eleven findings (F1 to F11) over HTTP, against the server version in ``TSR_TREE``.

``TSR_TREE=. pytest tests/attack/test_from_outside.py`` tests this version; each test fails on a checkout of 41599b6.
They take minutes together, so only ``make attack`` runs them; other modules test the fixes piece by piece.
"""

from __future__ import annotations

import hashlib
import json
import os
import resource
import shutil
import signal
import socket
import sqlite3
import subprocess
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest

from tests import toy_pipeline
from tests.app.databases import Cluster, new_database, running_cluster
from tests.attack.many_tracks import MAX_MEMORY_MB, mot_archive
from tests.attack.server_process import TOKEN, TREE, ServerProcess, start_server
from tests.attack.test_bundles import FORGED, forge, rewritten
from tests.attack.test_swapped_files import BLACK, WHITE, exchange, write_video
from tests.waiting import time_limit, wait_until

pytestmark = pytest.mark.skipif("TSR_TREE" not in os.environ, reason="TSR_TREE names no version to attack")
WORKERS = {"TSR_WORKERS": "1"}
JSON = {"Content-Type": "application/json"}


@pytest.fixture(scope="module")
def own_cluster() -> Iterator[Cluster]:
    """A PostgreSQL that a test may stop."""
    with running_cluster() as made:
        yield made


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder that videos may be added from."""
    (tmp_path / "videos").mkdir()
    return tmp_path / "videos"


def post(server: ServerProcess, path: str, /, **body: Any) -> tuple[int, Any]:
    return server.request(path, json.dumps(body).encode(), more=JSON)


def environment(folder: Path, **more: str) -> dict[str, str]:
    return {"TSR_ROOTS": str(folder), **WORKERS, **more}


def add_video(server: ServerProcess, path: Path) -> str:
    """Add a video; returns its id once it is ready."""
    status, said = post(server, "/api/videos", path=str(path))
    assert status == 201, said
    wait_until(lambda: server.request(f"/api/videos/{said['id']}")[1]["state"] == "ready")
    return str(said["id"])


def start_run(server: ServerProcess, video: str, **wanted: Any) -> str:
    status, said = post(server, f"/api/videos/{video}/runs", **wanted)
    assert status in (201, 202), said
    return str(said["id"])


def get_run(server: ServerProcess, run: str) -> Any:
    return server.request(f"/api/runs/{run}")[1]


def wait_for_run(server: ServerProcess, run: str) -> Any:
    """Wait until a run has ended; returns it."""

    def found() -> Any:
        told = get_run(server, run)
        return None if told["state"] in ("queued", "running") else told

    return wait_until(found, time_limit(90))


def test_f1_a_swapped_link_gives_no_access(tmp_path: Path, folder: Path) -> None:
    outside = write_video(tmp_path / "outside.mp4", BLACK)
    inside, link = write_video(folder / "drive.mp4", WHITE), folder / "link"
    link.symlink_to(outside)
    over = threading.Event()

    def flicker() -> None:
        while not over.is_set():
            exchange(inside, link)

    thread = threading.Thread(target=flicker)
    with start_server(tmp_path / "home", environment(folder)) as server:
        thread.start()
        try:
            for _ in range(600):
                post(server, "/api/videos", path=str(inside))
        finally:
            over.set()
            thread.join()
        let_in = {video["id"] for video in server.request("/api/videos")[1]["videos"]}
    assert hashlib.sha256(outside.read_bytes()).hexdigest() not in let_in


def test_f2_a_server_with_the_same_name_does_not_fail_running_jobs(
    tmp_path: Path, folder: Path, own_cluster: Cluster
) -> None:
    """Two containers: each has the other's host name, and a data folder of the same name."""
    if os.geteuid() != 0 or shutil.which("unshare") is None:
        pytest.skip("only root can make the same folder be another one")
    drive = toy_pipeline.write_drive(folder / "drive.mp4", 900)
    home, other = tmp_path / "home", tmp_path / "other"
    other.mkdir()
    more = environment(folder, TSR_DATABASE_URL=new_database(own_cluster.url))
    with start_server(home, more) as server:
        run = start_run(server, add_video(server, drive))
        wait_until(lambda: get_run(server, run)["state"] == "running")
        (tmp_path / "port").mkdir()
        script = f'mount --bind {other} {home} && exec "$@"'
        command = ["unshare", "-m", "sh", "-c", script, "twin"]
        twin = subprocess.Popen(
            [*command, *server.process.args],  # type: ignore[misc]
            env={**os.environ, "TSR_TOKEN": TOKEN, "TSR_SAMPLE": "false", **more},
            cwd=TREE,
        )
        try:
            wait_until((other / "server.json").exists, time_limit(60))
            found = wait_for_run(server, run)
        finally:
            twin.terminate()
            twin.wait()
    assert (found["state"], found["error"]) == ("complete", None)


def test_f3_a_small_archive_of_very_many_tracks_blocks_nobody(tmp_path: Path, folder: Path) -> None:
    drive = toy_pipeline.write_drive(folder / "drive.mp4", 75)
    with start_server(tmp_path / "home", environment(folder)) as server:
        video = add_video(server, drive)
        began = time.monotonic()
        with server.monitored():
            server.request(
                f"/api/videos/{video}/imports?as=truth&file=a.zip&name=a.zip", mot_archive(100_000), timeout=600
            )
        took = time.monotonic() - began
    assert server.memory < MAX_MEMORY_MB
    assert max(server.waits) < time_limit(0.5)
    assert took < time_limit(3)


def test_f4_the_database_lies_in_the_home_whatever_its_name(tmp_path: Path) -> None:
    for name in ("what?", "a%20b"):
        with start_server(tmp_path / name) as server:
            assert server.request("/api/videos")[0] == 200
        assert (tmp_path / name / "tsr.sqlite").is_file()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a%20b", "what?"]


def test_f5_half_open_connections_block_nobody(tmp_path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    held: list[socket.socket] = []
    with start_server(tmp_path / "home", before=["prlimit", "--nofile=1024:1024"]) as server:
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, hard), hard))
        try:
            port = int(server.base.rpartition(":")[2])
            for _ in range(1100):
                one = socket.create_connection(("127.0.0.1", port), timeout=time_limit(5))
                one.sendall(b"GET / HTTP/1.1\r\n")
                held.append(one)
            time.sleep(1)
            with suppress(OSError):
                assert server.request("/api/videos", timeout=time_limit(2))[0] == 200
                return
            pytest.fail("nobody else gets in")
        finally:
            for one in held:
                one.close()
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_f6_an_endless_view_in_a_bundle_ends_at_once(tmp_path: Path, folder: Path) -> None:
    drive = toy_pipeline.write_drive(folder / "drive.mp4", 40)
    with start_server(tmp_path / "home", environment(folder)) as server:
        run = start_run(server, add_video(server, drive))
        assert wait_for_run(server, run)["state"] == "complete"
        status, made = post(server, f"/api/runs/{run}/bundles", first=2, stop=12)
        assert status == 202, made
        for path in ("outputs", "artefacts"):  # the second is a former name
            if server.request(f"/api/{path}/{made['id']}")[0] == 200:
                break
        wait_until(lambda: server.request(f"/api/{path}/{made['id']}")[1]["state"] == "complete")
        found = next((tmp_path / "home").rglob("bundle.zip"))
        forged = rewritten(found, tmp_path / "forged.zip", forge(FORGED["an endless view"]))
        try:
            status, answer = server.request("/api/bundles?name=forged.zip", forged.read_bytes(), timeout=time_limit(5))
        except OSError:
            pytest.fail("it is looked at without end")
    assert status == 422, answer


def test_f7_a_server_without_the_files_says_so(tmp_path: Path, folder: Path, own_cluster: Cluster) -> None:
    drive = toy_pipeline.write_drive(folder / "drive.mp4", 12)
    more = environment(folder, TSR_DATABASE_URL=new_database(own_cluster.url))
    with start_server(tmp_path / "one", more) as one, start_server(tmp_path / "two", more) as two:
        run = start_run(one, add_video(one, drive), stop=4)
        assert wait_for_run(one, run)["state"] == "complete"
        status, answer = two.request(f"/api/runs/{run}/tracks")
    assert (status, answer["error"]["code"] if "error" in answer else answer) == (503, "elsewhere")


def test_f8_a_file_overwritten_in_place_is_reported_as_changed(tmp_path: Path, folder: Path) -> None:
    path = write_video(folder / "drive.mp4", WHITE)
    with start_server(tmp_path / "home", environment(folder)) as server:
        video = add_video(server, path)
        status, _ = picture(server, video)
        assert status == 200
        before, black = path.stat(), write_video(tmp_path / "black.mp4", BLACK).read_bytes()
        with path.open("r+b") as file:
            file.write(black[: before.st_size].ljust(before.st_size, b"\0"))
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
        assert (path.stat().st_size, path.stat().st_mtime_ns) == (before.st_size, before.st_mtime_ns)
        status, said = picture(server, video)
    assert status == 409, "another picture is shown as this video's"
    assert json.loads(said)["error"]["code"] == "file_changed"


def picture(server: ServerProcess, video: str) -> tuple[int, bytes]:
    request = urllib.request.Request(
        f"{server.base}/api/videos/{video}/frames/3", headers={"Authorization": f"Bearer {TOKEN}"}
    )
    try:
        with urllib.request.urlopen(request, timeout=60) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()


def test_f9_a_database_restart_is_reported_and_costs_no_work(
    tmp_path: Path, folder: Path, own_cluster: Cluster
) -> None:
    drive = toy_pipeline.write_drive(folder / "drive.mp4", 400)
    with start_server(tmp_path / "home", environment(folder, TSR_DATABASE_URL=new_database(own_cluster.url))) as server:
        run = start_run(server, add_video(server, drive))
        wait_until(lambda: get_run(server, run)["state"] == "running")
        for mode in ("fast", "immediate", "immediate", "immediate"):
            own_cluster.stop(mode)
            try:
                answers = [server.request("/api/videos", timeout=60)[0] for _ in range(3)]
                time.sleep(1)
            finally:
                own_cluster.start()
            assert answers == [503] * 3
            wait_until(lambda: server.request("/api/videos")[0] == 200)
        found = wait_for_run(server, run)
    assert (found["state"], found["error"]) == ("complete", None)


def test_f10_kills_from_outside_are_not_failures(tmp_path: Path, folder: Path) -> None:
    """The process of an export dies four times; neither the file nor memory is blamed."""
    drive, home = toy_pipeline.write_drive(folder / "drive.mp4", 1000), tmp_path / "home"
    with start_server(home, environment(folder)) as server:
        run = start_run(server, add_video(server, drive), stop=60)
        assert wait_for_run(server, run)["state"] == "complete"
        request = {"format": "coco", "pictures": "all", "runs": [run], "states": ["open", "accepted"]}
        status, export = post(server, "/api/exports", **request)
        assert status == 202, export
        seen = set[int]()

        def job() -> tuple[str, str, str | None]:
            with closing(sqlite3.connect(home / "tsr.sqlite")) as database:
                row = database.execute("SELECT id, state, error FROM jobs WHERE subject = ?", (export["id"],))
                return row.fetchone()  # type: ignore[no-any-return]

        def worker() -> int | None:
            name, state, _ = job()
            if state == "running":
                with suppress(OSError, ValueError):
                    number = int((home / "locks" / f"{name}.lock").read_text())
                    return number if number not in seen else None
            return -1 if state in ("done", "failed") else None

        for _ in range(4):
            if (number := wait_until(worker)) == -1:
                break
            time.sleep(0.3)
            seen.add(number)
            os.kill(number, signal.SIGKILL)
        assert len(seen) >= 3, "the export was over before it could be killed"
        wait_until(lambda: job()[1] not in ("queued", "running"), time_limit(120))
        assert job()[1:] == ("done", None)


@pytest.mark.parametrize("kind", ["two lengths", "bare LF"])
def test_f11_ambiguous_requests_are_refused(tmp_path: Path, kind: str) -> None:
    head = f"POST /api/session/links HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {TOKEN}\r\n".encode()
    if kind == "two lengths":
        request = head + b"Content-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"
    else:
        request = head.replace(b"\r\n", b"\n") + b"Content-Length: 0\n\n"
    with start_server(tmp_path / "home") as server:
        port = int(server.base.rpartition(":")[2])
        with socket.create_connection(("127.0.0.1", port), timeout=time_limit(5)) as one:
            one.sendall(request)
            answer = one.recv(65536)
    assert answer.startswith(b"HTTP/1.1 400 "), answer[:60]
