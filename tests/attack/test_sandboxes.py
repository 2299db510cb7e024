"""Permissions and ends of processes that read untrusted bytes."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from app.sandbox.channel import Channel
from app.sandbox.limits import Limits
from app.sandbox.sandboxes import SandboxError, Sandboxes, SandboxesClosed
from tests.waiting import time_limit, wait_until
from tsr_engine.errors import ImportFormatError

FREE = Limits(2048)
MODULE = "tests.attack.test_sandboxes:"


@pytest.fixture
def sandboxes() -> Iterator[Sandboxes]:
    """Sandboxes of a server that stops with the test."""
    made = Sandboxes()
    yield made
    made.close()


def take(_: Channel, megabytes: int) -> int:
    return len(bytearray(megabytes << 20))


def compute(_: Channel) -> None:
    while True:
        pass


def sleep(_: Channel, mark: str = "") -> None:
    if mark:
        Path(mark).write_text(str(os.getpid()))
    time.sleep(600)


def kill_oneself(_: Channel) -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def refuse(_: Channel) -> None:
    raise ImportFormatError("a.zip: is none.", "too_large")


def break_down(_: Channel) -> None:
    raise RuntimeError("something secret")


def try_all(_: Channel, folder: str, other: str, port: int, victim: int) -> dict[str, str]:
    """Try an attacker's operations inside a sandbox; returns each with the name of its error."""

    def connect() -> None:
        socket.create_connection(("127.0.0.1", port), timeout=1).close()

    def send_datagram() -> None:
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b"x", ("127.0.0.1", port))

    def rename_out() -> None:
        Path(folder, "mine").write_text("x")
        Path(folder, "mine").rename(Path(other, "mine"))

    attempts: dict[str, Any] = {
        "write": lambda: Path(other, "new").write_text("x"),
        "overwrite": lambda: Path(other, "old").write_text("x"),
        "truncate": lambda: os.truncate(Path(other, "old"), 0),
        "delete": Path(other, "old").unlink,
        "make a folder": Path(other, "folder").mkdir,
        "link": lambda: Path(other, "link").symlink_to("/etc/passwd"),
        "move out": rename_out,
        "connect": connect,
        "send": send_datagram,
        "unix socket": lambda: socket.socket(socket.AF_UNIX),
        "another program": lambda: subprocess.run(["/bin/true"], check=True),
        "a signal": lambda: os.kill(victim, signal.SIGTERM),
        "more memory": lambda: __import__("resource").setrlimit(9, (1 << 40, 1 << 40)),
    }
    found = {}
    for name, attempt in attempts.items():
        try:
            attempt()
            found[name] = "done"
        except Exception as error:
            found[name] = type(error).__name__
    return found


def test_the_limits_hold(sandboxes: Sandboxes) -> None:
    assert sandboxes.run(MODULE + "take", 200, limits=Limits(512)) == 200 << 20
    with pytest.raises(SandboxError, match="more than the 512 MiB of memory"):
        sandboxes.run(MODULE + "take", 2000, limits=Limits(512))
    with pytest.raises(SandboxError, match="more than the 1 s of computing"):
        sandboxes.run(MODULE + "compute", limits=Limits(512, computing=1))
    with pytest.raises(SandboxError, match="more than the 1 s that it may take"):
        sandboxes.run(MODULE + "sleep", limits=Limits(512, wall=1))


def test_failures_are_reported_without_details(sandboxes: Sandboxes) -> None:
    with pytest.raises(ImportFormatError, match="is none") as caught:
        sandboxes.run(MODULE + "refuse", limits=FREE)
    assert caught.value.kind == "too_large"
    with pytest.raises(SandboxError, match=r"failed \(RuntimeError\)") as unexpected:
        sandboxes.run(MODULE + "break_down", limits=FREE)
    assert "secret" not in str(unexpected.value)
    with pytest.raises(SandboxError, match="died"):
        sandboxes.run(MODULE + "kill_oneself", limits=FREE)


def test_a_sandbox_isolates_its_process(sandboxes: Sandboxes, tmp_path: Path) -> None:
    writable, other = tmp_path / "mine", tmp_path / "other"
    writable.mkdir()
    other.mkdir()
    (other / "old").write_text("old")
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        limits = Limits(2048, writable=(writable,))
        found = sandboxes.run(MODULE + "try_all", str(writable), str(other), port, os.getpid(), limits=limits)
    assert [name for name, what in found.items() if what == "done"] == []
    assert (other / "old").read_text() == "old"
    assert [path.name for path in other.iterdir()] == ["old"]
    assert (writable / "mine").exists(), "it may write in its own folder"


WORKERS = """
import json, os, sys, time
from pathlib import Path
from app.jobs.worker import _restrict_process
from app.settings import Settings
from tests.attack.test_sandboxes import try_all
home, other, port = sys.argv[1:]
elsewhere = "postgresql+psycopg://localhost/none"
for name, lane, database in (
    ("long", "long", None), ("short", "short", None), ("scenes", "scenes", None),
    ("elsewhere", "imports", elsewhere), ("imports", "imports", None)
):
    if (victim := os.fork()) == 0:
        time.sleep(600)
    Path(other, "old").write_text("old")
    Path(other, "mine").unlink(missing_ok=True)
    if (worker := os.fork()) == 0:
        _restrict_process(Settings(home=home, database_url=database), lane)
        print(name, json.dumps(try_all(None, home, other, int(port), victim)), flush=True)
        os._exit(0)
    os.waitpid(worker, 0)
    os.kill(victim, 9)
    os.waitpid(victim, 0)
"""
SOCKETS = {"connect", "send", "unix socket"}


def test_a_worker_drops_permissions(tmp_path: Path) -> None:
    """A worker for imports may only store in addition to a sandbox; scenes and remote databases may connect."""
    home, other = tmp_path / "home", tmp_path / "other"
    home.mkdir()
    other.mkdir()
    with socket.create_server(("127.0.0.1", 0)) as listener:
        command = [sys.executable, "-c", WORKERS, str(home), str(other), str(listener.getsockname()[1])]
        said = subprocess.check_output(
            command, cwd=Path(__file__).parents[2], env={**os.environ, "TMPDIR": str(home)}, text=True
        )
    lines = (line.partition(" ") for line in said.splitlines())
    done = {name: {done for done, what in json.loads(found).items() if what == "done"} for name, _, found in lines}
    assert (home / "mine").exists(), "it writes in the data folder"
    assert done["imports"] == {"more memory"}, "that one follows"
    for name, needed in {"long": set(), "short": set(), "scenes": SOCKETS, "elsewhere": SOCKETS}.items():
        assert done[name] & {*SOCKETS, "another program"} == needed, name


def test_a_sandbox_without_a_folder_cannot_write(sandboxes: Sandboxes, tmp_path: Path) -> None:
    with pytest.raises(SandboxError):
        sandboxes.run(MODULE + "sleep", str(tmp_path / "mark"), limits=Limits(512, wall=20))
    assert not (tmp_path / "mark").exists() or not (tmp_path / "mark").read_text()


def test_a_sandbox_ends_with_its_client(sandboxes: Sandboxes, tmp_path: Path) -> None:
    mark, left = tmp_path / "mark", threading.Event()
    ended: list[float] = []

    def wait() -> None:
        with pytest.raises(SandboxesClosed):
            sandboxes.run(
                MODULE + "sleep", str(mark), limits=Limits(512, writable=(tmp_path,)), stop=lambda: left.is_set()
            )
        ended.append(time.monotonic())

    thread = threading.Thread(target=wait)
    thread.start()
    wait_until(lambda: mark.exists() and mark.read_text(), time_limit(10))
    began = time.monotonic()
    left.set()
    thread.join(time_limit(2))
    assert ended[0] - began < time_limit(0.5)
    wait_until(lambda: has_ended(int(mark.read_text())), time_limit(2))


def test_a_sandbox_ends_with_its_server(tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from app.sandbox.limits import Limits\n"
        "from app.sandbox.sandboxes import Sandboxes\n"
        "folder = Path(sys.argv[1])\n"
        f"Sandboxes().run('{MODULE}sleep', str(folder / 'mark'), limits=Limits(512, writable=(folder,)))"
    )
    server = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], cwd=Path(__file__).parents[2])
    mark = tmp_path / "mark"
    wait_until(lambda: mark.exists() and mark.read_text(), time_limit(30))
    server.kill()
    server.wait()
    wait_until(lambda: has_ended(int(mark.read_text())), time_limit(2))


def has_ended(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] == "Z"
    except OSError:
        return True
