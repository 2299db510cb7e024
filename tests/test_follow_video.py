"""Following through a video file: problems with the file are reported, and it is closed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.io import video_corpus
from tsr_engine.errors import UsageError, VideoError
from tsr_engine.evaluation.track_tables import read_clip_truth
from tsr_engine.follow import Anchor, Ending, FollowerModels, Proposal
from tsr_engine.follow_video import follow_video, load_follower
from tsr_engine.geometry.boxes import iou_each
from tsr_engine.io.video import open_video

NOTHING = FollowerModels()
"""By correlation alone."""
BOX = np.array([20.0, 10.0, 70.0, 50.0])


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return video_corpus.maker(tmp_path_factory.mktemp("following"))("b_frames").path


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(VideoError, match=r"gone\.mp4"):
        next(follow_video(tmp_path / "gone.mp4", [Anchor(3, BOX)], NOTHING))


def test_a_replaced_file_does_not_match_its_table(drive: Path) -> None:
    with open_video(drive) as video:
        table = video.confirm()
    other = replace(table, pts=table.pts + 7, stamps=table.stamps + 7)
    with pytest.raises(VideoError, match="file has changed"):
        list(follow_video(drive, [Anchor(30, BOX)], NOTHING, table=other))


def test_a_frame_beyond_the_end(drive: Path) -> None:
    with pytest.raises(UsageError, match="no frame 5000"):
        next(follow_video(drive, [Anchor(5000, BOX)], NOTHING))


def test_a_frame_table_gives_the_same_result(drive: Path) -> None:
    with open_video(drive) as video:
        table = video.confirm()

    def seen(**options: Any) -> list[tuple[int, list[float]]]:
        events = follow_video(drive, [Anchor(20, BOX)], NOTHING, first=12, last=28, **options)
        return [(e.frame, e.box.tolist()) for e in events if isinstance(e, Proposal)]

    assert seen() == seen(table=table)


def test_leaving_early_closes_the_file(drive: Path) -> None:
    events = follow_video(drive, [Anchor(20, BOX)], NOTHING)
    next(events)
    names = [link.readlink() for link in Path("/proc/self/fd").iterdir() if link.is_symlink()]
    assert drive in names
    events.close()
    names = [link.readlink() for link in Path("/proc/self/fd").iterdir() if link.is_symlink()]
    assert drive not in names


@pytest.mark.data
def test_a_real_sign_drawn_once(clips: Path) -> None:
    truth = read_clip_truth(clips / "gt" / "SH4_70b651.csv")
    rows = truth.track == 1
    boxes = dict(zip(truth.frame[rows].tolist(), truth.boxes[rows], strict=True))
    kept: dict[int, Proposal] = {}
    for event in follow_video(clips / "SH4_70b651.mp4", [Anchor(15, boxes[15])], load_follower()):
        if isinstance(event, Ending):
            assert event.reason == ("picture edge" if event.direction == "forward" else "video")
            ahead = event.direction == "forward"
            kept = {k: p for k, p in kept.items() if (k <= event.frame if ahead else k >= event.frame)}
        else:
            kept[event.frame] = event
    assert 32 <= max(kept) <= 35
    assert min(kept) == 0
    good = [float(iou_each(kept[k].box, boxes[k])[0]) >= 0.7 for k in range(33)]
    assert np.mean(good) > 0.95
    assert "detected" in {p.source for p in kept.values()}
