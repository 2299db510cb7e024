"""Maps corrections to the classes of a model, whose labels may differ from the corrections' label set.

A label's ``teach`` says how a retraining uses it: as a sign, as background, or not at all. Labels that the model lacks
are added to it if its classifier is trained. A retraining does not use tracks without a label of the set, tracks of a
region to ignore, tracks that contradict each other, or labels that the model lacks and is not given. The last two are
reported by name. Of a sign that several exports have it uses the first, because a sign under two names could be held
out under one and learned under the other.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tsr_engine.exchange.dataset import REJECTED, Track
from tsr_engine.exchange.relabel import relabel_track
from tsr_engine.geometry.boxes import iou_each
from tsr_engine.labels.classes import RunClasses, classes_of_keys
from tsr_engine.labels.model import LabelSet
from tsr_engine.plural import plural
from tsr_engine.track_table import NO_CLASS
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene, verdict, video_name
from tsr_engine.training.corrections.exports import OpenedExport

__all__ = ["drop_unseen_labels", "map_to_classes", "new_label_keys"]

_SAME_SIGN_IOU = 0.5
"""Least IoU of two boxes of one frame that are the same sign."""
_MAX_LISTED = 20
"""Largest number of contradictions that are listed; the rest are counted."""


def new_label_keys(exports: Sequence[OpenedExport], keys: Sequence[str] | None) -> tuple[str, ...]:
    """Keys of labels that tracks of signs have and a model lacks, in order.

    Args:
        exports: exports with labels of their own sets.
        keys: keys of the model's classes by number; None: those of ``gtsrb-43``.
    """
    found: dict[str, str] = {}
    for export in _with_newest_labels(exports):
        classes = classes_of_keys(keys, export.dataset.labels)
        for track in (track for video in export.dataset.videos for track in video.tracks()):
            label = classes.labels.get(classes.labels.resolved(track.label))
            teaches = label is not None and label.teach == "sign" and verdict(track) == "sign"
            if label is not None and teaches and classes.to_class(label.id) is None:
                found.setdefault(label.key.casefold(), label.key)
    return tuple(found[key] for key in sorted(found))


def drop_unseen_labels(
    scenes: Sequence[CorrectedScene], known: int, further: Sequence[str]
) -> tuple[list[CorrectedScene], tuple[str, ...]]:
    """The further labels that occur in a frame, and the scenes with classes renumbered without the other labels.

    Args:
        scenes: corrected frames.
        known: number of the model's own classes; ``further`` follows them.
        further: keys of the labels to add.
    """
    numbers = np.unique(np.concatenate([np.zeros(0, np.int64), *(each.scene.class_ids for each in scenes)]))
    shown = [int(number) - known for number in numbers if number >= known]
    new_numbers = np.arange(known + len(further))
    new_numbers[[known + index for index in shown]] = known + np.arange(len(shown))
    return (
        [replace(each, scene=replace(each.scene, class_ids=new_numbers[each.scene.class_ids])) for each in scenes],
        tuple(further[index] for index in shown),
    )


def map_to_classes(exports: Sequence[OpenedExport], keys: Sequence[str] | None) -> list[OpenedExport]:
    """The exports with the model's class numbers in place of labels, and with notes on unused tracks.

    Args:
        exports: exports with labels of their own sets.
        keys: keys of the model's classes by number; None: those of ``gtsrb-43``.
    """
    exports = _with_newest_labels(exports)
    tracks = [[tuple(video.tracks()) for video in export.dataset.videos] for export in exports]
    found, repeated = _pairs(exports, tracks, keys)
    unused = {used.place for pair in found for used in pair.tracks} | {used.place for used in repeated}
    mapped = []
    for number, export in enumerate(exports):
        classes = classes_of_keys(keys, export.dataset.labels)
        missing_labels: Counter[str] = Counter()
        videos = []
        for video_number, (video, video_tracks) in enumerate(zip(export.dataset.videos, tracks[number], strict=True)):
            kept = tuple(
                replace(track, label=NO_CLASS, labels=None, state="needs_work")
                if (number, video_number, track.uid) in unused
                else _as_classes(track, classes, missing_labels)
                for track in video_tracks
            )
            videos.append(replace(video, tracks=lambda kept=kept: iter(kept)))  # type: ignore[misc]
        notes = (
            *export.notes,
            *_missing_label_notes(export, missing_labels),
            *(pair.sentence for pair in found if pair.export == number),
        )
        dataset = replace(export.dataset, videos=tuple(videos))
        mapped.append(replace(export, dataset=dataset, notes=tuple(dict.fromkeys(_shortened(notes)))))
    return mapped


def _with_newest_labels(exports: Sequence[OpenedExport]) -> list[OpenedExport]:
    """The exports with the labels of the newest version of their set that one of them has.

    Otherwise two exports, one from before a merge of labels, would teach one label as two classes.
    """
    sets = sorted((each.dataset.labels for each in exports), key=lambda labels: labels.version)
    return [
        replace(each, dataset=replace(each.dataset, labels=_newest_labels(each.dataset.labels, sets)))
        for each in exports
    ]


def _newest_labels(own: LabelSet, sets: Sequence[LabelSet]) -> LabelSet:
    """A set with the changes of later versions; ``sets`` begin with the oldest.

    Sets of two libraries may have one key, and an export of several sets has further labels. So a label of a later
    version is the same only if id and key are.
    """
    labels = {label.id: label for label in own}
    for later in (each for each in sets if each.key == own.key and each.version > own.version):
        merged, by_id = later.merged_ids(), {label.id: label for label in later}
        for label in later:
            if label.id not in labels or labels[label.id].key != label.key:
                continue
            if label.id not in merged:
                labels[label.id] = label
                continue
            target = by_id[merged[label.id]]
            known = next((number for number, each in labels.items() if each.key == target.key), None)
            number = max(labels) + 1 if known is None else known
            labels[number] = target.model_copy(update={"id": number})
            labels[label.id] = label.model_copy(update={"merged_into": number})
    return own.model_copy(update={"labels": tuple(labels.values())})


def _as_classes(track: Track, classes: RunClasses, missing_labels: Counter[str]) -> Track:
    """A track with the model's classes; labels that it lacks are counted."""
    label = classes.labels.get(classes.labels.resolved(track.label))
    use = verdict(track)
    if label is not None and use == "sign":
        if label.teach == "background":
            return replace(track, state=REJECTED, label=NO_CLASS, labels=None)
        if label.teach == "ignore":
            return replace(track, label=NO_CLASS, labels=None)
        if classes.to_class(label.id) is None:
            missing_labels[label.name] += 1
    own_labels = {track.label, *(() if track.labels is None else track.labels.tolist())}
    return relabel_track(track, {each: _number(each, classes) for each in own_labels})


def _number(label_id: int, classes: RunClasses) -> int:
    """The model's class that a label trains as a sign; ``NO_CLASS``: none."""
    label = classes.labels.get(classes.labels.resolved(label_id))
    number = None if label is None or label.teach != "sign" else classes.to_class(label_id)
    return NO_CLASS if number is None else number


def _missing_label_notes(export: OpenedExport, missing_labels: Counter[str]) -> Iterator[str]:
    if missing_labels:
        named = ", ".join(f"'{name}' ({plural(count, 'track')})" for name, count in sorted(missing_labels.items()))
        yield (
            f"{export.about['name']}: the model has no label for {named}. They are not used, neither as signs nor as "
            "background."
        )


@dataclass(frozen=True, slots=True)
class _UsedTrack:
    """A track that is used, with its place."""

    export: int
    video: int
    uid: str
    track: Track
    label_name: str
    """Name of its label; ``no sign`` for background."""
    key: str
    """Key for comparison: the model's class, else the key of its label; empty for background."""

    @property
    def place(self) -> tuple[int, int, str]:
        return self.export, self.video, self.uid


@dataclass(frozen=True, slots=True)
class _Contradiction:
    """Two tracks on each other with different labels."""

    tracks: tuple[_UsedTrack, _UsedTrack]
    sentence: str

    @property
    def export(self) -> int:
        return self.tracks[1].export


def _pairs(
    exports: Sequence[OpenedExport], tracks: Sequence[Sequence[Sequence[Track]]], keys: Sequence[str] | None
) -> tuple[list[_Contradiction], list[_UsedTrack]]:
    """Tracks of one video that contradict each other, and those that repeat one of an earlier export."""
    by_video: dict[str, list[_UsedTrack]] = {}
    names: dict[str, str] = {}
    for number, export in enumerate(exports):
        classes = classes_of_keys(keys, export.dataset.labels)
        for video_number, video in enumerate(export.dataset.videos):
            names.setdefault(video_name(video), video.name)
            used_tracks = by_video.setdefault(video_name(video), [])
            for track in tracks[number][video_number]:
                label = _taught_label(track, classes)
                if label is not None:
                    used_tracks.append(_UsedTrack(number, video_number, track.uid, track, *label))
    found, repeated = [], []
    for name, every in by_video.items():
        every.sort(key=lambda one: (int(one.track.frames[0]), one.export, one.uid))
        for i, one in enumerate(every):
            for other in every[i + 1 :]:
                if other.track.frames[0] > one.track.frames[-1]:
                    break
                if one.key == other.key and one.export == other.export:
                    continue
                span = _overlapping_frames(one.track, other.track)
                if span is None:
                    continue
                sides = (one, other) if one.export <= other.export else (other, one)
                if one.key == other.key:
                    repeated.append(sides[1])
                else:
                    found.append(_Contradiction(sides, _sentence(names[name], sides, span)))
    return found, repeated


def _taught_label(track: Track, classes: RunClasses) -> tuple[str, str] | None:
    """What a track teaches, in words and as key for comparison; None: it is not used."""
    use = verdict(track)
    label = classes.labels.get(classes.labels.resolved(track.label))
    if not len(track.frames) or (track.ignore is not None and track.ignore.all()):
        return None
    if use == "rejected" or (use == "sign" and label is not None and label.teach == "background"):
        return "no sign", ""
    if use != "sign" or label is None or label.teach != "sign":
        return None
    number = classes.to_class(label.id)  # keys of one class may differ between two sets
    return label.name, label.key if number is None else f"#{number}"


def _overlapping_frames(a: Track, b: Track) -> tuple[int, int] | None:
    """First and last frame in which two tracks overlap, if they do in half of their common frames."""
    common, i, j = np.intersect1d(a.frames, b.frames, assume_unique=True, return_indices=True)
    if not len(common):
        return None
    overlapping = common[iou_each(a.boxes[i], b.boxes[j]) >= _SAME_SIGN_IOU]
    return (int(overlapping[0]), int(overlapping[-1])) if 2 * len(overlapping) >= len(common) else None


def _sentence(video: str, tracks: tuple[_UsedTrack, _UsedTrack], span: tuple[int, int]) -> str:
    one, other = tracks
    frames = f"frame {span[0]}" if span[0] == span[1] else f"frames {span[0]} to {span[1]}"
    return (
        f"{video}, {frames}: {one.uid} says '{one.label_name}', {other.uid} says '{other.label_name}'. Neither of them "
        "teaches; correct one and export again."
    )


def _shortened(notes: Sequence[str]) -> list[str]:
    """The notes; contradictions beyond the first few are only counted."""
    contradictions = [note for note in notes if "Neither of them teaches" in note]
    if len(contradictions) <= _MAX_LISTED:
        return list(notes)
    kept = [note for note in notes if note not in contradictions[_MAX_LISTED:]]
    return [*kept, f"{len(contradictions) - _MAX_LISTED} more places are contradictory in the same way."]
