"""Renumbers the labels of tracks, after labels were merged or for an export of several label sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from pydantic import ValidationError

from tsr_engine.errors import ExportError
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.exchange.filters import change_tracks
from tsr_engine.labels.model import Label, LabelSet
from tsr_engine.labels.name_matching import comparable
from tsr_engine.track_table import NO_CLASS


def relabel_track(track: Track, numbers: Mapping[int, int]) -> Track:
    """The track with renumbered labels; labels missing in ``numbers`` keep theirs."""
    label = numbers.get(track.label, track.label)
    if track.labels is None:
        return track if label == track.label else replace(track, label=label)
    labels = np.array([numbers.get(each, each) for each in track.labels.tolist()], np.int64)
    return replace(track, label=label, labels=None if (labels == label).all() else labels)


def relabel_video(video: DatasetVideo, numbers: Mapping[int, int]) -> DatasetVideo:
    """The video with renumbered tracks in each pass."""
    return change_tracks(video, lambda track: relabel_track(track, numbers))


def resolve_merged_labels(dataset: Dataset) -> Dataset:
    """The data set with merged labels replaced by those that they were merged into."""
    numbers = dataset.labels.merged_ids()
    if not numbers:
        return dataset
    return replace(dataset, videos=tuple(relabel_video(video, numbers) for video in dataset.videos))


def unite_label_sets(parts: Sequence[tuple[LabelSet, DatasetVideo]]) -> tuple[LabelSet, tuple[DatasetVideo, ...]]:
    """Unite the label sets of several videos into one with one label per key.

    Args:
        parts: videos with their sets; the first set keeps its numbers.

    Raises:
        ExportError: two sets have labels of one key without a common name, or names that conflict.
    """
    first = parts[0][0]
    newest = {labels.key: labels for labels, _ in sorted(parts, key=lambda part: part[0].version)}
    if len(newest) == 1:
        return newest[first.key], tuple(video for _, video in parts)
    united = list(newest[first.key].labels)
    numbers: dict[str, dict[int, int]] = {first.key: {}}
    for key, labels in newest.items():
        if key != first.key:
            numbers[key] = _add_labels(labels, united, newest[first.key])
    try:
        result = LabelSet(
            key=first.key,
            version=newest[first.key].version,  # a retraining takes the newest set of a key
            name=" + ".join(labels.name for labels in newest.values())[:200],
            next_id=max((label.id for label in united), default=NO_CLASS) + 1,
            labels=tuple(united),
        )
    except ValidationError as error:
        rule = error.errors(include_url=False)[0]["msg"].removeprefix("Value error, ")
        raise ExportError(f"The videos have label sets that conflict: {rule}. Export them separately.") from None
    return result, tuple(relabel_video(video, numbers[labels.key]) for labels, video in parts)


def _add_labels(labels: LabelSet, united: list[Label], first: LabelSet) -> dict[int, int]:
    """Add the labels of a set to a list; return the ids that they have there."""
    known = {label.key.casefold(): label for label in united}
    numbers: dict[int, int] = {}
    next_id = max((label.id for label in united), default=NO_CLASS) + 1
    for label in labels:
        if label.merged_into is not None:
            continue
        existing = known.get(label.key.casefold())
        if existing is None:
            united.append(label.model_copy(update={"id": next_id, "pinned": None}))
            numbers[label.id], next_id = next_id, next_id + 1
            continue
        if not _names_of(existing) & _names_of(label):
            raise ExportError(
                f"The key {label.key!r} is {existing.name!r} in {first.name} and {label.name!r} in {labels.name}. "
                "Export these videos separately, or rename one of the two."
            )
        numbers[label.id] = existing.id
        index = united.index(existing)
        more = tuple(each for each in label.attributes if existing.attribute(each.name) is None)
        united[index] = known[label.key.casefold()] = existing.model_copy(
            update={"attributes": (*existing.attributes, *more)}
        )
    for label in labels:
        if label.merged_into is not None:
            numbers[label.id] = numbers[labels.resolved(label.id)]
    return numbers


def _names_of(label: Label) -> set[str]:
    return {comparable(name) for name in (label.name, *label.aliases)}
