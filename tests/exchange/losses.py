"""One table of each format's losses, and a comparison that allows nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from tests.exchange.small_datasets import tracks_of
from tsr_engine.exchange.dataset import Dataset, Track


@dataclass(frozen=True)
class Loss:
    """What a format does not round-trip.

    Attributes:
        px: largest shift of an edge.
        tracks: tracks have other names and no state or notes, and may be joined or split.
        key: all boxes are key frames.
        occluded: no box is occluded.
        score: ``kept``, or ``lost``; one mean per track counts as lost.
        ignore: ``kept`` or ``dropped`` (the box is missing).
        labels: the class of a single frame becomes the track's.
        unknown: tracks without a class are missing.
        attributes: of labels: ``all``, only those of whole ``tracks``, or ``none``.
        benchmark: labels outside the German benchmarks are lost.
    """

    px: float
    tracks: bool = False
    key: bool = False
    occluded: bool = False
    score: str = "kept"
    ignore: str = "kept"
    labels: bool = False
    unknown: bool = False
    attributes: str = "all"
    benchmark: bool = False


LOSSES = {
    "cvat-video": Loss(0.0051),
    "cvat-images": Loss(0.0051, key=True),
    "coco": Loss(0.00011),
    "yolo": Loss(1e-5, ignore="dropped"),
    "voc": Loss(0.0051),
    "mot": Loss(0.0051, key=True, score="lost", attributes="tracks"),
    "gtsrb": Loss(0.5, ignore="dropped", labels=True, unknown=True, benchmark=True),
    "gtsdb": Loss(
        0.5,
        tracks=True,
        key=True,
        occluded=True,
        score="lost",
        ignore="dropped",
        unknown=True,
        attributes="none",
        benchmark=True,
    ),
    "datumaro": Loss(0.00011),
    "label-studio": Loss(1e-4, occluded=True, score="lost", ignore="dropped", labels=True, attributes="tracks"),
    "tracks-csv": Loss(0.0),
    "tracks-json": Loss(0.0),
}


_BENCHMARK = 43
"""Labels below are those of the German benchmarks."""


def _expected(track: Track, loss: Loss) -> Iterator[tuple[int, dict[str, object]]]:
    """Each expected frame of a track, with its values."""
    if (loss.unknown and loss.labels and track.label < 0) or (loss.labels and not _has_place(track.label, loss)):
        return
    for k, frame in enumerate(track.frames.tolist()):
        label = int(track.label if track.labels is None or loss.labels else track.labels[k])
        ignore = bool(track.ignore is not None and track.ignore[k])
        if (ignore and loss.ignore == "dropped") or (loss.unknown and label < 0) or not _has_place(label, loss):
            continue
        score = float(track.score[k])
        yield (
            frame,
            {
                "box": track.boxes[k],
                "label": label,
                "ignore": ignore,
                "occluded": bool(track.occluded[k]) and not loss.occluded,
                "key": bool(track.key[k]) or loss.key,
                "score": score if loss.score == "kept" and score == score else None,
                "attributes": _attributes(track, k, loss.attributes),
            },
        )


def _has_place(label: int, loss: Loss) -> bool:
    return label < _BENCHMARK or not loss.benchmark


def _attributes(track: Track, k: int, kept: str = "all") -> dict[str, object]:
    """Expected attributes of the k-th frame."""
    changing = {name: values[k] for name, values in track.changing.items() if values[k] is not None}
    return {"all": {**track.attributes, **changing}, "tracks": dict(track.attributes), "none": {}}[kept]


def _found(track: Track) -> Iterator[tuple[int, dict[str, object]]]:
    for k, frame in enumerate(track.frames.tolist()):
        score = float(track.score[k])
        yield (
            frame,
            {
                "box": track.boxes[k],
                "label": int(track.label if track.labels is None else track.labels[k]),
                "ignore": bool(track.ignore is not None and track.ignore[k]),
                "occluded": bool(track.occluded[k]),
                "key": bool(track.key[k]),
                "score": score if score == score else None,
                "attributes": _attributes(track, k),
            },
        )


def _assert_same(expected: dict[str, object], actual: dict[str, object], loss: Loss) -> None:
    assert np.abs(np.subtract(expected["box"], actual["box"])).max() <= loss.px + 1e-9  # type: ignore[call-overload]
    for name in ("label", "ignore", "occluded", "attributes"):
        assert actual[name] == expected[name], name
    # Formats that interpolate mark more key frames to stay within the error.
    assert actual["key"] or not expected["key"]
    if loss.score == "kept":
        assert actual["score"] == (None if expected["score"] is None else pytest.approx(expected["score"], abs=1e-6))


def compare(dataset: Dataset, back: Dataset, loss: Loss) -> None:
    """Compare signs up to the format's losses; rejected tracks round-trip exactly through the manifest."""
    given = list(dataset.videos[0].tracks())
    got = tracks_of(back)
    _compare_tracks([t for t in given if t.state == "rejected"], got, Loss(0.0), "rejected")
    signs = [t for t in given if t.state != "rejected"]
    if loss.tracks:
        _compare_boxes(signs, [t for t in got.values() if t.state != "rejected"], loss)
    else:
        _compare_tracks(signs, got, loss)


def _compare_tracks(given: list[Track], back: dict[str, Track], loss: Loss, state: str = "") -> None:
    got = {uid: track for uid, track in back.items() if (track.state == "rejected") == (state == "rejected")}
    wanted = {track.uid: dict(_expected(track, loss)) for track in given}
    wanted = {uid: frames for uid, frames in wanted.items() if frames}
    assert set(got) == set(wanted)
    for track in given:
        if track.uid not in wanted:
            continue
        found = dict(_found(got[track.uid]))
        assert set(found) == set(wanted[track.uid])
        for frame, expected in wanted[track.uid].items():
            _assert_same(expected, found[frame], loss)
        read = got[track.uid]
        assert (read.state, read.source, read.notes) == (track.state, track.source, track.notes)


def _compare_boxes(given: list[Track], back: list[Track], loss: Loss) -> None:
    """Compare frame by frame in the order of rounded boxes, without names of tracks."""
    left = [(frame, frame_values) for track in given for frame, frame_values in _expected(track, loss)]
    right = [(frame, frame_values) for track in back for frame, frame_values in _found(track)]
    assert sorted(frame for frame, _ in left) == sorted(frame for frame, _ in right)
    for frame, expected in left:
        near = [
            index
            for index, (other, actual) in enumerate(right)
            if other == frame
            and actual["label"] == expected["label"]
            and np.abs(np.subtract(expected["box"], actual["box"])).max() <= loss.px + 1e-9  # type: ignore[call-overload]
        ]
        assert near, (frame, expected)
        right.pop(near[0])
