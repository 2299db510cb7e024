"""Files that are not videos or too large are refused in one sentence; damaged videos are read up to the damage."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.io import video_corpus
from tsr_engine.errors import VideoError
from tsr_engine.io.digest import file_sha256
from tsr_engine.io.video import VideoLimits, open_video, video_sha256
from tsr_engine.io.video_kinds import Kind

MakeVideo = Callable[[str], Any]


def error_message(path: Path, limits: VideoLimits | None = None) -> str:
    """The error message of opening a file: one line that names the file."""
    with pytest.raises(VideoError) as caught:
        open_video(path, limits=limits)
    message = str(caught.value)
    assert caught.value.exit_code == 3
    assert str(path) in message
    assert "\n" not in message
    assert caught.value.__cause__ is None, "no library exception shows through"
    return message


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    assert "There is no video at" in error_message(tmp_path / "absent.mp4")


def test_a_folder_is_refused(tmp_path: Path) -> None:
    assert "is a folder" in error_message(tmp_path)


def test_an_empty_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "void.mp4"
    path.touch()
    assert "is empty (0 bytes)" in error_message(path)


def test_a_pipe_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "pipe.mp4"
    os.mkfifo(path)
    assert "is not a regular file" in error_message(path)


def test_an_invalid_file_name_is_refused() -> None:
    with pytest.raises(VideoError, match="is no file name"):
        open_video("a\0b.mp4")


@pytest.mark.parametrize(
    "content",
    [
        b"\x89PNG\r\n\x1a\n" + bytes(100),
        b"hello",
        bytes(range(256)) * 40,
        b"RIFF\x00\x00\x00\x00WAVEfmt ",
        b"<?xml version='1.0'?><MPD><BaseURL>/etc/passwd</BaseURL></MPD>",
    ],
)
def test_a_file_that_is_no_video_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.mp4"
    path.write_bytes(content)
    assert "is not a video" in error_message(path)


@pytest.mark.parametrize(
    "playlist",
    [
        "#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\n{0}\n#EXT-X-ENDLIST\n",
        "ffconcat version 1.0\nfile '{0}'\n",
        "v=0\no=- 0 0 IN IP4 127.0.0.1\nm=video 5004 RTP/AVP 96\n",
    ],
)
def test_playlists_open_no_other_file(make_video: MakeVideo, tmp_path: Path, playlist: str) -> None:
    path = tmp_path / "x.mp4"
    path.write_text(playlist.format(make_video("constant").path))
    assert "is not a video" in error_message(path)


@pytest.mark.parametrize("demuxer", ["mov", "hls", "concat", "sdp", "dash", "image2"])
def test_the_demuxer_itself_refuses_playlists(
    make_video: MakeVideo, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, demuxer: str
) -> None:
    """A second defence: no demuxer that opens other files is allowed."""
    monkeypatch.setattr("tsr_engine.io.video_probe.check_file", lambda _: Kind("MP4", demuxer))
    for playlist in ("#EXTM3U\n#EXTINF:9,\n{0}\n#EXT-X-ENDLIST\n", "ffconcat version 1.0\nfile '{0}'\n"):
        path = tmp_path / "x.mp4"
        path.write_text(playlist.format(make_video("constant").path.name))
        assert "cannot be opened as a video" in error_message(path)


def test_the_head_of_a_video_alone(tmp_path: Path) -> None:
    path = tmp_path / "x.mp4"
    path.write_bytes(b"\0\0\0\x18ftypisom\0\0\2\0isomiso2" + bytes(1000))
    error_message(path)


def test_a_file_with_only_sound_is_refused(tmp_path: Path) -> None:
    assert "holds only sound" in error_message(video_corpus.make_sound(tmp_path / "song.mp4"))


def test_a_video_without_frames_is_refused(tmp_path: Path) -> None:
    assert "has no frame that can be decoded" in error_message(video_corpus.make_empty(tmp_path / "none.mp4"))


def test_a_file_without_its_index_is_refused(make_video: MakeVideo, tmp_path: Path) -> None:
    """An MP4 with its index at the end cannot be read without it."""
    assert "damaged or cut short" in error_message(video_corpus.cut(make_video("constant"), tmp_path / "x.mp4", 0.6))


@pytest.mark.parametrize("admit", [True, False])
def test_huge_pictures_are_refused_before_they_are_allocated(
    make_video: MakeVideo, tmp_path: Path, admit: bool
) -> None:
    path = video_corpus.make_huge(make_video("mov_mjpeg"), tmp_path / "huge.mov", admit=admit)
    script = (
        "import resource, sys\n"
        "from tsr_engine.errors import VideoError\n"
        "from tsr_engine.io.video import open_video\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "limit = 2 * 2**30\n"
        "resource.setrlimit(resource.RLIMIT_AS, (limit, limit))\n"
        "try:\n    open_video(sys.argv[1])\n"
        "except VideoError as error:\n    print(error)\n"
        "print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024)\n"
    )
    result = subprocess.run([sys.executable, "-c", script, str(path)], capture_output=True, text=True, check=True)
    message, grown = result.stdout.splitlines()
    assert str(path) in message
    assert result.stderr == ""
    assert int(grown) < 60, "16000x16000 takes 384 MB in YUV alone"


def test_limits_are_given_by_the_caller(make_video: MakeVideo) -> None:
    path = make_video("constant").path
    assert "96x64, more than the limit of 6143 pixels" in error_message(path, VideoLimits(max_pixels=96 * 64 - 1))
    assert "96x64" in error_message(path, VideoLimits(max_side=95))
    with open_video(path, limits=VideoLimits(max_pixels=96 * 64, max_side=96)) as video:
        assert video.width == 96


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_an_unreadable_file_is_refused(make_video: MakeVideo, tmp_path: Path) -> None:
    path = tmp_path / "locked.mp4"
    path.write_bytes(make_video("single").path.read_bytes())
    path.chmod(0)
    assert "Permission denied" in error_message(path)


def test_a_truncated_file_is_read_to_the_end(make_video: MakeVideo, tmp_path: Path) -> None:
    path = video_corpus.cut(make_video("index_first"), tmp_path / "cut.mp4", 0.6)
    with open_video(path) as video:
        frames = list(video.frames())
        n = len(frames)
        assert 5 < n < 50
        assert [video_corpus.read_code(frame.picture) for frame in frames] == list(range(n))
        assert f"cut.mp4 announces 50 frames, {n} decode: the file is cut short." in video.warnings
        for k in range(n - 1, -1, -3):
            frame = video.read(k)
            assert frame.corrupt or np.array_equal(frame.picture, frames[k].picture)


@pytest.mark.parametrize(("kind", "words"), [("matroska_variable", "announces 2.0 s"), ("avi_h264", "announces 50")])
def test_truncated_files_of_other_containers(make_video: MakeVideo, tmp_path: Path, kind: str, words: str) -> None:
    path = video_corpus.cut(make_video(kind), tmp_path / f"cut{make_video(kind).path.suffix}", 0.6)
    with open_video(path) as video:
        frames = list(video.frames())
        assert 5 < len(frames) < 50
        assert words in video.warnings[0]
        assert video.warnings[0].endswith("the file is cut short.")
        for frame in frames:
            assert frame.corrupt or video_corpus.read_code(frame.picture) == frame.ordinal
            again = video.read(frame.ordinal)
            assert frame.corrupt or np.array_equal(again.picture, frame.picture)


def test_an_edit_list_is_not_a_truncation(make_video: MakeVideo) -> None:
    with open_video(make_video("edit_list").path) as video:
        video.confirm()
        assert video.warnings == ("edit_list.mp4 announces 50 frames, 30 decode: its edit list hides 20.",)


@pytest.mark.parametrize("kind", ["constant", "b_frames", "open_gop", "hevc"])
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(positions=st.lists(st.floats(0, 1), min_size=1, max_size=5), seed=st.integers(0, 99))
def test_flipped_bits_never_crash(
    make_video: MakeVideo, tmp_path_factory: pytest.TempPathFactory, kind: str, positions: list[float], seed: int
) -> None:
    """Damage never crashes, is flagged or counted, and leaves unflagged pictures the same in both kinds of access.

    FFmpeg's HEVC decoder ignores some damage without a message; the picture then depends on earlier pictures.
    """
    path = video_corpus.flip_bits(make_video(kind), tmp_path_factory.mktemp("flip") / "x.mp4", positions)
    try:
        video = open_video(path)
    except VideoError:
        return
    with video:
        frames = list(video.frames())
        if any(frame.corrupt for frame in frames) or len(frames) < len(make_video(kind).codes):
            assert video.warnings
        order = np.random.default_rng(seed).permutation(len(frames))
        for k in order[:12]:
            again = video.read(int(k))
            assert again.time == frames[k].time
            assert again.corrupt == frames[k].corrupt
            assert again.corrupt or kind == "hevc" or np.array_equal(again.picture, frames[k].picture)


def test_identity_is_the_hash_of_the_bytes(tmp_path: Path) -> None:
    path = tmp_path / "abc"
    path.write_bytes(b"abc")
    assert video_sha256(path) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert file_sha256(path) == video_sha256(path)
    with pytest.raises(VideoError, match="There is no video at"):
        video_sha256(tmp_path / "absent")
    with pytest.raises(FileNotFoundError):
        file_sha256(tmp_path / "absent")
