"""The shipped clips are small and complete, with matching ground truth."""

from __future__ import annotations

import json
from itertools import groupby

import av
import pytest

from sample_videos import SHIPPED
from sample_videos.ground_truth import MIN_FACE_PX
from sample_videos.shipped import ShippedClip
from tests.sample_videos.truth_rows import read_rows
from tsr_engine.pictograms.gtsrb import N_CLASSES


def test_two_clips_below_six_megabytes() -> None:
    assert len(SHIPPED) == 2
    assert sum(clip.video.stat().st_size for clip in SHIPPED) < 6_000_000


@pytest.mark.parametrize("clip", SHIPPED, ids=lambda clip: clip.video.stem)
def test_ground_truth_matches_the_video(clip: ShippedClip) -> None:
    facts = json.loads(clip.truth.with_suffix(".json").read_text())
    with av.open(str(clip.video)) as container:
        stream = container.streams.video[0]
        size = (stream.width, stream.height)
        assert stream.codec_context.name == "h264"
        assert float(stream.average_rate) == facts["fps"]
        count = sum(1 for packet in container.demux(stream) if packet.size)
    assert (size, count) == ((facts["width"], facts["height"]), facts["frames"])
    rows = read_rows(clip.truth)
    assert max(r.frame for r in rows) < count
    assert len({(r.frame, r.track_id) for r in rows}) == len(rows)
    for r in rows:
        assert 0 <= r.x1 < r.x2 <= size[0]
        assert 0 <= r.y1 < r.y2 <= size[1]
        assert 0 <= r.class_id < N_CLASSES
        assert 0 <= r.visibility <= 1
    assert {r.track_id for r in rows} == {s["track_id"] for s in facts["signs"]}


@pytest.mark.parametrize("clip", SHIPPED, ids=lambda clip: clip.video.stem)
def test_signs_loom_and_leave(clip: ShippedClip) -> None:
    rows = sorted(read_rows(clip.truth), key=lambda r: (r.track_id, r.frame))
    grown, classes = 0, set()
    for _, run in groupby(rows, key=lambda r: r.track_id):
        track = list(run)
        first, last = track[0], track[-1]
        big = max(track, key=lambda r: r.y2 - r.y1)
        assert len({r.class_id for r in track}) == 1
        if first.x2 - first.x1 < MIN_FACE_PX and big.y2 - big.y1 > 60:
            grown += 1
            classes.add(first.class_id)
            assert last.frame < rows[-1].frame or last.frame >= big.frame
    assert grown >= 4
    assert len(classes) >= 4


def test_stress_is_recorded() -> None:
    kinds = {e["kind"] for clip in SHIPPED for e in json.loads(clip.truth.with_suffix(".json").read_text())["events"]}
    assert {"glare", "bridge_shadow", "occlusion", "bump"} <= kinds
