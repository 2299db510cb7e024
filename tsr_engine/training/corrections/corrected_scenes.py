"""Turns corrected tracks into training data: a few frames of each sign, and background of the reviewed videos.

The review decides how a track is used:

* accepted, corrected, drawn or imported as truth: a sign;
* rejected: a false positive of the engine;
* open, in need of work, ignored, occluded, too small, or without a known class: not used.

A region without a track in a reviewed video is background: the reviewer has seen the engine's tracks and drawn
the missing ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import InputError, StorageError
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video import open_video
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.progress import Progress

__all__ = ["CorrectedScene", "Sampling", "corrected_scenes", "is_reviewed", "verdict", "video_name"]


_EDITED_SOURCES: Final = frozenset({"corrected", "human", "truth"})
"""Sources of open tracks that are used anyway, because a person has edited them."""
_SAME_PLACE_IOU: Final = 0.5
"""Least IoU of a box in another export with one that is used, so that it tells nothing more."""


@dataclass(frozen=True, slots=True)
class Sampling:
    """Numbers of frames and tracks to use.

    Attributes:
        signs: frames of each sign, spread over its sizes.
        rejected: frames of each rejected track.
        background: further frames of each reviewed video, evenly spread.
        min_width: narrowest sign that is used, px.
        max_tracks: largest number of signs, and of rejected tracks, of all videos together; beyond it they are drawn at
            random, all classes equally often. Training time grows with this number.
    """

    signs: int = 12
    rejected: int = 6
    background: int = 10
    min_width: float = 14.0
    max_tracks: int = 200


@dataclass(frozen=True, slots=True)
class CorrectedScene:
    """One frame of a reviewed video.

    Attributes:
        scene: picture, signs and ignored regions.
        video: name of the video.
        signs: name of the physical sign of each box.
        rejected: boxes of rejected tracks, shape (k, 4).
        rejected_tracks: name of the track of each.
    """

    scene: Scene
    video: str
    signs: tuple[str, ...]
    rejected: FloatArray = field(default_factory=lambda: np.zeros((0, 4)))
    rejected_tracks: tuple[str, ...] = ()

    def without(self, held: frozenset[str]) -> CorrectedScene:
        """The scene with some signs and rejected tracks ignored, because they belong to another part of a split."""
        kept = np.array([sign not in held for sign in self.signs], dtype=bool)
        kept_rejected = np.array([track not in held for track in self.rejected_tracks], dtype=bool)
        if kept.all() and kept_rejected.all():
            return self
        scene = self.scene
        ignored = np.concatenate([scene.ignored, scene.boxes[~kept], self.rejected[~kept_rejected]])
        return CorrectedScene(
            Scene(scene.name, scene.path, scene.boxes[kept], scene.class_ids[kept], ignored),
            self.video,
            tuple(sign for sign in self.signs if sign not in held),
            self.rejected[kept_rejected],
            tuple(track for track in self.rejected_tracks if track not in held),
        )


def verdict(track: Track) -> str:
    """How a track is used: ``sign``, ``rejected`` or ``unknown``."""
    if track.ignore is not None and track.ignore.all():
        return "unknown"
    if track.state == "rejected":
        return "rejected"
    if track.state == "needs_work" or track.label < 0:
        return "unknown"
    return "sign" if track.state in ("accepted", "truth") or track.source in _EDITED_SOURCES else "unknown"


def video_name(video: DatasetVideo) -> str:
    """The video's name within the names of its signs."""
    return video.sha256 or video.name


def is_reviewed(video: DatasetVideo) -> bool:
    """Whether a person has judged or edited any of the video's tracks."""
    return any(verdict(track) != "unknown" for track in video.tracks())


def corrected_scenes(
    dataset: Dataset,
    work: Path,
    sampling: Sampling,
    progress: Progress | None = None,
    pictures: Sequence[Mapping[int, Path]] = (),
    seed: int = 0,
) -> list[CorrectedScene]:
    """Decode frames of a data set's reviewed videos into a folder.

    Args:
        dataset: videos with their files; a video with neither file nor pictures is skipped. A video may occur several
            times, once for each export of it.
        work: folder for the pictures; existing ones are not decoded again.
        sampling: numbers of frames and tracks.
        progress: called with stage, frames done and total; may raise to stop.
        pictures: per video, frame -> picture, for videos without a file; then only these frames are used.
        seed: seed of the draw if there are too many tracks.

    Raises:
        InputError: a video cannot be read, or has fewer frames than its tracks.
        StorageError: a picture cannot be written.
    """
    report: Progress = progress or (lambda *_: None)
    out: list[CorrectedScene] = []
    chosen = _choose_tracks(dataset, sampling.max_tracks, seed)
    for number, video in enumerate(dataset.videos):
        video_pictures = pictures[number] if number < len(pictures) else {}
        if not is_reviewed(video) or (video.path is None and not video_pictures):
            continue
        frames = _frames_to_decode(video, sampling, chosen)
        if video.path is None:
            files = {int(k): video_pictures[int(k)] for k in frames if int(k) in video_pictures}
        else:
            files = _decode(video, video.path, work / f"v{number:03d}", frames, report)
        elsewhere = [
            track
            for other in dataset.videos
            if other is not video and video_name(other) == video_name(video)
            for track in other.tracks()
        ]
        out += _scenes_of_video(video, files, sampling, chosen, elsewhere)
    return out


@dataclass(slots=True)
class _Frame:
    """The signs and rejected boxes of one frame."""

    boxes: list[FloatArray] = field(default_factory=list)
    classes: list[int] = field(default_factory=list)
    signs: list[str] = field(default_factory=list)
    ignored: list[FloatArray] = field(default_factory=list)
    rejected: list[FloatArray] = field(default_factory=list)
    rejected_tracks: list[str] = field(default_factory=list)


def _choose_tracks(dataset: Dataset, max_tracks: int, seed: int) -> frozenset[tuple[str, str]]:
    """(video, uid) of the tracks to use: all, or the largest allowed number in rounds over the classes."""
    rng = np.random.default_rng([seed, 61])
    kinds: dict[str, dict[int, list[tuple[str, str]]]] = {"sign": {}, "rejected": {}}
    for video in dataset.videos:
        for track in video.tracks():
            kind = verdict(track)
            if kind in kinds:
                kinds[kind].setdefault(track.label, []).append((video_name(video), track.uid))
    chosen: list[tuple[str, str]] = []
    for by_class in kinds.values():
        queues = [[names[i] for i in rng.permutation(len(names))] for _, names in sorted(by_class.items())]
        rounds = [queue[k] for k in range(max(map(len, queues), default=0)) for queue in queues if k < len(queue)]
        chosen += rounds[:max_tracks]
    return frozenset(chosen)


def _scenes_of_video(
    video: DatasetVideo,
    files: Mapping[int, Path],
    sampling: Sampling,
    chosen: frozenset[tuple[str, str]],
    elsewhere: Sequence[Track],
) -> list[CorrectedScene]:
    """Scenes of a video; places of tracks that it has ``elsewhere``, in other exports, are no background."""
    frames = {k: _Frame() for k in files}
    name = video_name(video)
    for track in video.tracks():
        _add_track(frames, track, f"{name}/{track.uid}", sampling.min_width, (name, track.uid) in chosen)
    for track in elsewhere:
        for i in np.flatnonzero(np.isin(track.frames, list(frames))):
            frame = frames[int(track.frames[i])]
            if not (iou(track.boxes[i], _rows([*frame.boxes, *frame.rejected])) >= _SAME_PLACE_IOU).any():
                frame.ignored.append(track.boxes[i])
    scenes = []
    for number, frame in frames.items():
        scene = Scene(
            f"{video.name}#{number}",
            files[number],
            _rows(frame.boxes),
            np.array(frame.classes, dtype=np.int64),
            _rows(frame.ignored),
        )
        rejected = _rows(frame.rejected), tuple(frame.rejected_tracks)
        scenes.append(CorrectedScene(scene, name, tuple(frame.signs), *rejected))
    return scenes


def _rows(boxes: Sequence[FloatArray]) -> FloatArray:
    return np.array(boxes, dtype=np.float64).reshape(-1, 4)


def _add_track(frames: dict[int, _Frame], track: Track, name: str, min_width: float, chosen: bool) -> None:
    """Add a track to the frames that are used."""
    kind = verdict(track) if chosen else "unknown"
    clear = _is_clear(track, min_width)
    ignored = np.zeros(len(track.frames), np.bool_) if track.ignore is None else track.ignore
    for i in np.flatnonzero(np.isin(track.frames, list(frames))):
        frame, box = frames[int(track.frames[i])], track.boxes[i]
        label = int(track.label if track.labels is None else track.labels[i])
        if kind == "rejected" and not ignored[i]:
            frame.rejected.append(box)
            frame.rejected_tracks.append(name)
        elif kind == "sign" and clear[i] and label >= 0:
            frame.boxes.append(box)
            frame.classes.append(label)
            frame.signs.append(name)
        else:
            frame.ignored.append(box)


def _is_clear(track: Track, min_width: float) -> NDArray[np.bool_]:
    """Whether each box of a track shows the sign well enough, shape (n,)."""
    is_wide = (track.boxes[:, 2:] - track.boxes[:, :2]).min(axis=1) >= min_width
    is_clear = is_wide & ~track.occluded
    return np.asarray(is_clear if track.ignore is None else is_clear & ~track.ignore)


def _frames_to_decode(video: DatasetVideo, sampling: Sampling, chosen: frozenset[tuple[str, str]]) -> NDArray[np.int64]:
    """Frames to decode, ascending."""
    stop = video.stop or video.frames
    wanted: list[NDArray[np.generic]] = [
        np.linspace(video.first, stop - 1, min(sampling.background, max(1, stop - video.first)))
    ]
    for track in video.tracks():
        kind = verdict(track)
        if kind == "unknown" or (video_name(video), track.uid) not in chosen:
            continue
        usable, count = np.arange(len(track.frames)), sampling.rejected
        if kind == "sign":
            usable, count = np.flatnonzero(_is_clear(track, sampling.min_width)), sampling.signs
        if len(usable):
            wanted.append(track.frames[usable][_spread_indices(track.boxes[usable], count)])
    frames = np.unique(np.concatenate(wanted).astype(np.int64))
    return np.asarray(frames[(frames >= 0) & (frames < video.frames)])


def _spread_indices(boxes: FloatArray, count: int) -> NDArray[np.int64]:
    """Indices of at most ``count`` boxes, evenly spread over the sign's growth and over time."""
    size = np.log(np.maximum(1.0, np.prod(boxes[:, 2:] - boxes[:, :2], axis=1))) / 2
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(size)) + 0.01)])
    positions = np.linspace(0.0, path[-1], min(count, len(boxes)))
    return np.unique(np.searchsorted(path, positions).clip(0, len(boxes) - 1))


def _decode(
    video: DatasetVideo, path: VideoSource, folder: Path, frames: NDArray[np.int64], progress: Progress
) -> dict[int, Path]:
    """Write the wanted frames as pictures; frame -> file."""
    files = {int(k): folder / f"{int(k):07d}.png" for k in frames}
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(f"Cannot make the folder {folder} for training pictures: {error.strerror}.") from None
    missing = [k for k, file_path in files.items() if not file_path.exists()]
    if not missing:
        return files
    with open_video(path, limits=video.limits) as file:
        for done, k in enumerate(missing):
            progress(f"decoding {video.name}", done, len(missing))
            if k >= len(file.table) and file.table.complete:
                raise InputError(f"{path} has {len(file.table)} frames, but a track names frame {k}. Is it the video?")
            _write(files[k], file.read(k).picture)
    return files


def _write(path: Path, picture: Picture) -> None:
    part = path.with_suffix(".part.png")
    if not cv2.imwrite(str(part), picture, [cv2.IMWRITE_PNG_COMPRESSION, 1]):
        raise StorageError(f"Cannot write the training picture {path}. Is the disk full?")
    part.replace(path)
