"""A video file that crashes a decoder crashes only a separate process."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from app.videos.decoding import SandboxedDecoder
from tests.app.toy_home import ToyHome, make_home
from tests.app.toy_server import Server
from tests.waiting import time_limit, wait_until


@pytest.fixture(scope="module")
def toy(tmp_path_factory: pytest.TempPathFactory) -> ToyHome:
    """A home with a tracked drive."""
    home = make_home(tmp_path_factory.mktemp("frames"))
    home.evidence.close()
    home.database.close()
    return home


@pytest.fixture
def server(toy: ToyHome, tmp_path: Path) -> Iterator[Server]:
    """A server on a copy of it."""
    shutil.copytree(toy.settings.home, tmp_path / "home")
    server = Server(tmp_path / "home")
    with server.client:
        yield server


def frame(server: Server, toy: ToyHome, ordinal: int) -> Any:
    return server.client.get(f"/api/videos/{toy.video_id}/frames/{ordinal}")


def decoders(server: Server) -> list[SandboxedDecoder]:
    found = [frame_server.video for frame_server in server.context.frames.open_servers.values()]
    assert all(isinstance(one, SandboxedDecoder) for one in found), "no video is decoded in the server"
    return found  # type: ignore[return-value]


def test_a_decoder_that_dies_costs_one_answer(server: Server, toy: ToyHome) -> None:
    assert frame(server, toy, 3).status_code == 200
    before = frame(server, toy, 60).content
    decoders(server)[0].sandbox.kill()
    statuses = [frame(server, toy, k).status_code for k in (35, 36)]
    assert set(statuses) <= {200, 409}
    assert statuses[-1] == 200, "it is opened again"
    assert frame(server, toy, 60).content == before


def test_a_decoder_that_hangs_has_a_deadline(server: Server, toy: ToyHome, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.videos.decoding.PICTURE_TIMEOUT_S", time_limit(0.5))
    assert frame(server, toy, 3).status_code == 200
    decoder = decoders(server)[0]
    process = pid_of(decoder)
    os.kill(process, signal.SIGSTOP)
    answer = frame(server, toy, 70)
    assert answer.status_code in (200, 409), answer.text
    wait_until(lambda: not Path(f"/proc/{process}").exists(), time_limit(3))
    assert frame(server, toy, 70).status_code == 200


def test_no_decoder_outlives_its_server(toy: ToyHome, tmp_path: Path) -> None:
    shutil.copytree(toy.settings.home, tmp_path / "home")
    server = Server(tmp_path / "home")
    with server.client:
        assert frame(server, toy, 3).status_code == 200
        process = pid_of(decoders(server)[0])
    wait_until(lambda: not Path(f"/proc/{process}").exists(), time_limit(3))


def test_a_file_that_stops_being_a_video(server: Server, toy: ToyHome) -> None:
    """The file is overwritten while it is decoded: one sentence refuses it, and the server continues."""
    decoder = SandboxedDecoder(
        server.context.sandboxes, toy.video, server.settings.video_limits, table(server, toy), memory_mb=2048
    )
    decoder.close()
    broken = toy.video.with_name("broken.mp4")
    broken.write_bytes(b"\0\0\0\x20ftypisom" + os.urandom(4000))
    with pytest.raises(Exception, match="cannot be opened as a video"):
        SandboxedDecoder(
            server.context.sandboxes, broken, server.settings.video_limits, table(server, toy), memory_mb=2048
        )
    assert frame(server, toy, 3).status_code == 200


def table(server: Server, toy: ToyHome) -> Any:
    frame(server, toy, 0)
    return next(iter(server.context.frames.open_servers.values())).table


def pid_of(decoder: SandboxedDecoder) -> int:
    text = Path(f"/proc/self/fdinfo/{decoder.sandbox.process}").read_text()
    return int(text.partition("Pid:")[2].split()[0])
