"""Selects the part of a data set that is exported: review states, labels, sizes, frames."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import UsageError
from tsr_engine.exchange.dataset import REJECTED, Dataset, DatasetVideo, Skipped, Track
from tsr_engine.plural import plural
from tsr_engine.track_table import NO_CLASS

EDITED_SOURCES = frozenset({"corrected", "human"})
"""Sources of tracks that a person has edited."""
NotInSet = Literal["leave-out", "ignore", "class"]


@dataclass(frozen=True, slots=True)
class Filters:
    """The filters of an export; a track must pass all of them.

    Attributes:
        states: review states, and ``edited`` for open tracks that a person has edited; None: all.
        labels: ids of labels, -1 for tracks without a label of the set; None: all.
        not_in_set: treatment of tracks without a label of the set: ``leave-out``, ``ignore`` (exported as regions to
            ignore), or ``class`` (exported as a class). Rejected tracks are exported as rejected in any case.
        min_side: smallest shorter side of an exported box, px; None: all sizes.
        first: first frame.
        stop: frame after the last; None: to the end.
    """

    states: frozenset[str] | None = None
    labels: frozenset[int] | None = None
    not_in_set: NotInSet = "class"
    min_side: float | None = None
    first: int = 0
    stop: int | None = None

    def __post_init__(self) -> None:
        if self.first < 0 or (self.stop is not None and self.stop <= self.first):
            raise UsageError(f"The frames must be 0 <= first < stop. Got {self.first} to {self.stop}.")
        if self.min_side is not None and not 0 <= self.min_side < float("inf"):
            raise UsageError(f"The smallest side must be 0 px or more. Got {self.min_side}.")


def select_frames(track: Track, chosen: NDArray[np.bool_]) -> Track | None:
    """The track restricted to some of its frames; None: no frame is chosen.

    Args:
        track: the track.
        chosen: whether each frame is taken, shape (n,).
    """
    if chosen.all():
        return track
    if not chosen.any():
        return None
    frames = track.frames[chosen]
    known = set(frames.tolist())
    return replace(
        track,
        frames=frames,
        boxes=track.boxes[chosen],
        key=track.key[chosen],
        occluded=track.occluded[chosen],
        score=track.score[chosen],
        labels=None if track.labels is None else track.labels[chosen],
        ignore=None if track.ignore is None else track.ignore[chosen],
        silent=None if track.silent is None else track.silent[chosen],
        notes=tuple(note for note in track.notes if note[0] in known),
        changing={name: values[chosen] for name, values in track.changing.items()},
    )


def filter_dataset(dataset: Dataset, filters: Filters) -> Dataset:
    """The part of the data set that passes the filters; ``skipped`` counts the rest, ``left_out`` of a video holds it.

    Tracks are filtered anew in each pass; one pass here finds the rest.

    Raises:
        UsageError: no frame of a video that was examined lies in the range.
    """
    videos: list[DatasetVideo] = []
    skipped = list(dataset.skipped)
    for video in dataset.videos:
        end = video.stop or video.frames
        first, stop = max(video.first, filters.first), min(end, filters.stop or end)
        if first >= stop:
            raise UsageError(
                f"{video.name} was examined in frames {video.first} to {end - 1}; none of frames {filters.first} to "
                f"{(filters.stop or video.frames) - 1} is among them. Choose others."
            )
        part = change_tracks(replace(video, first=first, stop=stop), partial(_filter_track, filters, first, stop))
        left_out, counts = _find_left_out(video, part, filters)
        videos.append(replace(part, left_out=left_out))
        skipped += counts
    return replace(dataset, videos=tuple(videos), skipped=tuple(skipped))


def with_left_out(part: Dataset, whole: Dataset) -> Dataset:
    """A part of a data set with the boxes that it lacks, in the frames of its videos, as their ``left_out``."""
    videos = (
        replace(video, left_out=tuple(_left_out(video, complete)))
        for video, complete in zip(part.videos, whole.videos, strict=True)
    )
    return replace(part, videos=tuple(videos))


def _left_out(part: DatasetVideo, whole: DatasetVideo) -> Iterator[Track]:
    kept_frames = {track.uid: track.frames for track in part.tracks()}
    for track in whole.tracks():
        inside = (track.frames >= part.first) & (track.frames < (part.stop or part.frames))
        kept = np.isin(track.frames, kept_frames.get(track.uid, ()))
        lacking = select_frames(track, inside & ~kept)
        if lacking is not None:
            yield lacking


def count_open_left_out(dataset: Dataset, filters: Filters) -> int:
    """Number of tracks that the filters leave out because nobody has judged or edited them."""
    if filters.states is None or "open" in filters.states:
        return 0
    states = replace(filters, labels=None, not_in_set="class")
    return sum(
        track.state == "open" and track.source not in EDITED_SOURCES and _reason_left_out(track, states) is not None
        for video in dataset.videos
        for track in video.tracks()
    )


def change_tracks(video: DatasetVideo, change: Callable[[Track], Track | None]) -> DatasetVideo:
    """The video with changed tracks, in each pass; ``change`` returns None for a track to leave out."""
    return replace(video, tracks=lambda: (track for track in map(change, video.tracks()) if track is not None))


def clip_track(track: Track, size: tuple[int, int]) -> tuple[Track | None, int]:
    """The track with its boxes clipped at the picture, and the number of clipped boxes.

    Args:
        track: None is returned for it if it lies outside of the picture.
        size: width and height of the picture, px.
    """
    boxes = track.boxes
    if (boxes[:, :2] >= 0).all() and (boxes[:, 2:] <= size).all():
        return track, 0
    clipped = np.clip(boxes, 0.0, (*size, *size))
    inside: NDArray[np.bool_] = np.all(clipped[:, :2] < clipped[:, 2:], axis=1)
    part = select_frames(replace(track, boxes=clipped), inside)
    return part, int(((clipped != boxes).any(axis=1) & inside).sum())


def without_ignored(dataset: Dataset) -> tuple[Dataset, int]:
    """The data set without boxes to ignore, filtered in each pass, and the number of these boxes."""
    boxes = sum(
        int(track.ignore.sum()) for video in dataset.videos for track in video.tracks() if track.ignore is not None
    )
    if not boxes:
        return dataset, 0

    def change(track: Track) -> Track | None:
        kept = track if track.ignore is None else select_frames(track, ~track.ignore)
        return None if kept is None else replace(kept, notes=track.notes)

    return replace(dataset, videos=tuple(change_tracks(video, change) for video in dataset.videos)), boxes


def clip_dataset(dataset: Dataset) -> Dataset:
    """The data set with all boxes clipped at their pictures, in each pass."""

    def clip_video(video: DatasetVideo) -> DatasetVideo:
        return change_tracks(video, lambda track: clip_track(track, (video.width, video.height))[0])

    return replace(dataset, videos=tuple(map(clip_video, dataset.videos)))


def _reason_left_out(track: Track, filters: Filters) -> str | None:
    """The reason why a whole track is left out; None: it is not."""
    if filters.states is not None and track.state not in filters.states:
        edited = track.state == "open" and track.source in EDITED_SOURCES
        if not (edited and "edited" in filters.states):
            return f"Their review state is {track.state}."
    if filters.labels is not None and track.label not in filters.labels:
        return "Their label was not chosen."
    if filters.not_in_set == "leave-out" and track.label == NO_CLASS and track.state != REJECTED:
        return "They have no label of the set (not_in_set=leave-out)."
    return None


def _filter_track(filters: Filters, first: int, stop: int, track: Track) -> Track | None:
    if _reason_left_out(track, filters) is not None:
        return None
    chosen = (track.frames >= first) & (track.frames < stop)
    if filters.not_in_set != "class" and track.state != REJECTED:
        unlabelled = (
            np.full(len(track.frames), track.label == NO_CLASS) if track.labels is None else track.labels == NO_CLASS
        )
        if filters.not_in_set == "leave-out":
            chosen &= ~unlabelled
        elif unlabelled.any():
            track = replace(track, ignore=unlabelled if track.ignore is None else unlabelled | track.ignore)
    if filters.min_side is not None:
        sides = np.minimum(track.boxes[:, 2] - track.boxes[:, 0], track.boxes[:, 3] - track.boxes[:, 1])
        chosen &= sides >= filters.min_side
    return select_frames(track, chosen)


def _find_left_out(
    video: DatasetVideo, part: DatasetVideo, filters: Filters
) -> tuple[tuple[Track, ...], list[Skipped]]:
    """What a part of a video lacks in its frames; and the numbers of all boxes and tracks that it lacks."""
    lacking: list[Track | None] = []
    track_counts = Counter[str]()
    outside_boxes = small_boxes = no_label_boxes = 0
    for track in video.tracks():
        inside = (track.frames >= part.first) & (track.frames < part.stop)
        why = _reason_left_out(track, filters)
        if why is not None:
            track_counts[why] += 1
            lacking.append(select_frames(track, inside))
            continue
        outside_boxes += int((~inside).sum())
        kept = _filter_track(filters, part.first, part.stop, track)
        left_out = int(inside.sum()) - (0 if kept is None else len(kept.frames))
        if left_out:
            lacking.append(select_frames(track, inside & ~np.isin(track.frames, () if kept is None else kept.frames)))
        unlabelled = 0
        if filters.not_in_set == "leave-out" and track.labels is not None and track.state != REJECTED:
            unlabelled = int((inside & (track.labels == NO_CLASS)).sum())
        no_label_boxes += unlabelled
        small_boxes += max(left_out - unlabelled, 0)
    found = [(plural(count, "track"), why) for why, count in sorted(track_counts.items())]
    for boxes, why in (
        (no_label_boxes, "They have no label of the set (not_in_set=leave-out)."),
        (outside_boxes, f"They lie outside of frames {part.first} to {part.stop - 1}."),
        (small_boxes, f"Their shorter side is below {filters.min_side or 0:g} px."),
    ):
        if boxes:
            found.append((plural(boxes, "box", "boxes"), why))
    skipped = [Skipped(f"{video.name}: {what}", reason) for what, reason in found]
    return tuple(track for track in lacking if track is not None), skipped
