"""Videos that may be added: paths, links, uploads, hostile files."""

from __future__ import annotations

import os
import random
from pathlib import Path
from types import ModuleType

import pytest

from app.errors import ApiError
from app.videos.paths import allowed_path
from tests.app.import_now import work_off
from tests.app.toy_server import SECRET, Server


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    folder = tmp_path / "outside"
    folder.mkdir()
    (folder / "secret.mp4").write_bytes(b"\0\0\0\x18ftypmp42" + b"\0" * 100)
    return folder


def test_only_videos_in_the_roots_are_read(server: Server, outside: Path) -> None:
    home = server.settings.home
    (home / "link.mp4").symlink_to(outside / "secret.mp4")
    (home / "folder").symlink_to(outside)
    cases = {
        str(outside / "secret.mp4"): 403,
        str(outside / "missing.mp4"): 403,  # the same answer whether it exists or not
        str(home / "link.mp4"): 403,
        str(home / "folder" / "secret.mp4"): 403,
        f"{home}/../outside/secret.mp4": 403,
        f"{home}/a/../../outside/secret.mp4": 403,
        "/etc/passwd": 403,
        "//server/share/x.mp4": 403,
        "\\\\server\\share\\x.mp4": 403,
        "../outside/secret.mp4": 403,
        "relative.mp4": 422,
        "": 422,
        "/" + "a" * 5000: 422,
        str(home / "missing.mp4"): 404,
        str(home): 422,
    }
    said = set()
    for path, status in cases.items():
        answer = server.client.post("/api/videos", json={"path": path})
        assert answer.status_code == status, (path, answer.text)
        if status == 403:
            said.add(answer.json()["error"]["message"])
    assert len(said) == 1
    for path in (f"{home}/a\0b.mp4", f"{home}/\u202egpm.4", f"{home}/a\nb.mp4", "\0"):
        answer = server.client.post("/api/videos", json={"path": path})
        assert (answer.status_code, answer.json()["error"]["code"]) == (403, "refused"), path
    for path in (str(outside), "/", "/etc", f"{home}/..", str(home / "folder")):
        assert server.client.get("/api/browse", params={"path": path}).status_code == 403, path
    assert server.client.get("/api/videos").json() == {"videos": []}


def test_random_paths_never_leave_the_roots(tmp_path: Path) -> None:
    root = tmp_path / "root"
    (root / "in").mkdir(parents=True)
    (tmp_path / "out").mkdir()
    (root / "in" / "loop").symlink_to(root)
    (root / "in" / "up").symlink_to(tmp_path)
    parts = ["..", ".", "in", "loop", "up", "out", "", "root", "%2e%2e", "..\\", " ", "~", "in/loop", str(tmp_path)]
    rng = random.Random(0)
    for _ in range(3000):
        text = "/".join([str(root), *(rng.choice(parts) for _ in range(rng.randrange(6)))])
        try:
            found = allowed_path(text, [root])
        except ApiError:
            continue
        assert os.path.realpath(found).startswith(str(root)), text


def test_browsing_shows_folders_and_videos(server: Server) -> None:
    home = server.settings.home
    (home / "drives").mkdir()
    (home / "drives" / "b.MP4").write_bytes(b"x")
    (home / "drives" / "a.mkv").write_bytes(b"xy")
    (home / "drives" / "notes.txt").write_text("x")
    (home / "drives" / ".hidden.mp4").write_bytes(b"x")
    found = server.client.get("/api/browse", params={"path": str(home / "drives")}).json()
    assert [(v["name"], v["size"]) for v in found["videos"]] == [("a.mkv", 2), ("b.MP4", 1)]
    assert found["parent"] == str(home)
    assert "drives" in server.client.get("/api/browse").json()["folders"]


HOSTILE = {
    "text.mp4": b"just some text, no video at all",
    "playlist.mp4": b"#EXTM3U\n#EXTINF:1,\nfile:///etc/passwd\n",
    "concat.mp4": b"ffconcat version 1.0\nfile '/etc/passwd'\n",
    "empty.mp4": b"",
    "zip.mp4": b"PK\x03\x04" + b"\0" * 60,
}


@pytest.mark.parametrize("name", sorted(HOSTILE))
def test_other_files_are_refused_at_once(server: Server, name: str) -> None:
    path = server.settings.home / name
    path.write_bytes(HOSTILE[name])
    answer = server.client.post("/api/videos", json={"path": str(path)})
    assert answer.status_code == 422
    assert answer.json()["error"]["code"] == "not_a_video"
    sent = server.client.put(f"/api/uploads/{name}", content=HOSTILE[name])
    assert sent.status_code in (415, 422), sent.text
    assert _left(server) == []


def _left(server: Server) -> list[str]:
    folder = server.settings.home / "uploads"
    return sorted(p.name for p in folder.iterdir()) if folder.is_dir() else []


def test_a_damaged_video_fails_with_one_sentence(server: Server, corpus: ModuleType) -> None:
    home = server.settings.home
    made = corpus.make(corpus.RECIPES["constant"], home, "whole")
    cut = home / "cut.mp4"
    cut.write_bytes(made.path.read_bytes()[:300])
    video = server.client.post("/api/videos", json={"path": str(cut)}).json()["id"]
    work_off(server.context, "import")
    state = server.client.get(f"/api/videos/{video}").json()
    assert state["state"] == "failed"
    assert state["error"].endswith(".")
    assert "Traceback" not in state["error"]
    answer = server.client.get(f"/api/videos/{video}/frames/0")
    assert (answer.status_code, answer.json()["error"]["code"]) == (409, "not_ready")
    assert server.client.post(f"/api/videos/{video}/runs", json={}).status_code == 409


def test_an_upload_is_the_same_video_as_its_file(server: Server, corpus: ModuleType) -> None:
    made = corpus.make(corpus.RECIPES["constant"], server.settings.home, "drive")
    sent = server.client.put("/api/uploads/My drive.mp4", content=made.path.read_bytes())
    assert sent.status_code == 201, sent.text
    video = sent.json()["id"]
    assert sent.json()["name"] == "My drive.mp4"
    assert _left(server) == [f"{video}.mp4"]
    work_off(server.context, "import")
    assert server.client.get(f"/api/videos/{video}/thumbnail").headers["content-type"] == "image/jpeg"
    assert server.client.post("/api/videos", json={"path": str(made.path)}).json()["id"] == video
    assert server.client.delete(f"/api/videos/{video}").status_code == 204
    assert made.path.is_file()  # a file added by path must not be deleted


def test_broken_uploads_leave_nothing(server: Server) -> None:
    import asyncio

    messages = iter([{"type": "http.request", "body": b"\0\0\0\x18ftypmp42" + b"\0" * 100_000, "more_body": True}])
    sent: list[dict[str, object]] = []

    async def receive() -> dict[str, object]:
        return next(messages, {"type": "http.disconnect"})

    async def send(message: dict[str, object]) -> None:
        sent.append(message)

    headers = [(b"host", b"127.0.0.1"), (b"authorization", f"Bearer {SECRET}".encode())]
    scope = {
        "type": "http", "http_version": "1.1", "method": "PUT", "path": "/api/uploads/a.mp4", "query_string": b"",
        "raw_path": b"/api/uploads/a.mp4", "root_path": "", "scheme": "http", "headers": headers,
        "server": ("127.0.0.1", 80), "client": ("127.0.0.1", 9), "app": server.app,
    }  # fmt: skip
    asyncio.run(server.app(scope, receive, send))
    assert sent[0]["status"] == 422
    assert _left(server) == []
    small = Server(server.settings.home / "small", upload_max_mb=1)
    with small.client:
        large = b"\0\0\0\x18ftypmp42" + b"\0" * (2**20)
        assert small.client.put("/api/uploads/a.mp4", content=large).status_code == 413
        assert small.client.put("/api/uploads/a.mp4", content=iter([large[:600_000]] * 3)).status_code == 413
        assert _left(small) == []
    for name, status in (("a.exe", 415), (".a.mp4", 422), ("a%2Fb.mp4", 404), ("..%5Ca.mp4", 422), ("a%00.mp4", 422)):
        assert server.client.put(f"/api/uploads/{name}", content=b"x").status_code == status, name
    assert _left(server) == []
