"""Maps corrections to the classes of a model, whose labels may differ from the corrections' label set.

A label's ``teach`` says how a retraining uses it: as a sign, as background, or not at all. Labels that the model lacks
are added to it if its classifier is trained. A retraining does not use tracks without a label of the set, tracks of a
region to ignore, tracks that contradict each other, or labels that the model lacks and is not given. The last two are
reported by name.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tsr_engine.exchange.dataset import REJECTED, Track
from tsr_engine.exchange.relabel import relabelled
from tsr_engine.geometry.boxes import iou_each
from tsr_engine.labels.classes import RunClasses, classes_of_keys
from tsr_engine.plural import plural
from tsr_engine.track_table import NO_CLASS
from tsr_engine.training.corrections import CorrectedScene, verdict, video_name
from tsr_engine.training.exports import OpenedExport

__all__ = ["further_keys", "only_shown", "taught"]

_SAME = 0.5
"""Least IoU of two boxes of one frame that are the same sign."""
_REPORTED = 20
"""Largest number of contradictions that are listed; the rest are counted."""


def further_keys(exports: Sequence[OpenedExport], keys: Sequence[str] | None) -> tuple[str, ...]:
    """Keys of labels that tracks of signs have and a model lacks, in order.

    Args:
        exports: exports with labels of their own sets.
        keys: keys of the model's classes by number; None: those of ``gtsrb-43``.
    """
    found: dict[str, str] = {}
    for export in exports:
        classes = classes_of_keys(keys, export.dataset.labels)
        for track in (track for video in export.dataset.videos for track in video.tracks()):
            label = classes.labels.get(classes.labels.resolved(track.label))
            teaches = label is not None and label.teach == "sign" and verdict(track) == "sign"
            if label is not None and teaches and classes.to_class(label.id) is None:
                found.setdefault(label.key.casefold(), label.key)
    return tuple(found[key] for key in sorted(found))


def only_shown(
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
    to = np.arange(known + len(further))
    to[[known + place for place in shown]] = known + np.arange(len(shown))
    return (
        [replace(each, scene=replace(each.scene, class_ids=to[each.scene.class_ids])) for each in scenes],
        tuple(further[place] for place in shown),
    )


def taught(exports: Sequence[OpenedExport], keys: Sequence[str] | None) -> list[OpenedExport]:
    """The exports with the model's class numbers in place of labels, and with notes on unused tracks.

    Args:
        exports: exports with labels of their own sets.
        keys: keys of the model's classes by number; None: those of ``gtsrb-43``.
    """
    tracks = [[tuple(video.tracks()) for video in export.dataset.videos] for export in exports]
    found = _contradictions(exports, tracks, keys)
    mute = {(one.export, one.video, one.uid) for pair in found for one in pair.sides}
    done = []
    for number, export in enumerate(exports):
        classes = classes_of_keys(keys, export.dataset.labels)
        lacking: Counter[str] = Counter()
        videos = []
        for place, (video, own) in enumerate(zip(export.dataset.videos, tracks[number], strict=True)):
            kept = tuple(
                replace(track, label=NO_CLASS, labels=None, state="needs_work")
                if (number, place, track.uid) in mute
                else _as_classes(track, classes, lacking)
                for track in own
            )
            videos.append(replace(video, tracks=lambda kept=kept: iter(kept)))  # type: ignore[misc]
        notes = (*export.notes, *_lacking(export, lacking), *(pair.sentence for pair in found if pair.export == number))
        dataset = replace(export.dataset, videos=tuple(videos))
        done.append(replace(export, dataset=dataset, notes=tuple(dict.fromkeys(_short(notes)))))
    return done


def _as_classes(track: Track, classes: RunClasses, lacking: Counter[str]) -> Track:
    """A track with the model's classes; labels that it lacks are counted."""
    label = classes.labels.get(classes.labels.resolved(track.label))
    says = verdict(track)
    if label is not None and says == "sign":
        if label.teach == "background":
            return replace(track, state=REJECTED, label=NO_CLASS, labels=None)
        if label.teach == "ignore":
            return replace(track, label=NO_CLASS, labels=None)
        if classes.to_class(label.id) is None:
            lacking[label.name] += 1
    return relabelled(track, {each: _number(each, classes) for each in {track.label, *_own(track)}})


def _own(track: Track) -> set[int]:
    return set() if track.labels is None else set(track.labels.tolist())


def _number(label_id: int, classes: RunClasses) -> int:
    """The model's class that a label trains as a sign; ``NO_CLASS``: none."""
    label = classes.labels.get(classes.labels.resolved(label_id))
    number = None if label is None or label.teach != "sign" else classes.to_class(label_id)
    return NO_CLASS if number is None else number


def _lacking(export: OpenedExport, lacking: Counter[str]) -> Iterator[str]:
    if lacking:
        named = ", ".join(f"'{name}' ({plural(count, 'track')})" for name, count in sorted(lacking.items()))
        yield (
            f"{export.about['name']}: the model has no label for {named}. They are not used, neither as signs nor as "
            "background."
        )


@dataclass(frozen=True, slots=True)
class _Said:
    """A track that is used, with its place."""

    export: int
    video: int
    uid: str
    track: Track
    what: str
    """Name of its label; ``no sign`` for background."""
    key: str
    """Key for comparison: the model's class, else the key of its label; empty for background."""


@dataclass(frozen=True, slots=True)
class _Pair:
    """Two tracks on each other with different labels."""

    sides: tuple[_Said, _Said]
    sentence: str

    @property
    def export(self) -> int:
        return self.sides[1].export


def _contradictions(
    exports: Sequence[OpenedExport], tracks: Sequence[Sequence[Sequence[Track]]], keys: Sequence[str] | None
) -> list[_Pair]:
    """Tracks of one video, in the same export or in two, that contradict each other."""
    by_video: dict[str, list[_Said]] = {}
    names: dict[str, str] = {}
    for number, export in enumerate(exports):
        classes = classes_of_keys(keys, export.dataset.labels)
        for place, video in enumerate(export.dataset.videos):
            names.setdefault(video_name(video), video.name)
            said = by_video.setdefault(video_name(video), [])
            for track in tracks[number][place]:
                what = _what(track, classes)
                if what is not None:
                    said.append(_Said(number, place, track.uid, track, *what))
    found = []
    for name, every in by_video.items():
        every.sort(key=lambda one: (int(one.track.frames[0]), one.export, one.uid))
        for i, one in enumerate(every):
            for other in every[i + 1 :]:
                if other.track.frames[0] > one.track.frames[-1]:
                    break
                span = _together(one.track, other.track) if one.key != other.key else None
                if span is not None:
                    sides = (one, other) if one.export <= other.export else (other, one)
                    found.append(_Pair(sides, _sentence(names[name], sides, span)))
    return found


def _what(track: Track, classes: RunClasses) -> tuple[str, str] | None:
    """What a track teaches, in words and as key for comparison; None: it is not used."""
    says = verdict(track)
    label = classes.labels.get(classes.labels.resolved(track.label))
    if not len(track.frames) or (track.ignore is not None and track.ignore.all()):
        return None
    if says == "rejected" or (says == "sign" and label is not None and label.teach == "background"):
        return "no sign", ""
    if says != "sign" or label is None or label.teach != "sign":
        return None
    number = classes.to_class(label.id)  # keys of one class may differ between two sets
    return label.name, label.key if number is None else f"#{number}"


def _together(a: Track, b: Track) -> tuple[int, int] | None:
    """First and last frame in which two tracks overlap, if they do in half of their common frames."""
    both, i, j = np.intersect1d(a.frames, b.frames, assume_unique=True, return_indices=True)
    if not len(both):
        return None
    near = both[iou_each(a.boxes[i], b.boxes[j]) >= _SAME]
    return (int(near[0]), int(near[-1])) if 2 * len(near) >= len(both) else None


def _sentence(video: str, sides: tuple[_Said, _Said], span: tuple[int, int]) -> str:
    one, other = sides
    frames = f"frame {span[0]}" if span[0] == span[1] else f"frames {span[0]} to {span[1]}"
    return (
        f"{video}, {frames}: {one.uid} says '{one.what}', {other.uid} says '{other.what}'. Neither of them teaches; "
        "correct one and export again."
    )


def _short(notes: Sequence[str]) -> list[str]:
    """The notes; contradictions beyond the first few are only counted."""
    against = [note for note in notes if "Neither of them teaches" in note]
    if len(against) <= _REPORTED:
        return list(notes)
    kept = [note for note in notes if note not in against[_REPORTED:]]
    return [*kept, f"{len(against) - _REPORTED} more places are contradictory in the same way."]
