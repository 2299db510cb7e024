"""Frame k is the right picture, the same in sequential decoding and in random access."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.io import video_corpus
from tsr_engine.errors import UsageError, VideoError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.video import open_video

KINDS = [*video_corpus.RECIPES, *video_corpus.EDIT_LISTS]
MakeVideo = Callable[[str], Any]


def test_the_kinds_have_their_named_properties(make_video: MakeVideo) -> None:
    import av

    def leading(name: str) -> int:
        """Packets shown before the key frame that they follow in the file."""
        count, key = 0, -1
        with av.open(str(make_video(name).path)) as container:
            for packet in container.demux(video=0):
                if packet.size and packet.is_keyframe:
                    key = packet.pts
                elif packet.size:
                    count += packet.pts < key
        return count

    assert leading("open_gop") > 0
    assert leading("hevc") > 0
    assert leading("b_frames") == 0
    with av.open(str(make_video("avi_h264").path)) as container:
        kinds = {int(frame.pict_type) for frame in container.decode(video=0)}
    assert 3 in kinds, "the AVI file has bidirectional pictures"


@pytest.mark.parametrize("kind", KINDS)
def test_sequence_shows_the_right_pictures_at_exact_times(make_video: MakeVideo, kind: str) -> None:
    truth = make_video(kind)
    with open_video(truth.path) as video:
        frames = list(video.frames())
        assert (video.width, video.height) == truth.size
        assert video.rotation == truth.rotation
        assert [frame.ordinal for frame in frames] == list(range(len(truth.codes)))
        assert [video_corpus.read_code(frame.picture) for frame in frames] == truth.codes
        assert [frame.time for frame in frames] == truth.times
        assert all(isinstance(frame.time, Fraction) for frame in frames)
        assert not any(frame.corrupt for frame in frames)
        # An edit list may begin between key frames.
        assert frames[0].key or "edit_list" in kind
        for frame in frames:
            assert frame.picture.shape == (*truth.size[::-1], 3)
            assert frame.picture.dtype == np.uint8
            assert frame.picture.flags.c_contiguous


@pytest.mark.parametrize("kind", KINDS)
def test_every_frame_is_the_same_by_random_access(make_video: MakeVideo, kind: str) -> None:
    truth = make_video(kind)
    with open_video(truth.path) as video:
        pictures = [frame.picture for frame in video.frames()]
        for k in np.random.default_rng(7).permutation(len(pictures)):
            frame = video.read(int(k))
            assert frame.ordinal == k
            assert frame.time == truth.times[k]
            assert video_corpus.read_code(frame.picture) == truth.codes[k]
            assert np.array_equal(frame.picture, pictures[k]), f"frame {k} differs by random access"


@pytest.mark.parametrize("kind", ["variable", "open_gop", "avi_h264", "edit_list_open_gop", "matroska_variable"])
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_order_of_reads_without_a_previous_pass(make_video: MakeVideo, kind: str, data: st.DataObject) -> None:
    truth = make_video(kind)
    order = data.draw(st.lists(st.integers(0, len(truth.codes) - 1), min_size=1, max_size=12))
    with open_video(truth.path) as video:
        for k in order:
            frame = video.read(k)
            assert video_corpus.read_code(frame.picture) == truth.codes[k]
            assert frame.time == truth.times[k]


@pytest.mark.parametrize("kind", KINDS)
def test_the_scan_agrees_with_decoding(make_video: MakeVideo, kind: str) -> None:
    truth = make_video(kind)
    with open_video(truth.path) as video:
        promised = video.table
        assert not promised.complete or len(truth.codes) == 1
        confirmed = video.confirm()
        assert confirmed.complete
        assert confirmed.confirmed == len(confirmed) == len(truth.codes)
        assert [confirmed.time(k) for k in range(len(confirmed))] == truth.times
        assert np.array_equal(promised.pts, confirmed.pts)
        assert video.expected == len(truth.codes)


def test_opening_reads_one_frame_and_no_table(make_video: MakeVideo) -> None:
    with open_video(make_video("long_gop").path) as video:
        assert video.expected == 50, "the announced number, before any pass"
        assert video.warnings == ()
        assert video.codec == "h264"
        assert video.rate == 25


@pytest.mark.parametrize("kind", ["b_frames", "avi_h264", "edit_list_inside_gop"])
def test_ranges_are_slices_of_the_whole(make_video: MakeVideo, kind: str) -> None:
    with open_video(make_video(kind).path) as whole:
        pictures = [frame.picture for frame in whole.frames()]
    n = len(pictures)
    for start, stop in [(0, 5), (13, 20), (n - 1, None), (3, n + 10), (4, 4)]:
        with open_video(make_video(kind).path) as video:
            part = list(video.frames(start, stop))
            assert [frame.ordinal for frame in part] == list(range(n))[start:stop]
            for frame in part:
                assert np.array_equal(frame.picture, pictures[frame.ordinal])


def test_reads_with_a_stored_table_are_exact_without_a_pass(make_video: MakeVideo) -> None:
    truth = make_video("open_gop")
    with open_video(truth.path) as video:
        pictures = [frame.picture for frame in video.frames()]
        table = FrameTable.from_arrays(video.table.to_arrays())
    with open_video(truth.path, table=table) as video:
        assert video.table == table
        for k in (49, 3, 30, 31, 11):
            assert np.array_equal(video.read(k).picture, pictures[k])
    partial = FrameTable(
        table.time_base, table.pts[:20], table.stamps[:20], table.key[:20], table.corrupt[:20], 20, complete=False
    )
    with open_video(truth.path, table=partial) as video:
        rest = list(video.frames(20))
        assert [frame.ordinal for frame in rest] == list(range(20, 50))
        assert all(np.array_equal(frame.picture, pictures[frame.ordinal]) for frame in rest)
        assert video.table == table


def test_a_table_of_another_file_is_refused(make_video: MakeVideo) -> None:
    with open_video(make_video("constant").path) as video:
        table = video.confirm()
    with pytest.raises(VideoError, match="time base"):
        open_video(make_video("ntsc").path, table=table)
    shifted = FrameTable(table.time_base, table.pts + 7, table.stamps + 7, table.key, table.corrupt, 50, complete=True)
    with pytest.raises(VideoError, match=r"Frame 0 of .* is not the one in its frame table"):
        open_video(make_video("constant").path, table=shifted)
    later = table.stamps.copy()
    later[20:] += 1
    changed = FrameTable(table.time_base, later, later, table.key, table.corrupt, 50, complete=True)
    for read in (lambda video: list(video.frames()), lambda video: video.read(40)):
        with (
            open_video(make_video("constant").path, table=changed) as video,
            pytest.raises(VideoError, match="Frame 20 of"),
        ):
            read(video)


def test_frames_that_do_not_exist_are_refused(make_video: MakeVideo) -> None:
    with open_video(make_video("constant").path) as video:
        for k in (-1, 50, 10_000):
            with pytest.raises(UsageError, match=f"Got {k}"):
                video.read(k)
        assert video.read(49).ordinal == 49
        with pytest.raises(UsageError, match="0 to 49"):
            next(video.frames(50))
        with pytest.raises(UsageError, match="0 <= start <= stop"):
            video.frames(5, 4)


@pytest.mark.parametrize("ahead", [1, 4])
def test_reading_ahead_changes_nothing(make_video: MakeVideo, ahead: int) -> None:
    with open_video(make_video("b_frames").path) as video:
        plain = [frame.picture for frame in video.frames()]
        threaded = list(video.frames(ahead=ahead))
        assert [frame.ordinal for frame in threaded] == list(range(len(plain)))
        assert all(np.array_equal(frame.picture, plain[frame.ordinal]) for frame in threaded)


@pytest.mark.parametrize("kind", ["b_frames", "rotated_90", "rotated_180", "mirrored", "avi_h264"])
def test_reduced_pictures_are_the_same_frames(make_video: MakeVideo, kind: str) -> None:
    with open_video(make_video(kind).path) as video:
        width = video.width // 2
        small = list(video.frames(ahead=2, width=width))
        assert video.table.complete  # a complete pass
        height = round(video.height * width / video.width)
        for frame in small:
            assert frame.picture.shape == (height, width, 3)
            own = cv2.resize(video.read(frame.ordinal).picture, (width, height), interpolation=cv2.INTER_AREA)
            assert np.abs(frame.picture.astype(int) - own).mean() < 12.0  # edges differ by the scaler
            assert np.abs(frame.picture[::-1, ::-1].astype(int) - own).mean() > 24.0
        assert len(small) == len(video.table)
        assert next(video.frames(width=video.width + 1)).picture.shape == (video.height, video.width, 3)
        with pytest.raises(UsageError, match="Got 0"):
            video.frames(width=0)


def test_passes_and_reads_do_not_disturb_each_other(make_video: MakeVideo) -> None:
    with open_video(make_video("open_gop").path) as video:
        first, second = video.frames(ahead=2), video.frames(10)
        for k in range(12):
            assert video_corpus.read_code(next(first).picture) == k
            assert video_corpus.read_code(next(second).picture) == 10 + k
            assert video_corpus.read_code(video.read(49 - 4 * k).picture) == 49 - 4 * k


def test_leaving_early_stops_the_thread(make_video: MakeVideo) -> None:
    import threading

    with open_video(make_video("b_frames").path) as video:
        before = threading.active_count()
        for _ in itertools.islice(frames := video.frames(ahead=2), 3):
            pass
        frames.close()  # type: ignore[attr-defined]
        assert threading.active_count() == before


def test_libraries_write_nothing_to_stderr(make_video: MakeVideo, capfd: pytest.CaptureFixture[str]) -> None:
    for kind in ("hevc", "avi_h264", "single", "edit_list"):
        with open_video(make_video(kind).path) as video:
            video.confirm()
    assert capfd.readouterr().err == ""


@pytest.mark.data
def test_the_clip_with_hidden_frames(clips: Path) -> None:
    with open_video(clips / "erinflee_road_truncated.mp4") as video:
        frames = sum(1 for _ in video.frames(ahead=2))
        assert frames == 265
        (warning,) = video.warnings
        assert warning.startswith("erinflee_road_truncated.mp4 announces 372 frames, 265 decode:")


@pytest.mark.data
def test_real_clips_read_the_same_both_ways(clips: Path) -> None:
    with open_video(clips / "autobahn_960x540.mp4") as video:
        frames = {frame.ordinal: frame.picture for frame in video.frames(ahead=2) if frame.ordinal % 130 == 3}
        assert len(video.table) == 390
        for k in sorted(frames, reverse=True):
            assert np.array_equal(video.read(k).picture, frames[k])
