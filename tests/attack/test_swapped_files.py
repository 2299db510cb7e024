"""A name is exchanged between check and use, or a file is overwritten with size and time restored."""

from __future__ import annotations

import ctypes
import errno
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.videos import paths, safe_open
from app.videos.safe_open import LINK_ERRORS, open_inside
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server
from tsr_engine.io.video_writer import VideoWriter

SIZE, FRAMES = 64, 8
WHITE, BLACK = 255, 0


def write_video(path: Path, shade: int) -> Path:
    """A short video of one shade."""
    with VideoWriter(path, SIZE, SIZE, 25) as writer:
        for _ in range(FRAMES):
            writer.write(np.full((SIZE, SIZE, 3), shade, np.uint8))
    return path


def exchange(one: Path, other: Path) -> None:
    """Swap both names atomically (RENAME_EXCHANGE)."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.renameat2(-100, os.fsencode(one), -100, os.fsencode(other), 2):
        raise OSError(ctypes.get_errno(), "renameat2")


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    folder = tmp_path / "outside"
    folder.mkdir()
    write_video(folder / "drive.mp4", BLACK)
    return folder


@contextmanager
def swapped_after_the_check(monkeypatch: pytest.MonkeyPatch, swap: Callable[[], None]) -> Iterator[None]:
    """Exchange the name at the worst moment: between check and open."""
    judged = paths.allowed_path

    def then(text: str, roots: list[Path]) -> Path:
        found = judged(text, roots)
        swap()
        return found

    with monkeypatch.context() as patch:
        patch.setattr(paths, "allowed_path", then)
        yield


@pytest.mark.parametrize("part", ["file", "folder"])
def test_a_link_swapped_in_after_the_check_gives_no_access(
    server: Server, outside: Path, monkeypatch: pytest.MonkeyPatch, part: str
) -> None:
    home = server.settings.home
    (home / "in").mkdir()
    write_video(home / "in" / "drive.mp4", WHITE)
    if part == "file":
        name, link, target = home / "in" / "drive.mp4", home / "in" / "link", outside / "drive.mp4"
    else:
        name, link, target = home / "in", home / "link", outside
    link.symlink_to(target)
    with swapped_after_the_check(monkeypatch, lambda: exchange(name, link)):
        answer = server.client.post("/api/videos", json={"path": str(home / "in" / "drive.mp4")})
        assert (answer.status_code, answer.json()["error"]["code"]) == (403, "refused")
        listed = server.client.get("/api/browse", params={"path": str(home / "in")})
        assert listed.status_code == (403 if part == "folder" else 200)
    assert server.client.get("/api/videos").json() == {"videos": []}


def test_a_rapidly_swapped_name_shows_only_files_inside(server: Server, outside: Path) -> None:
    """Both names are exchanged as fast as possible while the file is added and read."""
    home = server.settings.home
    inside, link = write_video(home / "drive.mp4", WHITE), home / "link"
    link.symlink_to(outside / "drive.mp4")
    over = threading.Event()

    def flicker() -> None:
        while not over.is_set():
            exchange(inside, link)

    thread = threading.Thread(target=flicker)
    thread.start()
    try:
        for _ in range(60):
            answer = server.client.post("/api/videos", json={"path": str(inside)})
            assert answer.status_code in (201, 403), answer.text
    finally:
        over.set()
        thread.join()
    if not inside.is_symlink():
        exchange(inside, link)
    run_jobs(server.context, "import")
    added = server.client.get("/api/videos").json()["videos"]
    assert len(added) <= 1
    for video in added:
        assert server.client.get(f"/api/videos/{video['id']}/frames/0").status_code == 409, "a link lies there now"
        exchange(inside, link)
        server.client.post("/api/videos", json={"path": str(inside)})
        run_jobs(server.context, "import")
        assert shade(server, video["id"]) == WHITE


def shade(server: Server, video: str) -> int:
    answer = server.client.get(f"/api/videos/{video}/frames/0")
    assert answer.status_code == 200, answer.text
    middle = np.median(cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR))
    return WHITE if middle > 200 else BLACK


def add_video(server: Server, path: Path) -> str:
    video: str = server.client.post("/api/videos", json={"path": str(path)}).json()["id"]
    run_jobs(server.context, "import")
    return video


@pytest.mark.parametrize("target", ["black", "white"])
def test_a_link_out_of_the_roots_is_not_followed_later(server: Server, outside: Path, target: str) -> None:
    """Not even to the same bytes: the roots define what may be read."""
    path = write_video(server.settings.home / "drive.mp4", WHITE)
    video = add_video(server, path)
    assert shade(server, video) == WHITE
    if target == "white":
        (outside / "drive.mp4").write_bytes(path.read_bytes())
    path.unlink()
    path.symlink_to(outside / "drive.mp4")
    answer = server.client.get(f"/api/videos/{video}/frames/1")
    assert answer.status_code == 409
    assert "leads through a link out of the folders" in answer.json()["error"]["message"]


def test_links_that_stay_inside_are_followed(server: Server) -> None:
    home = server.settings.home
    (home / "real").mkdir()
    write_video(home / "real" / "drive.mp4", WHITE)
    (home / "folder").symlink_to(home / "real")
    (home / "file.mp4").symlink_to("real/drive.mp4")
    first = add_video(server, home / "folder" / "drive.mp4")
    assert add_video(server, home / "file.mp4") == first
    assert shade(server, first) == WHITE
    # the folder moves, and a link replaces it
    (home / "real").rename(home / "moved")
    (home / "real").symlink_to(home / "moved")
    server.context.frames.forget(first)
    assert shade(server, first) == WHITE


def test_a_video_of_an_earlier_root_is_still_read(tmp_path: Path) -> None:
    path = write_video(tmp_path / "drive.mp4", WHITE)
    before = Server(tmp_path / "home", roots=(tmp_path,))
    with before.client:
        video = add_video(before, path)
    after = Server(tmp_path / "home", roots=(tmp_path / "home",))
    with after.client:
        assert shade(after, video) == WHITE


def test_an_overwritten_video_with_restored_size_and_time_has_changed(server: Server) -> None:
    path = write_video(server.settings.home / "drive.mp4", WHITE)
    video = add_video(server, path)
    assert shade(server, video) == WHITE
    run = server.client.post(f"/api/videos/{video}/runs", json={}).json()["id"]
    before, white = path.stat(), path.read_bytes()
    black = write_video(server.settings.home / "black.mp4", BLACK).read_bytes()
    with path.open("r+b") as file:
        file.write(black[: before.st_size].ljust(before.st_size, b"\0"))
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    after = path.stat()
    assert (after.st_size, after.st_mtime_ns, after.st_ino) == (before.st_size, before.st_mtime_ns, before.st_ino)
    answer = server.client.get(f"/api/videos/{video}/frames/3")
    assert (answer.status_code, answer.json()["error"]["code"]) == (409, "file_changed")
    run_jobs(server.context, "track")
    reported = server.client.get(f"/api/runs/{run}").json()
    assert reported["state"] == "failed"
    assert "has changed since it was added" in reported["error"]
    path.write_bytes(white)
    assert shade(server, video) == WHITE


@pytest.mark.parametrize("kernel", ["new", "old"])
def test_no_part_of_a_path_beneath_a_folder_is_a_link(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kernel: str
) -> None:
    if kernel == "old":

        def closed(*_: object) -> int:
            raise OSError(errno.ENOSYS, "no such call")

        monkeypatch.setattr(safe_open, "openat2", closed)
    root = tmp_path / "root"
    (root / "a" / "b").mkdir(parents=True)
    (root / "a" / "b" / "file").write_bytes(b"inside")
    (root / "link").symlink_to(root / "a")
    (root / "a" / "last").symlink_to(root / "a" / "b" / "file")
    (root / "proc").symlink_to("/proc/self/root")

    def read(*parts: str) -> bytes:
        descriptor = open_inside(root, root.joinpath(*parts))
        with os.fdopen(descriptor, "rb") as file:
            assert not os.get_inheritable(descriptor)
            return file.read()

    assert read("a", "b", "file") == b"inside"
    for parts in (("link", "b", "file"), ("a", "last"), ("proc", "etc", "passwd")):
        with pytest.raises(OSError, match=".") as refused:
            read(*parts)
        assert refused.value.errno in LINK_ERRORS
    with pytest.raises(FileNotFoundError):
        read("a", "none")
    os.mkfifo(root / "pipe")
    os.close(open_inside(root, root / "pipe"))  # does not wait for a writer
    os.close(open_inside(root, root, os.O_DIRECTORY))


def test_a_link_that_becomes_a_file_during_resolution_does_not_crash(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, resolve = write_video(server.settings.home / "drive.mp4", WHITE), os.path.realpath

    def exchanged(path: str | Path) -> str:
        if Path(path) == place:
            raise OSError(errno.EINVAL, "Invalid argument", str(path))
        return resolve(path)

    with monkeypatch.context() as patched:
        patched.setattr(os.path, "realpath", exchanged)
        answer = server.client.post("/api/videos", json={"path": str(place)})
    assert answer.status_code in (201, 403), answer.text
