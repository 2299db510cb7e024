"""Each frame of a recording's clip is the frame of the video with the same number."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from tests.io import video_corpus
from tests.recording import synthetic_run
from tests.recording.read_back import ReadBack
from tsr_engine.errors import VideoError
from tsr_engine.evidence import EvidenceReader
from tsr_engine.io.video import open_video
from tsr_engine.recording import RecordingRequest, group_encoder, transcode, write_recording
from tsr_engine.recording.clip import cut_clip, select_packets
from tsr_engine.recording.content import Frames
from tsr_engine.recording.from_evidence import read_frames
from tsr_engine.recording.rrd_sink import read_video_times

MakeVideo = Callable[[str], Any]

COPIED = (
    "constant", "ntsc", "variable", "b_frames", "long_gop", "open_gop", "offset_start", "fragmented", "odd_size",
    "odd_size_vp9", "matroska_variable", "edit_list_inside_gop", "hevc",
)  # fmt: skip
ENCODED = {
    "avi_h264": "no presentation times",
    "avi_mpeg4": "no presentation times",
    "mov_mjpeg": "viewers do not play mjpeg",
    "rotated_90": "stored rotated",
    "mirrored": "stored rotated",
}


def decode_clip(data: bytes, nanos: np.ndarray) -> list[np.ndarray]:
    """Pictures of a clip at some times, found as the viewer does, which counts times from the first picture."""
    with av.open(io.BytesIO(data)) as container:
        assert container.format.name.startswith("mov")
        pictures = {round(float(f.time) * 1e9): f.to_ndarray(format="bgr24") for f in container.decode(video=0)}
    times = np.array(sorted(pictures))
    nearest = [int(times[np.argmin(abs(times - times[0] - n))]) for n in nanos.tolist()]
    assert max(abs(t - times[0] - n) for t, n in zip(nearest, nanos.tolist(), strict=True)) < 1e5, "0.1 ms"
    return [pictures[t] for t in nearest]


def key_places(data: bytes) -> list[int]:
    """Numbers of the packets, from 0, that the file marks as starting points."""
    at = data.index(b"stss") + 8
    count = struct.unpack_from(">I", data, at)[0]
    return [n - 1 for n in struct.unpack_from(f">{count}I", data, at + 4)]


def check(video: Any, folder: Path, first: int, stop: int) -> str:
    run = synthetic_run.write_run(folder / "run", video=video.path)
    with EvidenceReader(run) as reader:
        frames = read_frames(reader, first, stop)
    clip = cut_clip(video.path, frames, read_video_times)
    assert (np.diff(clip.times_ns) > 0).all()
    times = clip.times_ns / 1e9
    want = np.array([float(video.times[k] - video.times[first]) for k in range(first, stop)])
    np.testing.assert_allclose(times - times[0], want, atol=2e-3)
    shown = [video_corpus.read_code(picture) for picture in decode_clip(clip.data, clip.times_ns)]
    assert shown == [video.codes[k] for k in range(first, stop)]
    return clip.how


@pytest.mark.parametrize("kind", COPIED)
def test_packets_are_copied_from_a_key_frame(kind: str, make_video: MakeVideo, tmp_path: Path) -> None:
    video = make_video(kind)
    last = len(video.codes)
    how = check(video, tmp_path, min(15, last - 3), min(last, 33))
    assert "not re-encoded" in how
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("kind", ENCODED)
def test_other_codecs_are_encoded_again(kind: str, make_video: MakeVideo, tmp_path: Path) -> None:
    how = check(make_video(kind), tmp_path, 4, 11)
    assert how.startswith("Re-encoded as H.264")
    assert ENCODED[kind] in how


@pytest.mark.parametrize(("first", "stop"), [(0, 1), (0, 50), (12, 13), (11, 24), (49, 50)])
def test_any_range_has_the_right_frames(first: int, stop: int, make_video: MakeVideo, tmp_path: Path) -> None:
    assert "not re-encoded" in check(make_video("b_frames"), tmp_path, first, stop)


def test_a_jump_into_an_open_group_starts_at_a_decodable_picture(make_video: MakeVideo, tmp_path: Path) -> None:
    """Only packets that need no earlier picture may be marked as key frames."""
    run = synthetic_run.write_run(tmp_path / "run", video=make_video("open_gop").path)
    with EvidenceReader(run) as reader:
        clip = cut_clip(make_video("open_gop").path, read_frames(reader, 5, 45), read_video_times)
    with av.open(io.BytesIO(clip.data)) as container:
        stamps = [p.pts for p in container.demux(video=0) if p.size]
    places = key_places(clip.data)
    assert places[0] == 0
    for place in places:
        assert min(stamps[place:]) == stamps[place]


@pytest.mark.parametrize("kind", ["b_frames", "variable", "open_gop", "hevc"])
def test_reencoded_pictures_keep_their_numbers_and_times(kind: str, make_video: MakeVideo, tmp_path: Path) -> None:
    """Whether packets precede the range, come late, or are reordered."""
    video = make_video(kind)
    run = synthetic_run.write_run(tmp_path / "run", video=video.path)
    with EvidenceReader(run) as reader:
        frames = read_frames(reader, 7, 40)
    with av.open(video.path) as container:
        stream = container.streams.video[0]
        packets = select_packets(container, stream, frames.pts)
        data = transcode.encode_packets(stream, packets, frames.pts, 60_000)
        other = transcode.encode_packets(stream, packets, frames.pts + 1, 60_000)
    assert data is not None
    assert other is None, "a picture is missing"
    nanos = np.sort(read_video_times(data))
    want = np.array([float(video.times[k] - video.times[7]) for k in range(7, 40)])
    np.testing.assert_allclose((nanos - nanos[0]) / 1e9, want, atol=2e-3)
    assert [video_corpus.read_code(picture) for picture in decode_clip(data, nanos)] == [
        video.codes[k] for k in range(7, 40)
    ]


@pytest.mark.parametrize("threads", [1, 2])
def test_300_frames_of_720p_take_five_megabytes(threads: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Changing noise is the worst case. Downscaled to a 16th of the area."""
    monkeypatch.setattr(transcode, "encoder_threads", lambda: threads)
    path, count = tmp_path / "noise.mp4", 60
    rng = np.random.default_rng(1)
    with av.open(path, "w") as out:
        stream = out.add_stream("libx264", rate=30, options={"crf": "20", "preset": "ultrafast"})
        stream.width, stream.height, stream.pix_fmt = 320, 180, "yuv420p"
        for _ in range(count):
            noise = rng.integers(0, 255, (45, 80, 3), np.uint8).repeat(4, axis=0).repeat(4, axis=1)
            out.mux(stream.encode(av.VideoFrame.from_ndarray(noise, format="bgr24")))
        out.mux(stream.encode(None))
    with open_video(path) as video:
        pts = video.confirm().pts
    numbers = np.arange(count)
    frames = Frames(numbers, numbers / 30.0, pts, 320, 180)
    allowed = transcode.size_limit(count, 320, 180)
    assert transcode.size_limit(300, 1280, 720) <= 4.1e6
    assert transcode.size_limit(600, 1280, 720) == 2 * transcode.size_limit(300, 1280, 720)
    assert path.stat().st_size > 1.5 * allowed
    clip = cut_clip(path, frames, read_video_times)
    assert clip.how.startswith("Re-encoded as H.264 in")
    assert len(clip.data) < 1.15 * allowed, "rate control misses by some percent at most"
    assert len(clip.times_ns) == count
    exact = cut_clip(path, frames, read_video_times, exact=True)
    assert "not re-encoded" in exact.how
    assert len(exact.data) > 1.5 * allowed


def test_the_clip_is_short(make_video: MakeVideo, tmp_path: Path) -> None:
    whole = make_video("constant").path.stat().st_size
    run = synthetic_run.write_run(tmp_path / "run", video=make_video("constant").path)
    with EvidenceReader(run) as reader:
        clip = cut_clip(make_video("constant").path, read_frames(reader, 26, 30), read_video_times)
    assert len(clip.data) < whole / 2


def test_the_recording_contains_the_clip_and_the_picture_of_each_frame(make_video: MakeVideo, tmp_path: Path) -> None:
    run = synthetic_run.write_run(tmp_path / "run", video=make_video("variable").path)
    report = write_recording(RecordingRequest(run, tmp_path / "a.rrd", 14, 31, make_video("variable").path))
    back = ReadBack(report.path)
    data = bytes(back.static("video", "AssetVideo:blob")[0])
    references = {k: v[0] for k, v in back.column("video", "VideoFrameReference:timestamp").items()}
    assert sorted(references) == list(range(14, 31))
    pictures = decode_clip(data, np.array([references[k] for k in range(14, 31)]))
    assert [video_corpus.read_code(picture) for picture in pictures] == list(range(14, 31))


def test_a_video_that_ends_too_early_is_refused(make_video: MakeVideo, tmp_path: Path) -> None:
    short = video_corpus.cut(make_video("fragmented"), tmp_path / "short.mp4", 0.5)
    run = synthetic_run.write_run(tmp_path / "run", video=make_video("fragmented").path)
    with EvidenceReader(run) as reader:
        frames: Frames = read_frames(reader, 10, 50)
    with pytest.raises(VideoError, match="it is not the video of this run"):
        cut_clip(short, frames, read_video_times)


def test_groups_of_pictures_share_the_bytes_and_decode_from_each_key_frame(tmp_path: Path) -> None:
    """A calm street, then a busy one: the size stays within the limit, and each group decodes alone."""
    rng, count, budget = np.random.default_rng(2), 200, 150_000
    calm = rng.integers(0, 255, (12, 20), np.uint8).repeat(8, axis=0).repeat(8, axis=1)
    target = io.BytesIO()
    with av.open(target, "w", format="mp4") as out:
        encoder: group_encoder.GroupEncoder | None = None
        for k in range(count):
            noise = rng.integers(0, 40, calm.shape, np.uint8) if k >= 100 else np.uint8(k)
            picture = av.VideoFrame.from_ndarray(calm // 2 + noise, format="gray").reformat(format="yuv420p")
            picture.pts, picture.time_base = k, Fraction(1, 30)
            encoder = encoder or group_encoder.GroupEncoder(out, picture, Fraction(1, 30), count, budget, 1)
            encoder.put(picture)
        assert encoder is not None
        encoder.close()
    assert 0.5 * budget < len(target.getvalue()) < 1.4 * budget, "the change is noticed some pictures late"
    target.seek(0)
    with av.open(target) as back:
        stream = back.streams.video[0]
        packets = [packet for packet in back.demux(stream) if packet.size]
        keys = [k for k, packet in enumerate(packets) if packet.is_keyframe]
        assert len(packets) == count
        assert max(np.diff([*keys, count])) <= group_encoder.GROUP_SIZE
        for k in keys:
            back.seek(packets[k].pts, stream=stream)
            assert next(back.decode(stream)).pts == packets[k].pts
