"""Frames decoded around the displayed frame."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from app.videos.decoding import Decoder, LocalDecoder
from app.videos.frame_server import FrameServer, FrameServerClosedError, prefetch_order
from app.videos.picture_cache import PictureCache
from app.videos.previews import Previews
from tests.io import video_corpus
from tsr_engine.io.video import Frame, open_video


def none(folder: Path) -> Previews:
    """No preview copy."""

    def opened(source: object) -> Decoder:
        raise AssertionError(source)

    return Previews(folder / "none.mp4", 1, opened)


@pytest.mark.parametrize("direction", [-1, 0, 1])
@pytest.mark.parametrize("ordinal", [0, 7, 8, 30, 49])
def test_neighbouring_frames_are_listed_once_in_viewing_direction(ordinal: int, direction: int) -> None:
    frames = list(prefetch_order(ordinal, direction, 50))
    assert len(set(frames)) == len(frames)
    assert all(0 <= k < 50 and k != ordinal for k in frames)
    assert direction == 0 or all((k > ordinal) == (direction > 0) for k in frames)
    if direction >= 0 and ordinal < 49:
        assert frames[0] == ordinal + 1
    if direction < 0 and ordinal:
        assert ordinal - 1 in frames


def test_going_back_caches_the_next_frames_within_its_limit(tmp_path: Path) -> None:
    path = video_corpus.make(video_corpus.RECIPES["b_frames"], tmp_path, "b").path
    with open_video(path) as file:
        table = file.confirm()
    for most, held in ((2**20, True), (1, False)):
        cache = PictureCache(most)
        frame_server = FrameServer("v", LocalDecoder(open_video(path, table=table)), table, cache, (), none(tmp_path))
        frame_server.get(40, frame_server.served_width(None), "jpeg")
        frame_server.get(39, frame_server.served_width(None), "jpeg")
        pause = threading.Event()
        for _ in range(300):
            if ("v", 24, 96, "jpeg") in cache or not held:
                break
            pause.wait(0.01)
        assert (("v", 24, 96, "jpeg") in cache) == held
        frame_server.close()
        with pytest.raises(FrameServerClosedError):
            frame_server.read(0)


def test_neighbours_in_any_order_cost_one_jump(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FrameServer, "_prefetch", lambda frame_server: None)
    path = video_corpus.make(video_corpus.RECIPES["long_gop"], tmp_path, "long").path
    with open_video(path) as file:
        table = file.confirm()
    video = open_video(path, table=table)
    read, jumps = video.read, []

    def counted(ordinal: int) -> Frame:
        if ordinal < video.position:
            jumps.append(ordinal)
        return read(ordinal)

    monkeypatch.setattr(video, "read", counted)
    frame_server = FrameServer("v", LocalDecoder(video), table, PictureCache(2**22), (), none(tmp_path))
    try:
        frame_server.get(45, frame_server.served_width(None), "jpeg")
        for k in (34, 30, 33, 31, 32, 29, 28):  # in the order of threads
            frame_server.get(k, frame_server.served_width(None), "jpeg")
        assert len(jumps) == 1
    finally:
        frame_server.close()
