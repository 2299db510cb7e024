"""Exported pictures are the right frames, with the hash of the decoded frame and names that lead back to it."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.exchange.small_datasets import GTSRB, make_dataset, make_track, make_video, round_trip, tracks_of
from tsr_engine.errors import ExportError, VideoError
from tsr_engine.exchange.dataset import Dataset, DatasetVideo
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.pictures import stream_frames, wanted_frames
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.exchange.video_names import picture_prefixes, safe_stem
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """30 frames, each brighter than the one before."""
    path = tmp_path_factory.mktemp("clip") / "drive.mp4"
    with VideoWriter(path, 64, 48, Fraction(25)) as writer:
        for k in range(30):
            writer.write(np.full((48, 64, 3), 8 * k, dtype=np.uint8))
    return path


def _video(clip: Path, *tracks: object) -> DatasetVideo:
    small = replace(make_video(tracks, frames=30), width=64, height=48, path=clip)  # type: ignore[arg-type]
    return replace(small, name=clip.name)


def _small(uid: str, frames: list[int]) -> object:
    return make_track(uid, frames, boxes=np.tile([10.0, 10, 30, 30], (len(frames), 1)))


@pytest.mark.parametrize(
    ("format", "pattern"),
    [
        ("cvat-video", "images/frame_{:06d}.png"),
        ("cvat-images", "images/frame_{:06d}.jpg"),
        ("datumaro", "images/default/frame_{:06d}.jpg"),
    ],
)
def test_pictures_of_annotated_frames(tmp_path: Path, clip: Path, format: str, pattern: str) -> None:
    data = Dataset(GTSRB, (_video(clip, _small("m1", [3, 4, 20])),))
    reported = export_dataset(
        data, FORMATS[format], tmp_path / "out", ExportOptions(pictures="annotated"), zipped=False
    )
    table = reported.content["videos"][0]["frame_table"]
    assert table["frame"] == [3, 4, 20]
    assert table["file"] == [pattern.format(frame) for frame in (3, 4, 20)]
    with open_video(clip) as video:
        for frame, file, digest in zip(table["frame"], table["file"], table["picture_sha256"], strict=True):
            picture = video.read(frame).picture
            assert hashlib.sha256(picture.tobytes()).hexdigest() == digest
            written = cv2.imread(str(tmp_path / "out" / file))
            assert written is not None
            assert np.abs(written.astype(int) - picture).max() <= (0 if file.endswith("png") else 3)
    every = export_dataset(data, FORMATS[format], tmp_path / "out", ExportOptions(pictures="all"), zipped=False)
    assert every.content["videos"][0]["frame_table"]["frame"] == list(range(30))
    assert every.counts["pictures"] == 30


@pytest.mark.parametrize("format", ["label-studio", "tracks-csv", "tracks-json"])
def test_formats_without_pictures(tmp_path: Path, clip: Path, format: str) -> None:
    data = Dataset(GTSRB, (_video(clip, _small("m1", [3])),))
    with pytest.raises(ExportError, match=r"has no pictures\. Export without pictures\."):
        export_dataset(data, FORMATS[format], tmp_path / "o", ExportOptions(pictures="all"), zipped=False)
    assert not list(tmp_path.iterdir())


def test_a_video_without_a_file(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=r"drive.mp4 is not known.*without pictures"):
        export_dataset(
            make_dataset(), FORMATS["cvat-images"], tmp_path / "o", ExportOptions(pictures="all"), zipped=False
        )
    assert not list(tmp_path.iterdir())


def test_frames_are_decoded_one_at_a_time_and_in_order(clip: Path) -> None:
    wanted = np.array([0, 7, 29])
    seen = [(frame.ordinal, int(frame.picture.mean())) for frame in stream_frames(_video(clip), wanted)]
    assert [ordinal for ordinal, _ in seen] == [0, 7, 29]
    assert all(abs(mean - 8 * ordinal) < 6 for ordinal, mean in seen)
    assert not list(stream_frames(_video(clip), np.zeros(0, dtype=np.int64)))


def test_a_file_that_does_not_match_the_frame_table_is_refused(tmp_path: Path, clip: Path) -> None:
    other = tmp_path / "other.mp4"
    with VideoWriter(other, 64, 48, Fraction(30)) as writer:
        for _ in range(30):
            writer.write(np.zeros((48, 64, 3), np.uint8))
    with open_video(clip) as video:
        table = video.confirm()
    wanted = np.array([7])
    assert len(list(stream_frames(replace(_video(clip), table=table), wanted))) == 1
    with pytest.raises(VideoError, match="frame table"):
        list(stream_frames(replace(_video(other), table=table), wanted))


def test_selection_of_frames() -> None:
    video = replace(make_video(), first=10, stop=15)
    shown = np.array([11, 13])
    assert wanted_frames(video, shown, "none").tolist() == []
    assert wanted_frames(video, shown, "annotated").tolist() == [11, 13]
    assert wanted_frames(video, shown, "all").tolist() == [10, 11, 12, 13, 14]


def test_names_of_several_videos_differ() -> None:
    names = ["drive.mp4", "a/Drive.mov", "ä b.mp4", "...", "x" * 200 + ".mp4"]
    data = [make_video(name=name, sha=str(index) * 64) for index, name in enumerate(names, start=1)]
    made = picture_prefixes(data)
    assert made[:4] == ["drive-11111111_", "Drive-22222222_", "b_", "video_"]
    assert picture_prefixes(data[::-1]) == made[::-1], "names do not depend on the order"
    assert len({prefix.casefold() for prefix in made}) == 5
    assert len(safe_stem(names[-1])) == 60
    assert picture_prefixes(make_dataset().videos) == [""]


@pytest.mark.parametrize("format", ["cvat-images", "datumaro"])
def test_pictures_of_several_videos_lead_back_to_the_right_one(tmp_path: Path, format: str) -> None:
    one = make_video([make_track("m1", range(10, 20))])
    two = make_video([make_track("m2", range(30, 40)), make_track("m3", range(50, 60))], name="other.mp4", sha="b" * 64)
    back = round_trip(Dataset(GTSRB, (one, two)), format, tmp_path)
    assert sorted(tracks_of(back)) == ["m1"]
    assert any("another video" in item.reason for item in back.skipped)
