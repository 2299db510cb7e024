"""Signs are divided among subsets: disjoint, the same on every machine, near the wanted shares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.exchange.small_datasets import GTSRB, make_dataset, make_track, make_video
from tsr_engine.errors import ExportError, UsageError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.split import check_leaks, make_split, subset_of, subsets_of_frames, video_key


def _drives(spans: list[list[tuple[int, int]]]) -> Dataset:
    videos = [
        make_video(
            [make_track(f"m{k}", range(a, a + n)) for k, (a, n) in enumerate(tracks)], name=f"{v}.mp4", sha=f"{v:064d}"
        )
        for v, tracks in enumerate(spans)
    ]
    return Dataset(GTSRB, tuple(videos))


_spans = st.lists(
    st.lists(st.tuples(st.integers(0, 79), st.integers(1, 20)), min_size=1, max_size=8), min_size=1, max_size=4
)


@settings(max_examples=50, deadline=None)
@given(_spans, st.integers(0, 5), st.sampled_from(["sign", "video"]))
def test_no_frame_and_no_sign_is_in_two_subsets(spans: list[list[tuple[int, int]]], seed: int, rule: str) -> None:
    data = _drives(spans)
    try:
        split = make_split(data, {"train": 0.6, "val": 0.4}, seed, rule)
    except ExportError as error:
        assert "too few" in str(error)  # noqa: PT017
        return
    assert set(split.values()) == {"train", "val"}
    assert len(split) == sum(map(len, spans))
    check_leaks(data, split, whole_frames=True)
    for video in data.videos:
        sides: dict[int, set[str]] = {}
        for track in video.tracks():
            for frame in track.frames.tolist():
                sides.setdefault(frame, set()).add(split[video_key(video), track.uid])
        assert all(len(side) == 1 for side in sides.values())
        if rule == "video":
            assert len({split[video_key(video), t.uid] for t in video.tracks()}) == 1
    assert dict(make_split(data, {"train": 0.6, "val": 0.4}, seed, rule)) == dict(split)


def test_shares_are_met_by_boxes() -> None:
    data = _drives([[(10 * k, 10) for k in range(10)] for _ in range(20)])
    split = make_split(data, {"train": 8, "val": 1, "test": 1}, 7)
    sides = list(split.values())
    assert (sides.count("train"), sides.count("val"), sides.count("test")) == (160, 20, 20)
    assert split.shares == {"train": 0.8, "val": 0.1, "test": 0.1}
    assert dict(make_split(data, {"train": 8, "val": 1, "test": 1}, 8)) != dict(split)


def test_two_runs_of_one_video_are_split_alike() -> None:
    first, second = make_track("m1", range(10, 20)), make_track("n1", range(15, 25))
    other = make_track("m9", range(60, 70))
    data = Dataset(GTSRB, (make_video([first, other]), make_video([second])))
    split = make_split(data, {"train": 1, "val": 1}, 3)
    assert split["a" * 64, "m1"] == split["a" * 64, "n1"] != split["a" * 64, "m9"]


def test_crops_may_share_a_frame() -> None:
    data = make_dataset(make_track("m1"), make_track("m2"))
    with pytest.raises(ExportError, match="1 group .* too few for train / val"):
        make_split(data, {"train": 1, "val": 1}, 0)
    split = make_split(data, {"train": 1, "val": 1}, 0, "track")
    assert sorted(split.values()) == ["train", "val"]
    check_leaks(data, split, whole_frames=False)
    with pytest.raises(ExportError, match=r"frame 10 would be in .* Split by sign"):
        check_leaks(data, split, whole_frames=True)


def test_a_leak_across_two_runs_of_one_video_is_found() -> None:
    data = Dataset(GTSRB, (make_video([make_track("m1")]), make_video([make_track("n1")])))
    with pytest.raises(ExportError, match="frame 10"):
        check_leaks(data, {("a" * 64, "m1"): "train", ("a" * 64, "n1"): "val"}, whole_frames=True)


@pytest.mark.parametrize("shares", [{}, {"train": 0}, {"train": -1}, {"train": float("nan")}, {"dev": 1.0}])
def test_invalid_shares_are_refused(shares: dict[str, float]) -> None:
    with pytest.raises(UsageError, match="shares"):
        make_split(make_dataset(), shares, 0)


def test_an_unknown_rule_is_refused() -> None:
    with pytest.raises(UsageError, match="by sign, track or video"):
        make_split(make_dataset(), {"train": 1}, 0, "day")


def test_frames_without_signs_join_the_subset_of_the_nearest_sign() -> None:
    video = make_video(
        [make_track("m1", range(10, 20)), make_track("m2", range(60, 70)), make_track("m3", range(90, 95))]
    )
    split = {(video_key(video), "m1"): "val", (video_key(video), "m2"): "train"}
    names, side = subsets_of_frames(video, split)
    assert names == ["train", "val"]
    assert np.flatnonzero(np.diff(side)).tolist() == [39]
    assert names[side[0]] == "val"
    assert names[side[99]] == "train"
    assert subset_of(video, "m3", split) is None
    assert subset_of(video, "m3", {}) == "default"
    bare = replace(video, tracks=lambda: iter(()))
    assert not subsets_of_frames(bare, split)[1].any()
