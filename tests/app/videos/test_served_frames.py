"""Frame k of every unusual file: the page gets the engine's frame, checked by the bar code in the pixels."""

from __future__ import annotations

import os
import random
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from app.videos.picture_cache import PictureCache
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server
from tests.io import video_corpus
from tsr_engine.io.video import open_video

KINDS = (
    *("constant", "variable", "b_frames", "open_gop", "edit_list", "rotated_90", "odd_size"),
    *("m2ts", "ps", "raw_h264", "raw_hevc", "flv", "wmv", "gif", "apng", "webp"),
    *("ts_wrap", "untimed_start", "avi_repeats", "wide_pixels_rotated"),
)


def _file(kind: str, folder: Path) -> Any:
    folder.mkdir(parents=True, exist_ok=True)
    return video_corpus.maker(folder)(kind)


def _add(server: Server, path: Path) -> str:
    answer = server.client.post("/api/videos", json={"path": str(path)})
    assert answer.status_code == 201, answer.text
    run_jobs(server.context, "import")
    video: str = answer.json()["id"]
    assert server.client.get(f"/api/videos/{video}").json()["state"] == "ready"
    return video


def _picture(server: Server, video: str, k: int, query: str = "") -> np.ndarray:
    answer = server.client.get(f"/api/videos/{video}/frames/{k}{query}")
    assert answer.status_code == 200, answer.text
    assert answer.headers["x-frame-ordinal"] == str(k)
    picture = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return picture


@pytest.mark.parametrize("kind", KINDS)
def test_every_frame_is_the_requested_one(server: Server, kind: str) -> None:
    if kind not in (*video_corpus.RECIPES, "edit_list"):
        pytest.fail(f"the corpus has no {kind}: {sorted(video_corpus.RECIPES)}")
    made = _file(kind, server.settings.home)
    video = _add(server, made.path)
    table = server.client.get(f"/api/videos/{video}/table").json()
    assert table["frames"] == len(made.codes)
    order = list(range(len(made.codes)))
    random.Random(1).shuffle(order)
    steps = [*order[:20], *range(10, 0, -1), *range(5)]
    with open_video(made.path) as engine:
        for k in steps:
            picture = _picture(server, video, k)
            assert video_corpus.read_code(picture) == made.codes[k], f"frame {k}"
            seen = engine.read(k).picture
            assert picture.shape == seen.shape
            assert np.abs(picture.astype(int) - seen).mean() < (24 if kind == "gif" else 12)  # JPEG loss
    # the page computes times from the run-length table: they equal the file's
    pts, base = table["first_pts"], table["time_base"]
    times = [pts]
    for step, count in table["steps"]:
        for _ in range(count):
            times.append(times[-1] + step)
    seconds = [t * base[0] / base[1] for t in times]
    assert seconds == pytest.approx([float(t) for t in made.times], abs=1e-6)


def test_the_pixel_aspect_ratio_is_stored_with_the_video(server: Server) -> None:
    """Pictures and coordinates are in stored pixels; the thumbnail has the true shape."""
    video = _add(server, _file("wide_pixels", server.settings.home).path)
    about = server.client.get(f"/api/videos/{video}").json()
    assert (about["width"], about["height"]) == (96, 64)
    assert about["pixel_ratio"] == pytest.approx(4 / 3)
    assert "shown as 128x64" in about["warnings"][0]
    assert _picture(server, video, 3).shape == (64, 96, 3)
    small = server.client.get(f"/api/videos/{video}/thumbnail").content
    assert cv2.imdecode(np.frombuffer(small, np.uint8), cv2.IMREAD_COLOR).shape == (64, 128, 3)
    plain = _add(server, _file("constant", server.settings.home).path)
    assert server.client.get(f"/api/videos/{plain}").json()["pixel_ratio"] == 1


def test_widths_and_formats(server: Server) -> None:
    made = _file("constant", server.settings.home)
    video = _add(server, made.path)
    own = _picture(server, video, 3)
    assert _picture(server, video, 3, "?width=4000").shape == own.shape  # never enlarged
    webp = server.client.get(f"/api/videos/{video}/frames/3?format=webp")
    assert webp.headers["content-type"] == "image/webp"
    assert webp.content[8:12] == b"WEBP"
    again = server.client.get(f"/api/videos/{video}/frames/3", headers={"If-None-Match": '"x"'})
    assert again.status_code == 200
    tag = again.headers["etag"]
    assert server.client.get(f"/api/videos/{video}/frames/3", headers={"If-None-Match": tag}).status_code == 304
    assert "immutable" in again.headers["cache-control"]
    assert server.client.get(f"/api/videos/{video}/frames/{len(made.codes)}").status_code == 404


def test_many_readers_at_once_get_their_own_frames(server: Server) -> None:
    made = _file("b_frames", server.settings.home)
    video = _add(server, made.path)
    wrong: list[tuple[int, int]] = []

    def read(seed: int) -> None:
        rng = random.Random(seed)
        for _ in range(25):
            k = rng.randrange(len(made.codes))
            served = server.context.frames.picture(video, k, None, "jpeg")
            code = video_corpus.read_code(cv2.imdecode(np.frombuffer(served.data, np.uint8), cv2.IMREAD_COLOR))
            if code != made.codes[k]:
                wrong.append((k, code))

    with ThreadPoolExecutor(6) as threads:
        list(threads.map(read, range(6)))
    assert wrong == []


def test_stepping_hits_the_cache(server: Server) -> None:
    video = _add(server, _file("b_frames", server.settings.home).path)
    frames = server.context.frames
    frames.picture(video, 5, None, "jpeg")
    frame_server = frames.open_servers[video]
    for _ in range(200):
        if (video, 12, frame_server.served_width(None), "jpeg") in frames.cache:
            break
        threading.Event().wait(0.01)
    assert (video, 12, frame_server.served_width(None), "jpeg") in frames.cache, "nothing was decoded ahead"


def test_the_cache_is_bounded() -> None:
    cache = PictureCache(1000)
    for k in range(50):
        cache.put(k, b"x" * 100)
    assert cache.size <= 1000
    assert cache.get(49) is not None
    assert cache.get(0) is None
    cache.put(49, b"y")
    assert cache.get(49) == b"y"
    cache.put("large", b"z" * 5000)
    assert cache.get("large") is not None
    assert cache.size == 5000


def test_a_changed_or_missing_file_is_reported(server: Server) -> None:
    made = _file("constant", server.settings.home)
    video = _add(server, made.path)
    content = made.path.read_bytes()
    os.utime(made.path, ns=(1, 1))
    assert server.client.get(f"/api/videos/{video}/frames/0").status_code == 200
    made.path.write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
    answer = server.client.get(f"/api/videos/{video}/frames/0")
    assert (answer.status_code, answer.json()["error"]["code"]) == (409, "file_changed")
    assert server.client.post(f"/api/videos/{video}/runs", json={}).status_code == 202
    made.path.unlink()
    assert server.client.get(f"/api/videos/{video}/frames/0").status_code == 404
    assert server.client.get(f"/api/videos/{video}").json()["missing"] is True
    # found elsewhere: the same video with all its data
    moved = server.settings.home / "moved.mp4"
    moved.write_bytes(content)
    assert server.client.post("/api/videos", json={"path": str(moved)}).json()["id"] == video
    assert server.client.get(f"/api/videos/{video}/frames/0").status_code == 200
    assert server.client.get(f"/api/videos/{video}").json()["runs"] == 1


def test_simultaneous_requests_open_the_file_once(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    made = _file("constant", server.settings.home)
    video = _add(server, made.path)
    frames = server.context.frames
    frames.forget(video)
    opened, load = [], frames.load

    def slow(video_id: str) -> Any:
        opened.append(video_id)
        time.sleep(0.05)
        return load(video_id)

    monkeypatch.setattr(frames, "load", slow)
    with ThreadPoolExecutor(5) as pool:
        served = list(pool.map(lambda k: frames.picture(video, k, None, "jpeg"), range(5)))
    assert [one.ordinal for one in served] == list(range(5))
    assert opened == [video]
