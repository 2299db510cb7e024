"""Frames in both directions equal a sequential pass, with few decodings and bounded memory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tsr_engine.io.bidirectional_frames import BidirectionalFrames
from tsr_engine.io.opened_file import OpenedFile
from tsr_engine.io.video import Frame, Video, VideoLimits, open_video

KINDS = ("constant", "b_frames", "long_gop", "open_gop", "variable", "avi_mpeg4", "repeated_stamps_gop", "edit_list")


class CountingVideo(Video):
    """Counts requested frames other than the anchor's."""

    decoded = 0

    def frames(self, *args: Any, **options: Any) -> Iterator[Frame]:
        for frame in super().frames(*args, **options):
            CountingVideo.decoded += 1
            yield frame


def pictures_of(path: Path) -> list[np.ndarray]:
    with open_video(path) as video:
        return [frame.picture for frame in video.frames()]


@pytest.mark.parametrize("kind", KINDS)
def test_the_pictures_equal_those_of_a_sequential_pass(kind: str, make_video: Any) -> None:
    path = make_video(kind).path
    truth = pictures_of(path)
    middle = len(truth) // 2
    with open_video(path) as video, BidirectionalFrames(video) as give:
        order = [middle]
        for k in range(1, len(truth)):
            order += [middle + k, middle - k]
        for k in order:
            frame = give(k)
            if 0 <= k < len(truth):
                assert frame is not None
                assert frame.ordinal == k
                assert np.array_equal(frame.picture, truth[k])
            else:
                assert frame is None


@pytest.mark.parametrize("kind", KINDS)
def test_prepared_frames_are_equal_and_need_no_further_pass(kind: str, make_video: Any) -> None:
    path = make_video(kind).path
    truth = pictures_of(path)
    middle = len(truth) // 2
    with CountingVideo(OpenedFile.by_name(path), VideoLimits()) as video, BidirectionalFrames(video) as give:
        for k in (2, middle):
            give.prefetch(k)
        CountingVideo.decoded = 0
        give.prefetch(middle)
        for k in (middle, middle + 1, middle - 1, middle, middle - 3):
            frame = give(k)
            assert frame is not None
            assert np.array_equal(frame.picture, truth[k])
        assert CountingVideo.decoded == 0


def test_a_jump_works(make_video: Any) -> None:
    path = make_video("b_frames").path
    truth = pictures_of(path)
    with open_video(path) as video, BidirectionalFrames(video) as give:
        for k in (20, 3, 19, 4, 20, 21, 2):
            frame = give(k)
            assert frame is not None
            assert np.array_equal(frame.picture, truth[k])


def test_going_back_through_a_long_group_decodes_each_frame_once(make_video: Any) -> None:
    path = make_video("long_gop").path
    count = len(pictures_of(path))
    with CountingVideo(OpenedFile.by_name(path), VideoLimits()) as video, BidirectionalFrames(video) as give:
        CountingVideo.decoded = 0
        for k in range(count - 1, -1, -1):
            assert give(k) is not None
        assert count <= CountingVideo.decoded <= count + 4


def test_the_cache_is_bounded(make_video: Any) -> None:
    path = make_video("long_gop").path
    with open_video(path) as video:
        room = 10 * video.width * video.height * 3
        with BidirectionalFrames(video, room) as give:
            for k in range(35, -1, -1):
                assert give(k) is not None
                assert len(give._block) <= 10
                assert len(give._recent) <= 3


def test_closing_frees_the_frames(make_video: Any) -> None:
    with open_video(make_video("constant").path) as video:
        give = BidirectionalFrames(video)
        assert give(10) is not None
        assert give(9) is not None
        give.close()
        assert not give._block
        assert give(10) is not None
        give.close()
