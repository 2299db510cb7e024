"""Tracks of annotated videos, and whether a person who knows the ground truth would change them.

The evidence of the runs is kept, so that a stopped measurement can continue.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from app.evidence.disagreement import MIN_IOU, compare_with_run
from app.evidence.run_columns import confirmed_boxes
from app.evidence.tracks import TrackProperties, read_track_properties
from app.evidence.uncertainty import Disagreement
from benchmarks.boxes import share_inside
from benchmarks.cache import ENGINE, code, file_digest
from benchmarks.corruptions.video import dim, write_changed
from tsr_engine.errors import TsrError
from tsr_engine.evaluation.track_tables import every_nth_frame
from tsr_engine.evidence import EvidenceReader
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.labels.files import shipped_set
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, load_components
from tsr_engine.runs.track_video import RunRequest, track_video
from tsr_engine.track_table import TrackTable

RUNS: Mapping[str, Params] = {
    "default": Params.preset("default"),
    "lenient": Params.preset("default").with_settings(
        [("birth_score", -4.0), ("confirm_score", -4.0), ("sure_score", None)]
    ),
    "paper": Params.preset("paper"),
}
"""Runs that people review: as shipped; with the tracks of weak detections that are left out otherwise; and the preset
that makes the most mistakes."""
COMPARED_WITH: Mapping[str, str] = {"default": "paper", "lenient": "default", "paper": "default"}
"""Name of the run that the queue compares each run with."""

MIN_BOX_IOU = 0.5
"""IoU below which a person moves a box, or deletes it if the sign is gone."""
LOOSE_FRAMES, LOOSE_SHARE = 2, 0.1
"""Least number of such frames, and their share of all, for which a person corrects the boxes of a track."""
EDGE = 2.0
"""Distance from the picture's edge, px, within which a box may show a part of a sign that the annotation leaves out."""
ALL_FRAMES = (0, 2**62)


@dataclass(frozen=True, slots=True)
class FilmedVideo:
    """A video as a camera films it.

    Attributes:
        clip: name of the video.
        camera: name in ``CAMERAS``.
        path: the file.
        truth: ground truth in its frames and pixels.
    """

    clip: str
    camera: str
    path: Path
    truth: TrackTable


@dataclass(frozen=True, slots=True)
class JudgedRun:
    """The confirmed tracks of one run.

    Attributes:
        clip: name of the video.
        camera: name in ``CAMERAS``.
        run: name in ``RUNS``.
        properties: properties of each track from the evidence.
        disagreement: differences from the run of ``COMPARED_WITH``.
        changes: why a person changes each track: ``false``, ``label``, ``boxes`` or ``split``; empty: they accept it;
            None: unknown from the ground truth.
    """

    clip: str
    camera: str
    run: str
    properties: TrackProperties
    disagreement: Disagreement
    changes: tuple[str | None, ...]


def _coarse(source: Path, place: Path) -> None:
    with open_video(source) as video:
        width, height = video.width // 2, video.height // 2
        with VideoWriter(place, width, height, video.rate, crf=32) as writer:
            for frame in video.frames():
                writer.write(cv2.resize(frame.picture, (width, height), interpolation=cv2.INTER_AREA))


def _slow(source: Path, place: Path) -> None:
    with open_video(source) as video, VideoWriter(place, video.width, video.height, video.rate / SLOW) as writer:
        for frame in video.frames():
            if frame.ordinal % SLOW == 0:
                writer.write(frame.picture)


@dataclass(frozen=True, slots=True)
class Camera:
    """Another way to film a video.

    Attributes:
        film: writes the camera's version of a video; None: the video itself.
        truth: converts the ground truth to the version's frames and pixels.
    """

    film: Callable[[Path, Path], object] | None = None
    truth: Callable[[TrackTable], TrackTable] = lambda truth: truth


SLOW = 3
CAMERAS: Mapping[str, Camera] = {
    "as filmed": Camera(),
    "dim": Camera(partial(write_changed, dim)),
    "coarse": Camera(_coarse, lambda truth: replace(truth, boxes=truth.boxes / 2)),
    "slow": Camera(_slow, lambda truth: every_nth_frame(truth, SLOW)),
}
"""Worse cameras, for mistakes that hardly occur with good ones: a fifth of the light; half the size and strong
compression; every third frame."""


def film(videos: Mapping[str, tuple[Path, TrackTable]], scratch: Path, cameras: Sequence[str]) -> Iterator[FilmedVideo]:
    """Yield each video as filmed by each camera.

    Args:
        videos: name -> (file, ground truth).
        scratch: folder for the videos of the worse cameras.
        cameras: names in ``CAMERAS``.
    """
    for name, (path, truth) in videos.items():
        for camera in cameras:
            way = CAMERAS[camera]
            place = path
            if way.film is not None:
                place = scratch / camera / f"{file_digest(path)[:16]}.mp4"
                if not place.is_file():
                    place.parent.mkdir(parents=True, exist_ok=True)
                    way.film(path, place)
            yield FilmedVideo(name, camera, place, way.truth(truth))


def judged_runs(videos: Iterable[FilmedVideo], scratch: Path) -> Iterator[JudgedRun]:
    """Run each video with the parameters of ``RUNS`` and judge the tracks of each run.

    Args:
        videos: videos with ground truth.
        scratch: folder for the evidence.
    """
    components = {name: load_components(params) for name, params in RUNS.items()}
    labels = shipped_set("gtsrb-43")
    for video in videos:
        properties, boxes = {}, {}
        for name, params in RUNS.items():
            with EvidenceReader(_evidence(video.path, params, components[name], scratch / name)) as reader:
                properties[name], boxes[name] = read_track_properties(reader), confirmed_boxes(reader)
                size = int(reader.header.frame_table["width"]), int(reader.header.frame_table["height"])
        for name, other in COMPARED_WITH.items():
            own = properties[name]
            disagreement = compare_with_run(boxes[name], boxes[other], own, other, ALL_FRAMES, labels)
            changes = judge(boxes[name], own.class_id, video.truth, size)
            yield JudgedRun(video.clip, video.camera, name, own, disagreement, changes)


def judge(
    tracks: TrackTable, labels: NDArray[np.int64], truth: TrackTable, size: tuple[int, int]
) -> tuple[str | None, ...]:
    """Why a person who knows the truth changes each track.

    Args:
        tracks: boxes of the tracks.
        labels: label of each track.
        truth: ground truth of the video.
        size: width and height of the pictures, px.

    Returns:
        One entry for each track, see :class:`JudgedRun`.
    """
    tracks = tracks.inside(*size)
    signs, changes = [], []
    for track in range(len(tracks.names)):
        rows = np.flatnonzero(tracks.track == track)
        sign, change = _judge_track(tracks.boxes[rows], tracks.frame[rows], int(labels[track]), truth, size)
        signs.append(sign)
        changes.append(change)
    shared = {sign for sign in signs if sign is not None and signs.count(sign) > 1}
    return tuple(
        "split" if change == "" and sign in shared else change for sign, change in zip(signs, changes, strict=True)
    )


def _judge_track(
    boxes: NDArray[np.float64], frames: NDArray[np.int64], label: int, truth: TrackTable, size: tuple[int, int]
) -> tuple[int | None, str | None]:
    """The sign that a track shows, and why a person changes the track."""
    overlap: dict[int, dict[int, float]] = {}
    excused = _at_edge(boxes, size)
    for k, frame in enumerate(frames.tolist()):
        here = np.flatnonzero(truth.frame == frame)
        found = iou(boxes[k : k + 1], truth.boxes[here])[0]
        inside = share_inside(boxes[k : k + 1], truth.boxes[here])[0]
        excused[k] |= bool((truth.ignore[here] & (np.maximum(found, inside) >= MIN_BOX_IOU)).any())
        for row, value in zip(here.tolist(), found.tolist(), strict=True):
            if not truth.ignore[row] and value >= MIN_IOU:
                overlap.setdefault(int(truth.track[row]), {})[k] = value
    if not overlap:
        return None, None if excused.mean() >= MIN_BOX_IOU else "false"
    sign = max(overlap, key=lambda one: (len(overlap[one]), -one))
    if label != int(truth.class_id[truth.track == sign][0]):
        return sign, "label"
    loose = sum(not excused[k] and overlap[sign].get(k, 0.0) < MIN_BOX_IOU for k in range(len(frames)))
    return sign, "boxes" if loose >= LOOSE_FRAMES and loose > LOOSE_SHARE * len(frames) else ""


def _at_edge(boxes: NDArray[np.float64], size: tuple[int, int]) -> NDArray[np.bool_]:
    outside = (boxes[:, :2] <= EDGE).any(axis=1) | (boxes[:, 2:] >= np.array(size) - EDGE).any(axis=1)
    return np.asarray(outside, dtype=np.bool_)


def _evidence(path: Path, params: Params, components: Components, store: Path) -> Path:
    folder = store / f"{file_digest(path)[:16]}-{code(ENGINE)[:16]}"
    if not _is_complete(folder):
        track_video(RunRequest(path, params, evidence=folder, restart=True), components)
    return folder


def _is_complete(folder: Path) -> bool:
    try:
        with EvidenceReader(folder) as reader:
            return reader.state == "complete"
    except TsrError:  # missing or damaged evidence is made again
        return False
