"""Key frames: every edge stays within the bound in every frame, required frames stay, and no choice is smaller."""

from __future__ import annotations

import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.exchange.small_datasets import make_track
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.thinning import MAX_KEY_DISTANCE, interpolate, key_frames, run_bounds

_edges = st.lists(st.tuples(*(st.floats(0, 200, allow_nan=False, width=32) for _ in range(4))), min_size=1, max_size=14)


@st.composite
def _tracks(draw: st.DrawFn) -> Track:
    corners = draw(_edges)
    n = len(corners)
    steps = draw(st.lists(st.sampled_from([1, 1, 1, 2, 5]), min_size=n, max_size=n))
    flags = st.lists(st.booleans(), min_size=n, max_size=n)
    boxes = [(x, y, x + 1 + w, y + 1 + h) for x, y, w, h in corners]
    return make_track(
        "t",
        np.cumsum(steps).tolist(),
        boxes=boxes,
        key=np.array(draw(flags)) & np.array(draw(flags)),
        occluded=np.array(draw(flags)) & np.array(draw(flags)),
    )


def _max_distance(track: Track, key: np.ndarray) -> float:
    """The largest distance of an edge from the line between its neighbouring key frames, in px."""
    worst = 0.0
    bounds = run_bounds(track.frames)
    for start, end in pairwise(bounds):
        part, chosen = slice(start, end), key[start:end]
        drawn = interpolate(track.frames[part][chosen], track.boxes[part][chosen], track.frames[part])
        worst = max(worst, float(np.abs(drawn - track.boxes[part]).max()))
    return worst


@settings(max_examples=60, deadline=None)
@given(_tracks(), st.sampled_from([0.25, 0.5, 2.0, 30.0, 500.0]))
def test_every_edge_of_every_frame_is_within_the_bound(track: Track, thin_px: float) -> None:
    key = key_frames(track, thin_px)
    assert _max_distance(track, key) <= thin_px + 1e-9
    assert key[track.key].all()
    bounds = run_bounds(track.frames)
    assert key[bounds[:-1]].all()
    assert key[bounds[1:] - 1].all()
    assert key[1:][track.occluded[1:] != track.occluded[:-1]].all()


def _fewest(track: Track, thin_px: float) -> int:
    """The smallest number of key frames, by trying every line between two frames."""
    n = len(track.frames)
    must = key_frames(replace(track, boxes=np.tile([0.0, 0, 1, 1], (n, 1))), 1e9)
    count = [0] + [n + 1] * (n - 1)
    for b in range(1, n):
        for a in range(b):
            if must[a + 1 : b].any():
                continue
            ends = track.frames[[a, b]], track.boxes[[a, b]]
            off = np.abs(interpolate(*ends, track.frames[a : b + 1]) - track.boxes[a : b + 1]).max()
            # A distance equal to the bound depends on rounding.
            if off <= thin_px + 1e-9:
                count[b] = min(count[b], count[a] + 1)
    return count[-1] + 1


@settings(max_examples=40, deadline=None)
@given(_tracks(), st.sampled_from([0.5, 5.0, 50.0]))
def test_no_choice_of_key_frames_is_smaller(track: Track, thin_px: float) -> None:
    fewest = _fewest(track, thin_px)
    assert fewest <= key_frames(track, thin_px).sum() <= max(fewest, _fewest(track, thin_px * (1 - 1e-9)))


def test_a_straight_line_needs_its_ends_only() -> None:
    along = np.arange(50)[:, None]
    track = make_track(frames=range(50), boxes=np.array([10.0, 10, 20, 20]) + along * [1.0, 0.5, 1.5, 0.75])
    assert np.flatnonzero(key_frames(track, 0.01)).tolist() == [0, 49]


def test_the_bound_allows_for_rounding() -> None:
    track = make_track(frames=range(3), boxes=[(0, 0, 10, 10), (0.5, 0, 10, 10), (0, 0, 10, 10)])
    assert key_frames(track, 0.5).sum() == 2
    assert key_frames(track, 0.5, rounding=0.005).sum() == 3


@pytest.mark.parametrize("thin_px", [0.0, -1.0])
def test_without_a_bound_every_frame_stays(thin_px: float) -> None:
    assert key_frames(make_track(jitter=0), thin_px).all()


def test_changes_of_class_and_ignored_state_stay() -> None:
    labels = np.full(30, 14)
    labels[12:15] = 3
    ignore = np.zeros(30, dtype=np.bool_)
    ignore[20:] = True
    key = key_frames(make_track(labels=labels, ignore=ignore), 1000.0)
    assert np.flatnonzero(key).tolist() == [0, 12, 15, 20, 29]


def test_key_frames_lie_at_most_a_span_apart() -> None:
    count = 3 * MAX_KEY_DISTANCE
    track = make_track(frames=range(count), boxes=np.tile([5.0, 5, 9, 9], (count, 1)))
    keys = np.flatnonzero(key_frames(track, 0.5))
    assert np.diff(keys).max() <= MAX_KEY_DISTANCE
    assert len(keys) == 4


def test_an_hour_of_tracks_takes_seconds_at_most() -> None:
    tracks = [make_track(f"m{k}", range(k, k + 50)) for k in range(500)]
    key_frames(tracks[0], 0.5)
    begin = time.process_time()
    for track in tracks * 10:
        key_frames(track, 0.5)
    assert time.process_time() - begin < 5.0
