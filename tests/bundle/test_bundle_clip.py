"""The clip of a bundle has the same pictures, bit by bit, with known numbers."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from tests import toy_pipeline
from tsr_engine.bundle.clip import cut_clip
from tsr_engine.errors import VideoError
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter


def assert_same_pictures(video: Path, clip: Any, start: int, stop: int) -> None:
    assert [frame.ordinal for frame in clip.frames] == list(range(start, stop))
    with open_video(video) as one, open_video(clip.path) as other:
        for wanted in clip.frames:
            original = one.read(wanted.ordinal)
            assert original.seconds == wanted.seconds
            assert np.array_equal(original.picture, other.read(wanted.clip).picture), wanted.ordinal


@pytest.mark.parametrize(("start", "stop"), [(0, 3), (31, 40), (60, 75)])
def test_packets_of_a_file_with_bidirectional_pictures(drive: Any, tmp_path: Path, start: int, stop: int) -> None:
    clip = cut_clip(drive.video, start, stop, tmp_path)
    assert clip.copied
    assert clip.path.name == "clip.mp4"
    assert clip.offset <= start
    assert_same_pictures(drive.video, clip, start, stop)


def test_a_clip_begins_at_the_previous_key_frame(drive: Any, tmp_path: Path) -> None:
    video = tmp_path / "keys.mp4"
    with VideoWriter(video, toy_pipeline.WIDTH, toy_pipeline.HEIGHT, Fraction(25), key_distance=10) as writer:
        for k in range(45):
            writer.write(toy_pipeline.drive_picture(k))
    clip = cut_clip(video, 24, 33, tmp_path)
    assert (clip.copied, clip.offset) == (True, 20)
    assert [frame.clip for frame in clip.frames] == list(range(4, 13))
    assert_same_pictures(video, clip, 24, 33)


def test_irregular_times_stay_exact(drive: Any, tmp_path: Path) -> None:
    video = tmp_path / "vfr.mp4"
    times = np.cumsum([1, 3, 1, 7, 2, 1, 1, 30, 2, 1, 1, 4]) / 90
    with VideoWriter(video, toy_pipeline.WIDTH, toy_pipeline.HEIGHT, Fraction(25)) as writer:
        for k, time in enumerate(times.tolist()):
            writer.write(toy_pipeline.drive_picture(k), Fraction(time).limit_denominator(90))
    clip = cut_clip(video, 3, 11, tmp_path)
    assert_same_pictures(video, clip, 3, 11)


def test_a_file_without_presentation_times_is_stored_without_loss(drive: Any, tmp_path: Path) -> None:
    video = tmp_path / "old.avi"
    with av.open(str(video), "w") as out:
        stream: Any = out.add_stream("mpeg4", rate=25)
        stream.width, stream.height, stream.pix_fmt = toy_pipeline.WIDTH, toy_pipeline.HEIGHT, "yuv420p"
        for k in range(12):
            out.mux(stream.encode(av.VideoFrame.from_ndarray(toy_pipeline.drive_picture(k), format="bgr24")))
        out.mux(stream.encode(None))
    clip = cut_clip(video, 4, 10, tmp_path)
    assert not clip.copied
    assert "no presentation times" in clip.how
    assert (clip.path.name, clip.offset) == ("clip.mkv", 4)
    assert_same_pictures(video, clip, 4, 10)


@pytest.mark.parametrize("name", ["wide.ts", "wide.mp4"])
def test_a_clip_keeps_the_pixel_aspect_ratio(drive: Any, tmp_path: Path, name: str) -> None:
    """Packets of a transport stream are not copied; those of an MP4 are."""
    video = tmp_path / name
    with av.open(str(video), "w") as out:
        stream: Any = out.add_stream("libx264", rate=25, options={"bf": "2", "g": "4"})
        stream.width, stream.height, stream.pix_fmt = toy_pipeline.WIDTH, toy_pipeline.HEIGHT, "yuv420p"
        stream.codec_context.sample_aspect_ratio = Fraction(4, 3)
        for k in range(12):
            out.mux(stream.encode(av.VideoFrame.from_ndarray(toy_pipeline.drive_picture(k), format="bgr24")))
        out.mux(stream.encode(None))
    clip = cut_clip(video, 4, 10, tmp_path)
    assert clip.copied == (name == "wide.mp4")
    if clip.copied:  # FFV1 stores the ratio with each picture, which this reader does not read
        with open_video(clip.path) as cut:
            assert cut.pixel_ratio == Fraction(4, 3)
    assert_same_pictures(video, clip, 4, 10)


def test_a_range_beyond_the_end_is_refused(drive: Any, tmp_path: Path) -> None:
    with pytest.raises(VideoError, match="ends at frame 74"):
        cut_clip(drive.video, 70, 80, tmp_path)


def test_two_cuts_give_the_same_bytes(drive: Any, tmp_path: Path) -> None:
    cuts = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        cuts.append(cut_clip(drive.video, 40, 50, tmp_path / name).path.read_bytes())
    assert cuts[0] == cuts[1]
