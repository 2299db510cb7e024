"""Unusual properties of a video are reported, each in a sentence, and its frames are right."""

from __future__ import annotations

import struct
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.io import video_corpus
from tsr_engine.io.video import open_video
from tsr_engine.io.video_decoder import Decoder

MakeVideo = Callable[[str], Any]


def reported(path: Path, codes: list[int], times: list[Fraction] | None = None) -> tuple[str, ...]:
    """Warnings about a file with these codes, checked in sequence and in random order."""
    with open_video(path) as video:
        frames = list(video.frames())
        assert [video_corpus.read_code(frame.picture) for frame in frames] == codes
        assert not any(frame.corrupt for frame in frames)
        if times is not None:
            assert [frame.time for frame in frames] == times
        warnings = video.warnings
    with open_video(path) as video:  # nothing is known yet
        for k in np.random.default_rng(5).permutation(len(codes)):
            again = video.read(int(k))
            assert np.array_equal(again.picture, frames[k].picture), f"frame {k} differs by random access"
            assert again.time == frames[k].time
    for warning in warnings:
        assert warning.startswith(path.name)
        assert "\n" not in warning
    return warnings


@pytest.mark.parametrize(
    "kind",
    [
        *("ts", "ts_open_gop", "ts_mpeg2_interlaced", "ts_odd_size", "ts_wrap", "m2ts"),
        *("ps", "flv", "wmv", "gif", "apng", "webp"),
    ],
)
def test_a_plain_video_has_no_warnings(make_video: MakeVideo, kind: str) -> None:
    assert reported(make_video(kind).path, make_video(kind).codes, make_video(kind).times) == ()


def test_a_raw_stream_states_its_frame_rate_or_gets_one(make_video: MakeVideo, tmp_path: Path) -> None:
    (warning,) = reported(make_video("raw_h264").path, make_video("raw_h264").codes, make_video("raw_h264").times)
    assert "stores no times: its frames are timed at 25 frames a second, as its header says." in warning
    recipe = video_corpus.RECIPES["raw_hevc"]
    options = {**recipe.options, "x265-params": recipe.options["x265-params"] + ":vui-timing-info=0"}
    silent = video_corpus.make(video_corpus.Recipe(".hevc", "libx265", options, count=30), tmp_path, "silent")
    (warning,) = reported(silent.path, silent.codes, silent.times)
    assert "at 25 frames a second, which is assumed, because it says no rate." in warning


def test_packets_without_times_are_not_damage(make_video: MakeVideo) -> None:
    """The first pictures of an MKV have no times (V14, PyAV-Org/PyAV#1105)."""
    truth = make_video("untimed_start")
    (warning,) = reported(truth.path, truth.codes, truth.times)
    assert "has 30 frames without a time of their own, timed at 25 frames a second" in warning


def test_h264_in_a_program_stream(tmp_path: Path) -> None:
    recipe = video_corpus.Recipe(".vob", options=video_corpus.x264(bf="2"), format="vob")
    truth = video_corpus.make(recipe, tmp_path, "recorder")
    (warning,) = reported(truth.path, truth.codes)
    assert "without a time of their own" in warning
    with open_video(truth.path) as video:
        assert set(np.diff(video.confirm().pts)) == {3600}


@pytest.mark.parametrize(
    ("kind", "ratio", "words"),
    [
        (
            "wide_pixels",
            Fraction(4, 3),
            "(4:3): its 96x64 pictures are shown as 128x64. Coordinates are those of 96x64.",
        ),
        ("wide_pixels_ps", Fraction(8, 9), "(8:9): its 96x64 pictures are shown as 85x64."),
        ("wide_pixels_rotated", Fraction(3, 4), "(3:4): its 96x64 pictures are shown as 72x64."),
    ],
)
def test_non_square_pixels(make_video: MakeVideo, kind: str, ratio: Fraction, words: str) -> None:
    """V04 (opencv/opencv#4921, JuliaIO/VideoIO.jl#185)."""
    truth = make_video(kind)
    (warning,) = reported(truth.path, truth.codes, truth.times)
    assert words in warning
    with open_video(truth.path) as video:
        assert video.pixel_ratio == ratio
        assert (video.width, video.height) == truth.size


@pytest.mark.parametrize("kind", ["ts", "ps", "matroska_variable"])
def test_restarted_times_continue(make_video: MakeVideo, tmp_path: Path, kind: str) -> None:
    """Segments joined by ``cat`` (V31)."""
    part = make_video(kind)
    both = video_corpus.joined(tmp_path / f"both{part.path.suffix}", part, part)
    (warning,) = reported(both.path, both.codes, both.times if kind != "matroska_variable" else None)
    assert "has times that run back at frame 50 (from " in warning
    with open_video(both.path) as video:
        table = video.confirm()
        assert (np.diff(table.pts) > 0).all()
        assert not video.stamps_are_times


def test_a_later_part_of_a_joined_file_is_reached_without_decoding_all_before(
    make_video: MakeVideo, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = make_video("matroska_variable")
    both = video_corpus.joined(tmp_path / "both.mkv", part, part)
    with open_video(both.path) as video:
        table = video.confirm()
    decoded = []
    plain = Decoder.decode
    monkeypatch.setattr(Decoder, "decode", lambda self, packet: decoded.append(packet) or plain(self, packet))
    with open_video(both.path, table=table) as video:
        for k in (99, 70, 60, 3, 51):
            decoded.clear()
            assert video_corpus.read_code(video.read(k).picture) == both.codes[k]
            assert len(decoded) < 25


def test_a_third_matroska_video_is_not_read(make_video: MakeVideo, tmp_path: Path) -> None:
    """FFmpeg continues to a second one only."""
    part = make_video("matroska_variable")
    three = video_corpus.joined(tmp_path / "three.mkv", part, part, part)
    first, second = reported(three.path, three.codes[:100])
    assert "holds 3 videos joined end to end, of which only the first 2 are read (100 frames)." in first
    assert "has times that run back at frame 50" in second


@pytest.mark.parametrize("kind", ["constant", "flv", "wmv"])
def test_an_unread_second_video_is_reported(make_video: MakeVideo, tmp_path: Path, kind: str) -> None:
    part = make_video(kind)
    both = video_corpus.joined(tmp_path / f"both{part.path.suffix}", part, part)
    (warning,) = reported(both.path, part.codes)
    assert "holds 2 videos joined end to end, of which only the first is read (50 frames)." in warning


def test_joined_avi_files_are_read_completely(make_video: MakeVideo, tmp_path: Path) -> None:
    part = make_video("avi_mjpeg")
    both = video_corpus.joined(tmp_path / "both.avi", part, part)
    (warning,) = reported(both.path, both.codes, both.times)
    assert "all 24 frames are read, though it announces 12." in warning


def test_a_joined_raw_stream_continues(make_video: MakeVideo, tmp_path: Path) -> None:
    part = make_video("raw_h264")
    both = video_corpus.joined(tmp_path / "both.h264", part, part)
    assert len(reported(both.path, both.codes, both.times)) == 1


def test_empty_chunks_are_repeats(make_video: MakeVideo, tmp_path: Path) -> None:
    """An AVI with dropped frames is not truncated (V34, FFMS/ffms2#3)."""
    truth = make_video("avi_repeats")
    (warning,) = reported(truth.path, truth.codes, truth.times)
    assert "announces 20 frames, of which 8 are repeats of the picture before" in warning
    path = video_corpus.cut(truth, tmp_path / "cut.avi", 0.8)
    with open_video(path) as video:
        video.confirm()
        assert video.warnings[0].endswith("the file is cut short.")
        assert any("8 are repeats" in warning for warning in video.warnings)
    content = bytearray(truth.path.read_bytes())
    struct.pack_into("<I", content, content.index(b"strh") + 8 + 32, 25)
    (path := tmp_path / "boast.avi").write_bytes(content)
    with open_video(path) as video:
        video.confirm()
        assert "announces 25 frames, 12 decode though the file is whole: its header is wrong" in video.warnings[0]


@pytest.mark.parametrize(
    ("kind", "packet", "unit", "begins"),
    [
        ("ts", 17, 188, 24),
        ("ts", 17, 1, 24),
        ("m2ts", 5, 192, 12),
        ("raw_h264", 17, 1, 24),
        ("ts_open_gop", 5, 188, 12),
    ],
)
def test_a_stream_that_begins_between_key_frames(
    make_video: MakeVideo, tmp_path: Path, kind: str, packet: int, unit: int, begins: int
) -> None:
    truth = make_video(kind)
    path = video_corpus.without_start(truth, tmp_path / f"later{truth.path.suffix}", packet, unit)
    with open_video(path) as video:
        frames = list(video.frames())
        codes = [video_corpus.read_code(frame.picture) for frame in frames]
        assert codes == truth.codes[begins:]
        assert not any(frame.corrupt for frame in frames)
        if kind != "raw_h264":
            assert [frame.time for frame in frames] == truth.times[begins:]
        assert " begins between key frames: its first " in video.warnings[0]
        assert "damage" not in " ".join(video.warnings)
        for k in range(len(frames) - 1, -1, -5):
            assert np.array_equal(video.read(k).picture, frames[k].picture)


def test_pictures_of_another_size_are_scaled(make_video: MakeVideo, tmp_path: Path) -> None:
    small = video_corpus.make(
        video_corpus.Recipe(".h264", options=video_corpus.x264(), size=(192, 128), count=10), tmp_path, "small"
    )
    path = tmp_path / "two.h264"
    path.write_bytes(make_video("raw_h264").path.read_bytes() + small.path.read_bytes())
    with open_video(path) as video:
        frames = list(video.frames())
        assert {frame.picture.shape for frame in frames} == {(64, 96, 3)}
        assert len(frames) == 60
        assert np.array_equal(video.read(55).picture, frames[55].picture)
        words = "changes the size of its pictures, 96x64 at first: 192x128 from frame 50 on. All are scaled to 96x64"
        assert any(words in warning for warning in video.warnings)


@pytest.mark.parametrize("suffix", [".mp4", ".ts", ".mkv"])
def test_the_first_of_several_streams_is_read(tmp_path: Path, suffix: str) -> None:
    path = video_corpus.make_two_streams(tmp_path / f"twin{suffix}")
    (warning,) = reported(path, list(range(10)))
    assert "has 2 video streams: the first is read (96x64 h264), not 128x64 h264." in warning


@pytest.mark.parametrize("packet", [15, 30, 41, 55])
def test_lost_packets_of_a_transport_stream_are_damage(make_video: MakeVideo, tmp_path: Path, packet: int) -> None:
    """Whole pictures may be missing without a decoder error; packet counters show it."""
    content = make_video("ts").path.read_bytes()
    path = tmp_path / "holed.ts"
    path.write_bytes(content[: 188 * packet] + content[188 * (packet + 3) :])
    with open_video(path) as video:
        frames = list(video.frames())
        assert any(frame.corrupt for frame in frames)
        assert "with damage, or predicted from damage." in " ".join(video.warnings)
        for k in np.random.default_rng(3).permutation(len(frames)):
            again = video.read(int(k))
            assert again.corrupt == frames[k].corrupt
            assert again.corrupt or np.array_equal(again.picture, frames[k].picture)


@pytest.mark.parametrize("kind", ["gif", "apng", "wmv", "flv"])
def test_truncated_files_of_the_new_kinds_are_reported(make_video: MakeVideo, tmp_path: Path, kind: str) -> None:
    path = video_corpus.cut(make_video(kind), tmp_path / f"cut{make_video(kind).path.suffix}", 0.6)
    with open_video(path) as video:
        n = len(video.confirm())
        assert 5 < n < 50
        assert any(warning.endswith("the file is cut short.") for warning in video.warnings)


@pytest.mark.parametrize("kind", ["gif", "apng", "webp"])
def test_pictures_without_duration_are_reported(make_video: MakeVideo, tmp_path: Path, kind: str) -> None:
    content = bytearray(make_video(kind).path.read_bytes())
    mark, place, size = {"gif": (b"\x21\xf9\x04", 4, 2), "apng": (b"fcTL", 24, 2), "webp": (b"ANMF", 20, 3)}[kind]
    at = -1
    while (at := content.find(mark, at + 1)) >= 0:
        content[at + place : at + place + size] = bytes(size)
        if kind == "apng":
            import zlib

            struct.pack_into(">I", content, at + 30, zlib.crc32(content[at : at + 30]))
    path = tmp_path / f"still{make_video(kind).path.suffix}"
    path.write_bytes(content)
    (warning,) = reported(path, make_video(kind).codes)
    assert "has 50 pictures that stay for no time: each gets a short one, as in players." in warning
    with open_video(path) as video:
        assert (np.diff(video.confirm().pts) > 0).all()


def test_a_gif_of_one_picture_is_a_video_of_one_frame(tmp_path: Path) -> None:
    truth = video_corpus.make(video_corpus.Recipe(".gif", "gif", pix_fmt="rgb8", count=1), tmp_path, "one")
    assert reported(truth.path, [0]) == ()
