"""Videos that may be added by path: links, hostile files, and browsing."""

from __future__ import annotations

import os
import random
from pathlib import Path
from typing import Any

import pytest

from app.errors import ApiError
from app.videos.checked_file import CheckedFile
from app.videos.paths import MAX_ENTRIES, allowed_path
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server
from tests.io import video_corpus
from tsr_engine.errors import VideoError


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
        f"{home}2/x.mp4": 403,
        "/etc/passwd": 403,
        "//server/share/x.mp4": 403,
        "\\\\server\\share\\x.mp4": 403,
        "../outside/secret.mp4": 403,
        "relative.mp4": 422,
        "": 422,
        "/" + "a" * 5000: 422,
        f"{home}/{'x' * 300}.mp4": 422,
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


def test_browsing_stays_inside_and_skips_unnameable_files(server: Server) -> None:
    home = server.settings.home
    for name in ("b.mp4", "A.MOV", ".hidden.mp4", "notes.txt", "odd\u202e.mp4"):
        (home / name).write_bytes(b"x")
    Path(os.fsdecode(os.fsencode(home) + b"/bad\xff.mp4")).write_bytes(b"x")
    (home / "out").symlink_to("/etc")
    (home / "drives").mkdir()
    listing = server.client.get("/api/browse", params={"path": str(home)}).json()
    assert [(video["name"], video["size"]) for video in listing["videos"]] == [("A.MOV", 1), ("b.mp4", 1)]
    assert "drives" in listing["folders"]
    assert "drives" in server.client.get("/api/browse").json()["folders"]
    assert "out" not in listing["folders"]
    assert (listing["parent"], listing["truncated"]) == (None, False)
    assert server.client.get("/api/browse", params={"path": str(home / "out")}).status_code == 403
    assert server.client.get("/api/browse", params={"path": str(home / "b.mp4")}).status_code == 422
    inner = server.client.get("/api/browse", params={"path": str(home / "drives")}).json()
    assert (inner["parent"], inner["videos"]) == (str(home), [])


def test_a_truncated_listing_says_so(server: Server) -> None:
    home = server.settings.home / "full"
    home.mkdir()
    for k in range(MAX_ENTRIES + 500):
        (home / f".hidden {k}").touch()
        (home / f"notes {k}.txt").touch()
    for k in range(MAX_ENTRIES - 1):
        (home / f"video {k:04d}.mp4").touch()
    (home / "last folder").mkdir()

    def listing() -> Any:
        return server.client.get("/api/browse", params={"path": str(home)}).json()

    whole = listing()
    assert (len(whole["folders"]) + len(whole["videos"]), whole["truncated"]) == (MAX_ENTRIES, False)
    (home / "video 9999.mp4").touch()
    part = listing()
    assert (part["folders"], part["videos"], part["truncated"]) == (whole["folders"], whole["videos"], True)


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


def test_a_damaged_video_fails_only_its_import(server: Server) -> None:
    home = server.settings.home
    cut = video_corpus.cut(video_corpus.make(video_corpus.RECIPES["constant"], home, "whole"), home / "cut.mp4", 0.5)
    video = server.client.post("/api/videos", json={"path": str(cut)}).json()["id"]
    assert server.client.get(f"/api/videos/{video}/frames/0").status_code == 409
    run_jobs(server.context, "import")
    state = server.client.get(f"/api/videos/{video}").json()
    assert state["state"] == "failed"
    assert "cut short" in state["error"]
    assert state["error"].endswith(".")
    answer = server.client.get(f"/api/videos/{video}/frames/0")
    assert (answer.status_code, answer.json()["error"]["code"]) == (409, "not_ready")
    assert server.client.post(f"/api/videos/{video}/runs", json={}).status_code == 409


def test_a_video_in_a_folder_that_cannot_be_searched_is_refused_in_words(tmp_path: Path) -> None:
    closed = tmp_path / "closed"
    closed.mkdir(mode=0)
    file = CheckedFile(closed / "drive.mp4", [tmp_path])
    user = os.geteuid()
    try:
        if user == 0:
            os.seteuid(65534)  # nothing is forbidden to root
        assert file.exists
        with pytest.raises(VideoError, match="Permission denied"):
            file.open()
    finally:
        os.seteuid(user)
