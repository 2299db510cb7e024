"""Uploads: refusals, failures, and that nothing is left behind."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import hashlib
import json
import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy.orm import Session

from app.errors import StorageFull
from app.storage.database import Database
from app.storage.models import Run
from app.videos.service import VideoService
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import SECRET, Server
from tests.io import video_corpus


@pytest.fixture
def clip(tmp_path: Path) -> Path:
    return video_corpus.make(video_corpus.RECIPES["constant"], tmp_path, "clip").path


def _leftovers(server: Server) -> list[str]:
    return sorted(path.name for path in (server.settings.home / "uploads").glob("*"))


def _code(answer: Any) -> tuple[int, str]:
    body = answer.json()
    assert set(body) == {"error"}
    assert set(body["error"]) == {"code", "message", "field", "details"}
    return answer.status_code, body["error"]["code"]


def test_an_upload_becomes_a_video_and_is_removed_with_it(server: Server, clip: Path) -> None:
    content = clip.read_bytes()
    answer = server.client.put("/api/uploads/Drive 1.MP4", content=content)
    assert answer.status_code == 201, answer.text
    video = answer.json()
    assert (video["id"], video["name"]) == (hashlib.sha256(content).hexdigest(), "Drive 1.MP4")
    run_jobs(server.context, "import")
    assert server.client.get(f"/api/videos/{video['id']}/frames/3").status_code == 200
    assert server.client.get(f"/api/videos/{video['id']}/thumbnail").content[:2] == b"\xff\xd8"
    # The same bytes under another name, or added by path, are the same video and use no more space.
    assert server.client.put("/api/uploads/other.mov", content=content).json()["id"] == video["id"]
    place = server.settings.home / "mine.mp4"
    place.write_bytes(content)
    assert server.client.post("/api/videos", json={"path": str(place)}).json()["id"] == video["id"]
    assert _leftovers(server) == [f"{video['id']}.mp4"]
    assert server.client.delete(f"/api/videos/{video['id']}").status_code == 204
    assert (_leftovers(server), place.read_bytes()) == ([], content)
    assert server.client.get("/api/videos").json() == {"videos": []}


def test_uploads_are_found_where_the_data_folder_was_moved_to(tmp_path: Path, clip: Path) -> None:
    homes = tmp_path / "old", tmp_path / "new"
    for home in homes:
        server = Server(home)
        with server.client as client:
            if home == homes[0]:
                video = client.put("/api/uploads/drive.mp4", content=clip.read_bytes()).json()["id"]
                run_jobs(server.context, "import")
            assert client.get(f"/api/videos/{video}/frames/3").status_code == 200
            if home == homes[1]:
                assert client.delete(f"/api/videos/{video}").status_code == 204
                assert _leftovers(server) == []
        if home == homes[0]:
            home.rename(homes[1])


def test_errors_of_an_upload_use_its_original_name(server: Server, clip: Path) -> None:
    content = clip.read_bytes()
    broken = server.client.put("/api/uploads/My drive.mp4", content=content[: len(content) // 3]).json()["id"]
    run_jobs(server.context, "import")
    found = server.client.get(f"/api/videos/{broken}").json()
    assert (found["state"], found["error"][:13]) == ("failed", "My drive.mp4 ")
    assert broken not in found["error"]
    whole = server.client.put("/api/uploads/Drive 1.mp4", content=content).json()
    run_jobs(server.context, "import")
    Path(whole["path"]).unlink()
    message = server.client.get(f"/api/videos/{whole['id']}/frames/3").json()["error"]["message"]
    assert message == "Drive 1.mp4 is missing. Upload it again."


def test_removing_keeps_a_file_added_by_path(server: Server, clip: Path) -> None:
    place = server.settings.home / "mine.mp4"
    place.write_bytes(clip.read_bytes())
    video = server.client.post("/api/videos", json={"path": str(place)}).json()["id"]
    # Uploading an existing file keeps the person's file for the video.
    assert server.client.put("/api/uploads/copy.mp4", content=clip.read_bytes()).json()["path"] == str(place)
    run_jobs(server.context, "import")
    assert server.client.delete(f"/api/videos/{video}").status_code == 204
    assert place.read_bytes() == clip.read_bytes()


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("page.html", b"x", (415, "unsupported_media")),
        ("a.exe", b"x", (415, "unsupported_media")),
        ("x.mp4", b"<html>" + bytes(200), (415, "unsupported_media")),
        ("x.mp4", b"#EXTM3U\n", (415, "unsupported_media")),
        ("x.mp4", b"ffconcat version 1.0\nfile '/etc/passwd'\n", (415, "unsupported_media")),
        ("x.mp4", b"PK\x03\x04" + bytes(60), (415, "unsupported_media")),
        ("x.mp4", b"", (422, "invalid")),
        (".x.mp4", b"x", (422, "invalid")),
        ("a%2Fb.mp4", b"x", (404, "not_found")),
        ("a%5Cb.mp4", b"x", (422, "invalid")),
        ("..%5Ca.mp4", b"x", (422, "invalid")),
        ("a%00b.mp4", b"x", (422, "invalid")),
        ("a%E2%80%AEb.mp4", b"x", (422, "invalid")),
    ],
)
def test_wrong_uploads_leave_nothing(server: Server, name: str, content: bytes, expected: tuple[int, str]) -> None:
    assert _code(server.client.put(f"/api/uploads/{name}", content=content)) == expected
    assert _leftovers(server) == []


def test_too_large_uploads_with_and_without_a_length(tmp_path: Path, clip: Path) -> None:
    server = Server(tmp_path / "small", upload_max_mb=1)
    content = clip.read_bytes() + bytes(2**20)
    with server.client:
        assert _code(server.client.put("/api/uploads/x.mp4", content=content)) == (413, "too_large")
        pieces = (content[k : k + 65536] for k in range(0, len(content), 65536))
        assert _code(server.client.put("/api/uploads/x.mp4", content=pieces)) == (413, "too_large")
        assert _leftovers(server) == []


def test_a_full_disk_is_reported_and_leaves_nothing(
    server: Server, clip: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("app.api.request_body.os.fsync", full)
    assert _code(server.client.put("/api/uploads/x.mp4", content=clip.read_bytes())) == (507, "storage_full")
    assert _leftovers(server) == []
    assert server.client.get("/api/videos").json() == {"videos": []}


def test_a_disconnected_browser_leaves_nothing(server: Server, clip: Path) -> None:
    messages = iter([{"type": "http.request", "body": clip.read_bytes()[:3000], "more_body": True}])
    sent: list[Any] = []
    seen: list[list[str]] = []

    async def receive() -> Any:
        seen.append(_leftovers(server))
        return next(messages, {"type": "http.disconnect"})

    async def send(message: Any) -> None:
        sent.append(message)

    headers = [(b"host", b"127.0.0.1"), (b"authorization", f"Bearer {SECRET}".encode())]
    scope = {
        "type": "http", "http_version": "1.1", "method": "PUT", "scheme": "http", "path": "/api/uploads/x.mp4",
        "raw_path": b"/api/uploads/x.mp4", "query_string": b"", "root_path": "", "headers": headers,
        "client": ("127.0.0.1", 1), "server": ("127.0.0.1", 80),
    }  # fmt: skip
    asyncio.run(server.app(scope, receive, send))  # type: ignore[arg-type]
    assert sent[0]["status"] == 422
    assert any(seen), "the upload had begun"
    assert _leftovers(server) == []
    assert server.client.get("/api/videos").json() == {"videos": []}


def _upload(server: Server, content: bytes, name: str = "x.mp4") -> Any:
    """Process the received bytes as the route does."""
    part = server.context.uploads.new_part()
    part.write_bytes(content)
    return server.context.videos.add_upload(part, name, hashlib.sha256(content).hexdigest())


class _ConcurrentAction:
    """Run an action in another thread at a given moment. The thread is joined unless it waits for this one."""

    def __init__(self, work: Callable[[], Any]) -> None:
        self._pool = ThreadPoolExecutor(1)
        self._work = work
        self.going: Future[Any] | None = None

    def __call__(self) -> None:
        if self.going is None:
            self.going = self._pool.submit(self._work)
            wait([self.going], timeout=1.0)

    def result(self) -> Any:
        assert self.going is not None, "the moment did not come"
        return self.going.result(timeout=60)


def _after_commit(monkeypatch: pytest.MonkeyPatch, act: Callable[[], None]) -> None:
    """Act when the row is removed and the file still exists."""
    write = Database.write

    @contextlib.contextmanager
    def committed(self: Database) -> Iterator[Session]:
        with write(self) as session:
            yield session
        act()

    monkeypatch.setattr(Database, "write", committed)


def _before_unlink(monkeypatch: pytest.MonkeyPatch, act: Callable[[], None]) -> None:
    """Act when the removal of the file is decided."""
    unlink = Path.unlink

    def late(self: Path, missing_ok: bool = False) -> None:
        if self.parent.name == "uploads" and self.suffix == ".mp4":
            act()
        unlink(self, missing_ok)

    monkeypatch.setattr(Path, "unlink", late)


@pytest.mark.parametrize("moment", [_after_commit, _before_unlink])
def test_an_upload_while_the_same_video_is_removed_keeps_its_file(
    server: Server,
    clip: Path,
    monkeypatch: pytest.MonkeyPatch,
    moment: Callable[[pytest.MonkeyPatch, Callable[[], None]], None],
) -> None:
    content = clip.read_bytes()
    first = _upload(server, content)
    again = _ConcurrentAction(lambda: _upload(server, content))
    with monkeypatch.context() as patch:
        moment(patch, again)
        server.context.videos.remove(first.id)
    view = again.result()
    assert Path(view.path).read_bytes() == content
    assert [video["missing"] for video in json.loads(server.context.videos.listing())["videos"]] == [False]


@pytest.mark.parametrize("decided", [False, True], ids=["file placed", "file to go"])
def test_a_failed_upload_keeps_the_file_of_a_simultaneous_one(
    server: Server, clip: Path, monkeypatch: pytest.MonkeyPatch, decided: bool
) -> None:
    content = clip.read_bytes()
    other = _ConcurrentAction(lambda: _upload(server, content))
    add, first = VideoService.add_row, threading.get_ident()

    def fail_first(self: VideoService, *given: Any, **more: Any) -> Any:
        if threading.get_ident() != first:
            return add(self, *given, **more)
        if not decided:
            other()
        raise StorageFull("The disk is full.")

    monkeypatch.setattr(VideoService, "add_row", fail_first)
    if decided:
        _before_unlink(monkeypatch, other)
    with pytest.raises(StorageFull):
        _upload(server, content)
    view = other.result()
    assert Path(view.path).read_bytes() == content
    assert _leftovers(server) == [Path(view.path).name]


def test_a_failed_upload_leaves_only_files_of_videos(
    server: Server, clip: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise StorageFull("The disk is full.")

    content = clip.read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr(VideoService, "add_row", fail)
        with pytest.raises(StorageFull):
            _upload(server, content)
        assert _leftovers(server) == []
    place = Path(_upload(server, content).path)
    place.unlink()
    monkeypatch.setattr(VideoService, "add_row", fail)
    with pytest.raises(StorageFull):
        _upload(server, content)
    assert place.read_bytes() == content, "the row names it, and it is what the row says"


def test_an_upload_replaces_a_changed_file(server: Server, clip: Path) -> None:
    content = clip.read_bytes()
    place = Path(_upload(server, content).path)
    run_jobs(server.context, "import")
    place.write_bytes(b"other bytes")
    view = _upload(server, content, "x.mov")
    assert _leftovers(server) == [f"{view.id}.mov"]
    assert Path(view.path).read_bytes() == content
    assert server.client.get(f"/api/videos/{view.id}/frames/0").status_code == 200


def test_leftovers_of_a_killed_upload_are_removed_at_the_next_start(server: Server) -> None:
    server.context.uploads.new_part().write_bytes(b"half")
    with Server(server.settings.home).client:
        assert _leftovers(server) == []


def test_import_errors_of_an_upload_use_its_name(server: Server, tmp_path: Path) -> None:
    whole = video_corpus.make(video_corpus.RECIPES["index_first"], tmp_path, "whole")
    cut = video_corpus.cut(whole, tmp_path / "cut.mp4", 0.6)
    video = server.client.put("/api/uploads/Drive 1.mp4", content=cut.read_bytes()).json()["id"]
    run_jobs(server.context, "import")
    shown = server.client.get(f"/api/videos/{video}").json()
    assert shown["state"] == "ready"
    assert shown["warnings"][0].startswith("Drive 1.mp4 announces 50 frames, ")
    run = server.client.post(f"/api/videos/{video}/runs", json={"stop": 2}).json()["id"]
    run_jobs(server.context, "track")
    with server.context.database.read() as session:
        reported = session.get_one(Run, run).summary["warnings"]
    assert reported
    assert all(sentence.startswith("Drive 1.mp4 ") for sentence in (*shown["warnings"], *reported))
