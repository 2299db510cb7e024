"""``tsr review`` as a program: its link, a second call, Ctrl-C, refusals."""

from __future__ import annotations

import gc
import json
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from app.cli.serve import ReviewServer, open_link, serve
from app.settings import Settings
from sample_videos import SHIPPED
from tests.forked_program import ForkedProgram, run_forked
from tests.waiting import time_limit
from tsr_engine.errors import StorageError

PROGRAM, WORDS = "app.cli.main:run", ["review", "--no-browser"]
COMMAND = [sys.executable, "-c", "import sys; from app.cli.main import run; sys.exit(run())", *WORDS]


def _environment(home: Path) -> dict[str, str]:
    return {**os.environ, "TSR_HOME": str(home), "TSR_SAMPLE": "false", "TSR_WORKERS": "0", "PYTHONWARNINGS": "ignore"}


class ReviewProcess:
    """A server process."""

    def __init__(self, home: Path, *, forked: bool = True) -> None:
        self.home = home
        words, environment = ["--port", "0"], _environment(home)
        self.process: ForkedProgram | subprocess.Popen[str] = (
            ForkedProgram(PROGRAM, [*WORDS, *words], environment, stderr=subprocess.PIPE)
            if forked
            else subprocess.Popen([*COMMAND, *words], env=environment, stderr=subprocess.PIPE, text=True)
        )
        assert self.process.stderr is not None
        line = self.process.stderr.readline()
        assert "/login/" in line, line
        self.link = line.split(" on ")[1].strip()
        self.base = self.link.split("/login/")[0]
        deadline = time.monotonic() + time_limit(20)
        while time.monotonic() < deadline:
            try:
                urllib.request.urlopen(self.base + "/", timeout=5).close()
                break
            except OSError:
                time.sleep(0.05)
        else:
            raise AssertionError("the server does not answer")

    def get(self, path: str) -> dict[str, object]:
        token = (self.home / "token").read_text().strip()
        request = urllib.request.Request(self.base + path, headers={"Authorization": f"Bearer {token}"})
        with urllib.request.urlopen(request, timeout=10) as answer:
            found: dict[str, object] = json.load(answer)
            return found

    def end(self) -> None:
        """Kill the remaining process."""
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        assert self.process.stderr is not None
        self.process.stderr.close()


def call(home: Path, *arguments: str, **variables: str) -> tuple[int, str]:
    """Exit code of a call that starts no server, and what it says."""
    return run_forked(PROGRAM, [*WORDS, *arguments], {**_environment(home), **variables})


@pytest.fixture
def running(tmp_path: Path) -> Iterator[ReviewProcess]:
    server = ReviewProcess(tmp_path / "home")
    yield server
    server.end()


@pytest.fixture
def started(tmp_path: Path) -> Iterator[ReviewProcess]:
    """One that Python starts."""
    server = ReviewProcess(tmp_path / "home", forked=False)
    yield server
    server.end()


def test_the_link_works_once_and_ctrl_c_ends_it_quickly(started: ReviewProcess) -> None:
    class Stay(urllib.request.HTTPRedirectHandler):
        def redirect_request(self, *_: object) -> None:
            return None

    opener = urllib.request.build_opener(Stay())
    for status in (303, 401):
        with pytest.raises(urllib.error.HTTPError) as answer:
            opener.open(started.link, timeout=10)
        assert answer.value.code == status
        answer.value.close()
    assert started.get("/api/session")["version"]
    began = time.monotonic()
    started.process.send_signal(signal.SIGINT)
    started.process.wait(timeout=time_limit(10))
    assert time.monotonic() - began < time_limit(4)
    assert not (started.home / "server.json").exists()


def test_a_second_call_finds_the_first(running: ReviewProcess) -> None:
    code, said = call(running.home)
    assert code == 0
    assert "already" in said
    assert "Ctrl-C" not in said, "that would end nothing"
    assert "warning" not in said
    assert running.base in said
    assert "/login/" in said


def test_a_second_call_names_options_that_the_first_cannot_adopt(running: ReviewProcess, tmp_path: Path) -> None:
    code, said = call(running.home, "--root", str(tmp_path), "--workers", "2")
    assert code == 0
    assert "warning: --root, --workers has no effect there. Stop that server first" in said


def test_a_second_server_on_one_sqlite_file_is_refused(running: ReviewProcess, tmp_path: Path) -> None:
    """Each server would take the other's jobs for dead, because it does not see their locks."""
    link = tmp_path / "link.sqlite"
    link.symlink_to(running.home / "tsr.sqlite")
    for name in (running.home / "tsr.sqlite", link):
        code, said = call(tmp_path / "another home", "--port", "0", "--database", f"sqlite:///{name}")
        assert code == 6, said
        what = f"Another server uses the database {running.home / 'tsr.sqlite'}."
        assert said.strip() == f"tsr: {what} Use its page, or choose another --database."
    assert running.get("/api/videos") == {"videos": []}


def test_the_secret_is_not_sent_to_the_port_of_a_killed_server(tmp_path: Path) -> None:
    """Another process may use its port by then."""
    home = tmp_path / "home"
    killed = ReviewProcess(home)
    killed.process.kill()
    killed.end()
    with socket.socket() as stranger:
        stranger.bind(("127.0.0.1", 0))
        stranger.listen()
        stranger.settimeout(0.5)
        note = {"base": f"http://127.0.0.1:{stranger.getsockname()[1]}", "pid": killed.process.pid}
        (home / "server.json").write_text(json.dumps(note))
        server = ReviewProcess(home)
        try:
            assert json.loads((home / "server.json").read_text())["base"] == server.base
            with pytest.raises(TimeoutError):
                stranger.accept()
        finally:
            server.end()


def test_an_open_stream_does_not_delay_ctrl_c(running: ReviewProcess) -> None:
    token = (running.home / "token").read_text().strip()
    request = urllib.request.Request(running.base + "/api/events", headers={"Authorization": f"Bearer {token}"})
    with urllib.request.urlopen(request, timeout=10) as stream:
        assert stream.readline().startswith(b"id:")
        began = time.monotonic()
        for _ in range(3):  # a second Ctrl-C has no effect
            running.process.send_signal(signal.SIGINT)
            time.sleep(0.02)
        running.process.wait(timeout=time_limit(10))
        assert time.monotonic() - began < time_limit(3)
    assert running.process.returncode == 0
    assert running.process.stderr is not None
    assert running.process.stderr.read() == "tsr: Press Ctrl-C to stop. All changes are stored at once.\n"


def test_refusals_are_sentences(tmp_path: Path) -> None:
    home = tmp_path / "home"
    damaged = tmp_path / "damaged"
    damaged.mkdir()
    (damaged / "tsr.sqlite").write_bytes(b"garbage" * 1000)
    joined = tmp_path / "half\u200cspace.mp4"  # as in Persian
    joined.write_bytes(SHIPPED[0].video.read_bytes())
    for (code, said), words in (
        (
            call(home, "--port", "0", TSR_HOME=str(tmp_path / "damaged")),
            f"a copy from {tmp_path / 'damaged' / 'backups'}",
        ),
        (call(home, "missing.mp4"), "There is no video"),
        (call(home, __file__), "is not a video"),
        (call(home, "--port", "0", str(joined)), "characters that are not allowed in file names here"),
        (call(home, "--root", "/none"), "There is no folder of videos at /none"),
        (call(home, "--root", __file__), "Expected a folder of videos"),
        (call(home, "--models", "/none"), "There is no folder of models at /none"),
        (call(home, "--models", __file__), "Expected a folder of models"),
        (call(home, "--home", ""), "The value of --home is empty"),
        (call(home, "--host", "0.0.0.0"), "TSR_TOKEN"),
        (call(home, "--port", "0", TSR_HOME="/proc/nothing"), "/proc/nothing"),
        (call(home, "--port", "1", "--host", "192.0.2.1", TSR_TOKEN="long enough to be one"), "Cannot listen"),
    ):
        assert code in (2, 3, 6), said
        assert words in said
        assert "Traceback" not in said


def test_a_database_that_cannot_be_written_is_refused() -> None:
    """As after a restore that leaves the file to root."""
    user = os.geteuid()
    with TemporaryDirectory() as folder:  # not tmp_path, whose parents are closed to other users
        home = Path(folder)
        home.chmod(0o777)
        (home / "tsr.sqlite").touch(0o444)
        try:
            if user == 0:
                os.seteuid(65534)  # nothing is forbidden to root
            with pytest.raises(StorageError, match=r"tsr\.sqlite cannot be written\. Give the file"):
                serve(Settings(home=home, port=0, sample=False, workers=0), None, browser=False)
        finally:
            os.seteuid(user)


def test_garbage_collection_delays_neither_requests_nor_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Measured with a page and two workers: 2.5 s from Ctrl-C to the prompt with it, 1.3 s without."""
    ran: list[ReviewServer] = []
    before: list[None] = []
    later: list[None] = []

    def collected(one: object) -> bool:
        return any(other is one for other in gc.get_objects())

    def run(self: ReviewServer, sockets: list[socket.socket]) -> None:
        nonlocal later
        assert not collected(before)
        later = []
        assert collected(later)
        ran.append(self)
        for one in sockets:
            one.close()

    monkeypatch.setattr(ReviewServer, "run", run)
    try:
        serve(Settings(home=tmp_path, port=0, sample=False, workers=0), None, browser=False)
        assert not collected(later)
    finally:
        for server in ran:
            server.started = True  # the thread that prints the link ends
            server.config.app.state.context.close()
    assert not (tmp_path / "server.json").exists()


def test_without_a_browser_the_user_opens_the_url(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for opens, said in ((True, ""), (False, "tsr: No browser was found. Open the address above in one.\n")):
        monkeypatch.setattr("app.cli.serve.webbrowser.open", lambda link, opens=opens: opens)
        open_link("http://127.0.0.1:1/login/x")
        assert capsys.readouterr().err == said
