"""Scrubbing shows a reduced picture of the right frame at once, and the exact picture when the cursor rests."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import app.videos.frame_server
import app.videos.previews
from app.videos.decoding import SandboxedDecoder
from app.videos.import_files import preview_path
from app.videos.previews import needs_preview
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server
from tests.io import video_corpus
from tsr_engine.errors import StorageError
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter


@pytest.fixture
def slow_decoding(monkeypatch: pytest.MonkeyPatch) -> None:
    """Makes the small pictures of the corpus count as slow."""
    monkeypatch.setattr(app.videos.frame_server, "PREVIEW_THRESHOLD_S", 0.0002)
    monkeypatch.setattr(app.videos.previews, "MAX_SEEK_S", 0.001)


def _long(server: Server) -> tuple[Any, str]:
    made = video_corpus.make(video_corpus.RECIPES["long_gop"], server.settings.home, "long")
    answer = server.client.post("/api/videos", json={"path": str(made.path)})
    assert answer.status_code == 201, answer.text
    run_jobs(server.context, "import")
    return made, str(answer.json()["id"])


def _ask(server: Server, video: str, k: int, query: str = "?preview=true") -> Any:
    answer = server.client.get(f"/api/videos/{video}/frames/{k}{query}")
    assert answer.status_code == 200, answer.text
    assert answer.headers["x-frame-ordinal"] == str(k)
    return answer


def _code(answer: Any) -> int:
    return int(video_corpus.read_code(cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR)))


@pytest.mark.usefixtures("slow_decoding")
def test_a_preview_is_a_reduced_picture_of_the_frame(server: Server) -> None:
    made, video = _long(server)
    path = preview_path(server.settings.home, video)
    far = len(made.codes) - 1
    assert path.is_file()  # a jump right after the import is served at once
    with open_video(path) as copy:
        assert len(copy.table) == len(made.codes)
        assert int(np.diff(np.flatnonzero(copy.table.key)).max()) <= 12
    order = list(range(len(made.codes)))
    random.Random(4).shuffle(order)
    soft = 0
    for k in order:
        answer = _ask(server, video, k)
        assert _code(answer) == made.codes[k], k
        if answer.headers["x-frame-exact"] == "false":
            soft += 1
            assert answer.headers["cache-control"] == "no-store"
            assert "etag" not in answer.headers
    assert soft > len(order) // 4
    previews = server.context.frames.open_servers[video].previews
    assert isinstance(previews.decoder, SandboxedDecoder), "the server itself decodes nothing"
    exact = _ask(server, video, far, "")
    assert exact.headers["x-frame-exact"] == "true"
    assert _code(exact) == made.codes[far]
    assert _ask(server, video, far).headers["x-frame-exact"] == "true"  # now cached


@pytest.mark.usefixtures("slow_decoding")
def test_a_full_disk_loses_only_the_preview_copy(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(writer: VideoWriter, *_: object) -> None:
        if writer.frames == 5:
            raise StorageError("The disk is full.")
        write(writer, *_)

    write = VideoWriter.write
    monkeypatch.setattr(VideoWriter, "write", full)
    made, video = _long(server)
    assert not any(preview_path(server.settings.home, video).parent.iterdir())
    view = server.client.get(f"/api/videos/{video}").json()
    assert (view["state"], view["frames"]) == ("ready", len(made.codes))
    assert _code(_ask(server, video, len(made.codes) - 1)) == made.codes[-1]


@pytest.mark.usefixtures("slow_decoding")
def test_a_damaged_copy_is_ignored(server: Server) -> None:
    made, video = _long(server)
    path = preview_path(server.settings.home, video)
    path.write_bytes(b"\0" * 2000)
    answer = _ask(server, video, len(made.codes) - 1)
    assert answer.headers["x-frame-exact"] == "true"
    assert _code(answer) == made.codes[-1]
    assert not path.exists()


@pytest.mark.usefixtures("slow_decoding")
def test_removing_a_video_removes_its_copy(server: Server) -> None:
    _, video = _long(server)
    path = preview_path(server.settings.home, video)
    assert path.is_file()
    assert server.client.delete(f"/api/videos/{video}").status_code in (200, 204)
    assert not path.exists()


def test_only_videos_with_slow_seeking_get_a_copy(server: Server) -> None:
    made, video = _long(server)  # small pictures decode fast
    with open_video(Path(made.path)) as file:
        assert not needs_preview(file.table, file.width, file.height)
        assert needs_preview(file.table, 3840, 2160)
    assert not preview_path(server.settings.home, video).exists()
