"""A video is opened once: a file that replaces it is never read."""

from __future__ import annotations

import os
from pathlib import Path

import av
import numpy as np
import pytest

from tsr_engine.errors import VideoError
from tsr_engine.io.opened_file import OpenedFile, open_source
from tsr_engine.io.video import open_video
from tsr_engine.io.video_probe import check_file, video_sha256

FRAMES = 30


def write_video(path: Path, shade: int) -> Path:
    with av.open(str(path), "w") as out:
        stream = out.add_stream("mpeg4", rate=25)
        stream.width = stream.height = 64
        for _ in range(FRAMES):
            picture = np.full((64, 64, 3), shade, np.uint8)
            out.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
        out.mux(stream.encode(None))
    return path


@pytest.mark.parametrize("suffix", [".mp4", ".avi", ".mkv"])
def test_every_pass_reads_the_opened_file(tmp_path: Path, suffix: str) -> None:
    path, other = write_video(tmp_path / f"a{suffix}", 250), write_video(tmp_path / f"b{suffix}", 5)
    digest = video_sha256(path)
    with open_video(path) as video:
        other.replace(path)
        shades = [int(frame.picture.mean()) for frame in video.frames()]
        assert len(shades) == len(video.confirm()) == FRAMES
        assert min(shades) > 200
        assert video.read(3).picture.mean() > 200
        assert video.file.sha256() == digest
        assert [int(frame.picture.mean()) for frame in video.frames(10, 12, ahead=2)] == shades[10:12]
    assert video_sha256(path) != digest
    with pytest.raises(VideoError, match=r"is closed\. Open it again"):
        next(iter(video.frames()))


def test_every_reader_of_a_descriptor_starts_at_the_beginning(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"0123456789")
    with open_source(path) as file:
        with file.stream() as one, file.stream() as other:
            assert one.read(4) == b"0123"
            assert other.read(4) == b"0123"
        before = file.stamp
        path.write_bytes(b"0123456789")
        assert file.stamp[:2] == before[:2]
        assert file.stamp != before
    file.close()
    with pytest.raises(VideoError):
        file.reopen_path  # noqa: B018 - a property that refuses


def test_a_pipe_does_not_block(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(VideoError, match="not a regular file"):
        check_file(tmp_path / "pipe")
    with pytest.raises(VideoError, match="not a regular file"):
        video_sha256(tmp_path / "pipe")


def test_an_invalid_name_is_refused(tmp_path: Path) -> None:
    with pytest.raises(VideoError, match="is no file name"):
        OpenedFile.by_name(tmp_path / "a\0b")
