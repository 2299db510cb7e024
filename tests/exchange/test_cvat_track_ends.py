"""Frames and boxes at the end of tracks in files of CVAT for video."""

from __future__ import annotations

import pytest

from tests.exchange.cvat_files import BOX, Read, cvat_file, cvat_track, one_track
from tests.exchange.small_datasets import tracks_of
from tsr_engine.errors import ImportFormatError


def test_the_end_may_be_one_step_after_the_video(read_file: Read) -> None:
    meta = "<meta><task><name>drive</name><frame_filter>step=5</frame_filter></task></meta>"
    track = cvat_track(BOX.format(93, 1, 0, 20), BOX.format(98, 0, 0, 20), BOX.format(103, 1, 1, 20))
    assert tracks_of(read_file(cvat_file(meta, track)))["cvat-0"].frames.tolist() == list(range(93, 99))
    with pytest.raises(ImportFormatError, match="line 5: frame 103"):
        read_file(cvat_file(track))


def test_a_track_ends_in_the_last_frame_of_its_task_that_shows_it(read_file: Read) -> None:
    """CVAT 2 ends a single shape, and a track, one ``frame_filter`` step later (``dump_as_cvat_interpolation``)."""
    meta = "<meta><task><name>drive</name><frame_filter>step=5</frame_filter></task></meta>"
    shape = cvat_track(BOX.format(10, 1, 0, 20), BOX.format(15, 1, 1, 20))
    track = cvat_track(BOX.format(10, 1, 0, 20), BOX.format(15, 0, 0, 25), BOX.format(20, 1, 1, 30), id=1)
    found = read_file(cvat_file(meta, shape, track))
    assert tracks_of(found)["cvat-0"].frames.tolist() == [10]
    assert tracks_of(found)["cvat-1"].frames.tolist() == [10, 11, 12, 13, 14, 15]
    assert "its task has one of 5 frames of the video" in found.repaired[0]


_MARK = '<box frame="{}" keyframe="1" outside="1" {}/>'


@pytest.mark.parametrize(
    ("mark", "edges"),
    [
        (_MARK.format(14, 'xtl="10" ytl="10" xbr="28" ybr="22"'), [20, 22, 24, 26]),
        (_MARK.format(14, 'xtl="10" ytl="10" xbr="28" ybr="22" rotation="45"'), [20] * 4),
        (_MARK.format(14, 'xtl="0" ytl="0" xbr="0" ybr="0"'), [20] * 4),
        (_MARK.format(14, ""), [20] * 4),
        (_MARK.format(11, 'xtl="10" ytl="10" xbr="28" ybr="22"'), [20]),
    ],
    ids=["elsewhere", "rotated", "without area", "without a box", "in the next frame"],
)
def test_the_end_of_a_track_with_key_frames_only(read_file: Read, mark: str, edges: list[int]) -> None:
    found = read_file(one_track(BOX.format(10, 1, 0, 20), mark))
    track = tracks_of(found)["cvat-0"]
    assert track.frames.tolist() == list(range(10, 10 + len(edges)))
    assert track.boxes[:, 2].tolist() == edges
    assert track.key.tolist() == [True] + [False] * (len(edges) - 1)
    assert found.repaired == ()


def test_the_end_of_a_track_with_key_frames_only_in_a_task_with_a_step(read_file: Read) -> None:
    meta = "<meta><task><name>drive</name><frame_filter>step=5</frame_filter></task></meta>"
    for last, mark in ((10, 25), (88, 103), (3, 18)):
        track = cvat_track(BOX.format(last, 1, 0, 20), BOX.format(mark, 1, 1, 35))
        found = tracks_of(read_file(cvat_file(meta, track)))["cvat-0"]
        assert found.frames.tolist() == list(range(last, last + 11))
        assert found.boxes[:, 2].tolist() == list(range(20, 31))


def test_an_end_mark_beyond_the_video_lies_in_no_frame(read_file: Read) -> None:
    meta = "<meta><task><name>drive</name><frame_filter>step=300000</frame_filter></task></meta>"
    track = cvat_track(BOX.format(90, 1, 0, 20), BOX.format(110, 1, 1, 40))
    found = tracks_of(read_file(cvat_file(meta, track)))["cvat-0"]
    assert found.frames.tolist() == list(range(90, 100))
    assert found.boxes[:, 2].tolist() == list(range(20, 30))


def test_a_track_of_key_frames_without_an_end_is_reported(read_file: Read) -> None:
    keys = (BOX.format(10, 1, 0, 20), BOX.format(20, 1, 0, 30))
    found = read_file(one_track(*keys))
    assert tracks_of(found)["cvat-0"].frames.tolist() == list(range(10, 21))
    assert any("Tracks without an end (outside=1) end in their last key frame" in text for text in found.repaired)
    whole = (
        cvat_file("<meta><job><stop_frame>20</stop_frame></job></meta>", cvat_track(*keys)),
        one_track(*keys, BOX.format(99, 1, 0, 30)),
        one_track(*keys, BOX.format(21, 1, 1, 30)),
        one_track(*keys, BOX.format(21, 0, 0, 30)),
    )
    assert [read_file(content).repaired for content in whole] == [()] * 4
