"""Converts tracks of a data set to the evidence of a run, so all screens work with another tracker's results.

A box in the file is a detection with its score; an interpolated one is a prediction. A class is a vote of
weight 1 a frame; classes are ids of the video's label set. The store has no pixels, no predictions of the engine and no
gates: a what-if refuses it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np

from app.exchange.dataset import VideoInfo
from tsr_engine.evidence.encode import TableEntry
from tsr_engine.evidence.header import RunHeader, VideoIdentity
from tsr_engine.evidence.writer import EvidenceWriter
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.track_numbers import track_numbers
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params import Params
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import Detections, Event, FloatArray, FrameEvidence, Recognition, TrackFrame

_CHUNK = 1024
_MAX_LOG_ODDS = 30.0
"""Log-odds of the scores 0 and 1."""


class _Box(NamedTuple):
    """A track in one frame."""

    number: int
    box: FloatArray
    score: float
    stated: bool
    label: int


def write_run(
    folder: Path, video: VideoInfo, size: int, table: FrameTable, tracks: Iterable[Track], origin: JsonObject
) -> int:
    """Write the evidence of an imported run.

    Args:
        folder: empty or missing.
        video: the video of the tracks.
        size: size of its file, bytes.
        table: its frame table.
        tracks: each with at most one box per frame.
        origin: origin of the tracks: ``format``, ``file``.

    Returns:
        The number of tracks.
    """
    listed = list(tracks)
    numbers = track_numbers((track.uid for track in listed), min_number=0)
    frames: dict[int, list[_Box]] = defaultdict(list)
    events: dict[int, list[Event]] = defaultdict(list)
    for track in listed:
        _add_boxes(track, numbers[track.uid], frames, events, str(origin.get("file", "a file")))
    header = RunHeader(
        video=VideoIdentity(video.name, video.sha256, size),
        parameters=Params().model_dump(mode="json"),
        models={},
        frame_table={
            "time_base": str(table.time_base),
            "frames": video.frames,
            "width": video.width,
            "height": video.height,
            "interval": float(table.interval()),
            "imported": origin,
        },
        engine_version="imported",
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        keep_pixels=False,
    )
    count = max([CLASS_COUNT, *(_max_label(track) + 1 for track in listed)])
    votes: dict[int, FloatArray] = {}
    seconds = (table.pts.astype(np.float64) * float(table.time_base)).tolist()
    last = {numbers[track.uid]: int(track.frames[-1]) for track in listed}
    with EvidenceWriter.create(folder, header, chunk=_CHUNK) as writer:
        for k in range(video.frames):
            entry = TableEntry(int(table.pts[k]), bool(table.key[k]), bool(table.corrupt[k]))
            boxes = sorted(frames.pop(k, ()))
            writer.append(_frame(k, seconds[k], video, boxes, events.pop(k, []), votes, count), entry)
            for box in boxes:
                if last[box.number] == k:
                    votes.pop(box.number, None)
    return len(listed)


def _add_boxes(
    track: Track, number: int, frames: dict[int, list[_Box]], events: dict[int, list[Event]], file: str
) -> None:
    labels = np.full(len(track.frames), track.label) if track.labels is None else track.labels
    with np.errstate(divide="ignore"):
        log_odds = np.clip(np.log(track.score) - np.log1p(-track.score), -_MAX_LOG_ODDS, _MAX_LOG_ODDS)
    stated = track.key if track.key.any() else np.ones(len(track.frames), np.bool_)
    rows = zip(track.frames.tolist(), track.boxes, log_odds.tolist(), stated.tolist(), labels.tolist(), strict=True)
    for frame, box, score, is_stated, label in rows:
        frames[frame].append(_Box(number, box, score, is_stated, label))
    first = int(track.frames[0])
    values = {"name": track.uid}
    events[first].append(Event("born", number, f"Track {number} begins ({track.uid} in {file}).", values))
    events[first].append(
        Event("confirmed", number, f"Track {number} was imported and is confirmed from here on.", values)
    )


def _max_label(track: Track) -> int:
    return track.label if track.labels is None else max(track.label, int(track.labels.max()))


def _frame(
    k: int,
    seconds: float,
    video: VideoInfo,
    boxes: list[_Box],
    events: list[Event],
    votes: dict[int, FloatArray],
    count: int,
) -> FrameEvidence:
    stated = [box for box in boxes if box.stated]
    stated.sort(key=lambda box: -box.score if box.score == box.score else 0.0)
    rows = {box.number: i for i, box in enumerate(stated)}
    detections = Detections.empty()
    if stated:
        scores = np.array([box.score for box in stated], np.float64)
        detections = Detections(np.array([box.box for box in stated]), scores, np.full(len(stated), 0.5), scores)
    tracks = tuple(
        TrackFrame(
            track_id=box.number,
            state="confirmed",
            source="detected" if box.stated else "predicted",
            box=box.box,
            score=box.score,
            prediction=None,
            detection=rows.get(box.number),
            gate=None,
            relocalisation=None,
            samples=(),
            recognition=_vote(box, votes, count),
        )
        for box in boxes
    )
    return FrameEvidence(
        ordinal=k,
        seconds=seconds,
        width=video.width,
        height=video.height,
        detections=detections,
        shift=(0.0, 0.0),
        tracks=tracks,
        events=tuple(events),
        regions=(),
        timings={},
    )


def _vote(box: _Box, votes: dict[int, FloatArray], count: int) -> Recognition | None:
    """The file's label as one vote among ``count``; None: the file has no label."""
    if box.label < 0:
        return None
    total = votes.setdefault(box.number, np.zeros(count))
    total[box.label] += 1.0
    vote = np.zeros(count, np.float32)
    vote[box.label] = 1.0
    order = np.argsort(-total, kind="stable")
    x1, y1, x2, y2 = box.box.tolist()
    return Recognition(
        probabilities=vote,
        scale=max(x2 - x1, y2 - y1),
        weight=1.0,
        votes=total.copy(),
        class_id=int(order[0]),
        share=float(total[order[0]] / total.sum()),
        runner_up=int(order[1]),
    )
