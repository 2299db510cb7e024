"""Filters of data, and their reports of omissions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from tests.exchange.small_datasets import make_dataset, make_track, tracks_of
from tsr_engine.errors import UsageError
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.filters import Filters, clip_track, filter_dataset, with_left_out


def _skips(data: object) -> list[str]:
    return [f"{item.what} {item.reason}" for item in data.skipped]  # type: ignore[attr-defined]


def test_states_and_classes_are_filtered() -> None:
    data = make_dataset()
    some = filter_dataset(data, Filters(states=frozenset({"accepted", "open"})))
    assert sorted(tracks_of(some)) == ["m1", "m2"]
    assert _skips(some) == ["drive.mp4: 1 track Their review state is needs_work."]
    some = filter_dataset(data, Filters(labels=frozenset({14, -1})))
    assert sorted(tracks_of(some)) == ["h3", "m1"]
    assert _skips(some) == ["drive.mp4: 1 track Their label was not chosen."]


def test_frames_are_filtered() -> None:
    some = filter_dataset(make_dataset(), Filters(first=35, stop=85))
    assert [track.frames.tolist() for track in some.videos[0].tracks()] == [
        [*range(35, 40)],
        [*range(35, 43)],
        [*range(80, 85)],
    ]
    assert (some.videos[0].first, some.videos[0].stop) == (35, 85)
    assert tracks_of(some)["m1"].notes == ()
    assert "52 boxes They lie outside of frames 35 to 84." in _skips(some)[0]


def test_small_boxes_are_filtered() -> None:
    track = make_track(jitter=0)
    some = filter_dataset(make_dataset(track), Filters(min_side=30))
    kept = tracks_of(some)["m1"]
    assert 0 < len(kept.frames) < 30
    assert (kept.boxes[:, 2] - kept.boxes[:, 0]).min() >= 30
    assert f"{30 - len(kept.frames)} boxes Their shorter side is below 30 px." in _skips(some)[0]
    assert not tracks_of(filter_dataset(make_dataset(track), Filters(min_side=1000)))


@pytest.mark.parametrize(
    "filters",
    [
        Filters(),
        Filters(states=frozenset({"accepted"}), first=35, stop=85),
        Filters(min_side=30, not_in_set="leave-out"),
        Filters(labels=frozenset({14})),
    ],
)
def test_the_rest_is_found_in_one_pass(filters: Filters) -> None:
    data = make_dataset()
    (video,) = data.videos
    passes = []

    def tracks() -> Iterator[Track]:
        passes.append(1)
        return video.tracks()

    part = filter_dataset(replace(data, videos=(replace(video, tracks=tracks),)), filters)
    assert len(passes) == 1
    expected = with_left_out(part, data).videos[0].left_out
    found = part.videos[0].left_out
    assert bool(found) == bool(part.skipped)
    for each in ("frames", "boxes"):
        assert [getattr(t, each).tolist() for t in found] == [getattr(t, each).tolist() for t in expected]


def test_without_filters_nothing_is_reported() -> None:
    assert filter_dataset(make_dataset(), Filters()).skipped == ()


@pytest.mark.parametrize(
    "more", [{"first": -1}, {"first": 5, "stop": 5}, {"min_side": -1.0}, {"min_side": float("nan")}]
)
def test_invalid_filters_are_refused(more: dict[str, float]) -> None:
    with pytest.raises(UsageError):
        Filters(**more)  # type: ignore[arg-type]


def test_frames_beyond_the_end_are_refused() -> None:
    with pytest.raises(UsageError, match="frames 0 to 99"):
        filter_dataset(make_dataset(), Filters(first=100))


def test_boxes_are_clipped_to_the_picture() -> None:
    boxes = np.tile([10.0, 10, 20, 20], (4, 1))
    boxes[0], boxes[1] = [-5, -5, 5, 5], [700, 10, 710, 20]
    track, cut = clip_track(make_track(frames=range(4), boxes=boxes), (640, 360))
    assert track is not None
    assert track.frames.tolist() == [0, 2, 3]
    assert track.boxes[0].tolist() == [0, 0, 5, 5]
    assert cut == 1
    gone, _ = clip_track(make_track(frames=range(4), boxes=boxes + 1000), (640, 360))
    assert gone is None
