"""Divides signs among training, validation and test so that no sign or frame is in two subsets.

Thirty frames of a sign are thirty near copies, so signs stay whole, and so do frames. Signs that share a
frame of a video form a group, which goes to one subset as a whole.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import ExportError, UsageError
from tsr_engine.exchange.dataset import REJECTED, Dataset, DatasetVideo
from tsr_engine.plural import plural
from tsr_engine.track_table import NO_CLASS

SUBSETS = ("train", "val", "test")
NO_SPLIT = "default"
"""Name of the only subset of an export without a split."""


@dataclass(frozen=True, slots=True, eq=False)
class Split(Mapping[tuple[str, str], str]):
    """Maps (video key, track uid) to a subset, and stores how it was made.

    Attributes:
        subsets: the mapping.
        rule: ``sign`` (groups of signs that share frames), ``track`` (single signs, for crops) or ``video``.
        seed: seed of the order.
        shares: wanted share of the boxes by subset.
        groups: number of groups.
    """

    subsets: Mapping[tuple[str, str], str]
    rule: str
    seed: int
    shares: Mapping[str, float]
    groups: int

    def __getitem__(self, key: tuple[str, str]) -> str:
        return self.subsets[key]

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return iter(self.subsets)

    def __len__(self) -> int:
        return len(self.subsets)


def names_of_subsets(split: Mapping[tuple[str, str], str]) -> list[str]:
    """Names of the subsets of a split in their usual order; ``default`` without a split."""
    used = set(split.values())
    return [name for name in SUBSETS if name in used] or [NO_SPLIT]


def video_key(video: DatasetVideo) -> str:
    """The key of a video in a split: its SHA-256, else its name."""
    return video.sha256 or video.name


def subset_of(video: DatasetVideo, uid: str, split: Mapping[tuple[str, str], str]) -> str | None:
    """Subset of a track; ``default`` without a split; None: in no subset, leave the track out."""
    return split.get((video_key(video), uid)) if split else NO_SPLIT


def make_split(
    dataset: Dataset, shares: Mapping[str, float], seed: int, rule: str = "sign", *, balance: bool = False
) -> Split:
    """Divide signs among subsets, weighted by boxes.

    Groups are sorted by a hash of seed and name, then cut where the shares are reached, so the same data and
    seed give the same split on every machine. A subset with a share gets at least one group if there are enough.

    Args:
        dataset: its tracks are read once.
        shares: shares of ``train``, ``val`` and ``test``, each >= 0; scaled to a sum of 1.
        seed: any integer.
        rule: ``sign``, ``track`` or ``video``; ``track`` is only for formats that crop signs from their frames.
        balance: give each subset every label that has enough groups; the shares are then met less exactly.

    Raises:
        UsageError: invalid shares, or an unknown rule.
        ExportError: fewer groups than subsets with a share.
    """
    shares_by_subset = {name: float(shares.get(name, 0.0)) for name in SUBSETS}
    total = sum(shares_by_subset.values())
    if (
        set(shares) - set(SUBSETS)
        or not all(0 <= share < float("inf") for share in shares_by_subset.values())
        or not total > 0
    ):
        raise UsageError(f"The split must be shares >= 0 of {', '.join(SUBSETS)}, not all 0. Got {dict(shares)}.")
    if rule not in ("sign", "track", "video"):
        raise UsageError(f"A split must be by sign, track or video. Got {rule!r}.")
    shares_by_subset = {name: share / total for name, share in shares_by_subset.items() if share > 0}
    members, weights, labels = _groups(dataset, rule)
    without_boxes = [key for group, weight in zip(members, weights, strict=True) if not weight for key in group]
    members = [group for group, weight in zip(members, weights, strict=True) if weight]
    labels = [group for group, weight in zip(labels, weights, strict=True) if weight]
    weights = [weight for weight in weights if weight]
    if len(weights) < len(shares_by_subset):
        raise ExportError(
            f"The signs form {plural(len(weights), 'group')} that must stay whole, too few for "
            f"{' / '.join(shares_by_subset)}. "
            + ("Use more videos." if rule == "video" else "Use more videos, or fewer subsets.")
        )
    order = sorted(range(len(weights)), key=lambda g: _hash(seed, min(members[g])))
    # Rejected tracks that share no frame with a sign are for training.
    subset_of_sign: dict[tuple[str, str], str] = dict.fromkeys(without_boxes, next(iter(shares_by_subset)))
    subsets = _cut([weights[g] for g in order], shares_by_subset)
    if balance:
        _balance(subsets, [labels[g] for g in order], [weights[g] for g in order], list(shares_by_subset))
    for group, subset in zip(order, subsets, strict=True):
        subset_of_sign.update(dict.fromkeys(members[group], subset))
    return Split(subset_of_sign, rule, seed, shares_by_subset, len(weights))


def missing_labels(dataset: Dataset, split: Mapping[tuple[str, str], str]) -> dict[str, list[str]]:
    """Labels that other subsets have signs of, by the subset that has none; subsets that lack no label are left out.

    Args:
        dataset: its tracks are read once.
        split: the split of its tracks.
    """
    labels_by_subset: dict[str, set[int]] = {subset: set() for subset in names_of_subsets(split)}
    for video in dataset.videos:
        for track in video.tracks():
            subset = subset_of(video, track.uid, split)
            if subset is not None and track.state != REJECTED and track.label != NO_CLASS:
                labels_by_subset[subset].add(track.label)
    all_labels = set().union(*labels_by_subset.values())
    missing = {
        subset: [label.name for label in dataset.labels if label.id in all_labels - labels]
        for subset, labels in labels_by_subset.items()
    }
    return {subset: names for subset, names in missing.items() if names}


def check_leaks(dataset: Dataset, split: Mapping[tuple[str, str], str], *, whole_frames: bool) -> None:
    """Check that no sign, and with ``whole_frames`` no picture, is in two subsets.

    A mapping cannot hold one sign twice, but signs of one frame can be in different subsets.

    Raises:
        ExportError: something is in two subsets; names it.
    """
    if not split or not whole_frames:
        return
    names = sorted(set(split.values()))
    seen: dict[str, NDArray[np.int8]] = {}
    for video in dataset.videos:
        subset_of_frame = seen.setdefault(video_key(video), np.full(video.frames, -1, dtype=np.int8))
        for track in video.tracks():
            subset = subset_of(video, track.uid, split)
            if subset is None:
                continue
            number = names.index(subset)
            known = subset_of_frame[track.frames]
            conflicts = (known >= 0) & (known != number)
            if conflicts.any():
                k = int(track.frames[np.flatnonzero(conflicts)[0]])
                raise ExportError(
                    f"{video.name}: frame {k} would be in {names[subset_of_frame[k]]} and, with track "
                    f"{track.uid!r}, in {subset}. Split by sign, which keeps frames whole."
                )
            subset_of_frame[track.frames] = number


def subsets_of_frames(video: DatasetVideo, split: Mapping[tuple[str, str], str]) -> tuple[list[str], NDArray[np.int8]]:
    """Subset of every frame of a video, for formats that put pictures into subsets.

    A frame without signs follows the nearest frame with one, because neighbours are near copies too.

    Returns:
        Names of the subsets, and the index of the subset of each frame, shape (frames,); without signs all are 0.
    """
    names = names_of_subsets(split)
    if not split:
        return names, np.zeros(video.frames, dtype=np.int8)
    subset_of_frame = np.full(video.frames, -1, dtype=np.int8)
    for track in (*video.negatives, *video.tracks()):
        subset = subset_of(video, track.uid, split)
        if subset is not None:
            subset_of_frame[track.frames] = names.index(subset)
    with_sign = np.flatnonzero(subset_of_frame >= 0)
    if not len(with_sign):
        return names, np.zeros(video.frames, dtype=np.int8)
    middles = (with_sign[1:] + with_sign[:-1]) / 2
    nearest = with_sign[np.searchsorted(middles, np.arange(video.frames), side="left")]
    return names, subset_of_frame[nearest]


def _groups(dataset: Dataset, rule: str) -> tuple[list[list[tuple[str, str]]], list[int], list[set[int]]]:
    """Members, boxes and labels of each group."""
    keys: list[tuple[str, str]] = []
    indices: dict[tuple[str, str], int] = {}
    boxes: list[int] = []
    labels: list[int] = []
    parent: list[int] = []
    tracks_by_video: dict[str, NDArray[np.int64]] = {}
    first_of_video: dict[str, int] = {}

    def root(index: int) -> int:
        while parent[index] != index:
            parent[index] = parent[parent[index]]
            index = parent[index]
        return index

    for video in dataset.videos:
        name = video_key(video)
        # Index of one track per frame is enough to join all tracks of the frame.
        track_in_frame = tracks_by_video.setdefault(name, np.full(video.frames, -1, dtype=np.int64))
        for track in video.tracks():
            key = (name, track.uid)
            number = indices.setdefault(key, len(keys))
            if number == len(keys):
                keys.append(key)
                parent.append(number)
                boxes.append(0)
                labels.append(NO_CLASS if track.state == REJECTED else track.label)
            # Rejected tracks follow the signs of their frames, and do not count for the shares.
            boxes[number] += 0 if track.state == REJECTED else len(track.frames)
            if rule == "sign":
                for other in np.unique(track_in_frame[track.frames]).tolist():
                    if other >= 0:
                        parent[root(other)] = root(number)
                track_in_frame[track.frames] = number
            elif rule == "video":
                parent[number] = first_of_video.setdefault(name, number)
    members: dict[int, list[tuple[str, str]]] = {}
    weights: dict[int, int] = {}
    labels_of_group: dict[int, set[int]] = {}
    for number, key in enumerate(keys):
        group = root(number)
        members.setdefault(group, []).append(key)
        weights[group] = weights.get(group, 0) + boxes[number]
        labels_of_group.setdefault(group, set()).update({labels[number]} - {NO_CLASS})
    return list(members.values()), [weights[group] for group in members], [labels_of_group[group] for group in members]


def _balance(subsets: list[str], labels_of_group: list[set[int]], weights: list[int], names: list[str]) -> None:
    """Move few and small groups until each subset has every label that has enough groups; changes ``subsets``.

    Labels with the fewest groups come first. A group is not moved if its subset would lose a label that it was given.
    """
    holders: dict[int, list[int]] = {}
    for group, group_labels in enumerate(labels_of_group):
        for label in group_labels:
            holders.setdefault(label, []).append(group)
    wanted = {label for label, groups in holders.items() if len(groups) >= len(names)}
    count = {(subset, label): 0 for subset in names for label in holders}
    for group, subset in enumerate(subsets):
        for label in labels_of_group[group]:
            count[subset, label] += 1
    for label in sorted(wanted, key=lambda each: (len(holders[each]), each)):
        for subset in names:
            if count[subset, label]:
                continue
            movable = [
                group
                for group in holders[label]
                if all(count[subsets[group], group_labels] > 1 for group_labels in labels_of_group[group] & wanted)
                and subsets.count(subsets[group]) > 1
            ]
            if not movable:
                continue
            group = min(movable, key=lambda each: (weights[each], each))
            for each in labels_of_group[group]:
                count[subsets[group], each] -= 1
                count[subset, each] += 1
            subsets[group] = subset


def _cut(weights: list[int], wanted: Mapping[str, float]) -> list[str]:
    """Subset of each group in order; cuts lie where the cumulated weight is nearest to the shares."""
    sums = np.concatenate(([0], np.cumsum(weights)))
    out: list[str] = []
    share, remaining = 0.0, len(wanted)
    for name, subset_share in wanted.items():
        share += subset_share
        remaining -= 1
        end = int(np.argmin(np.abs(sums - share * sums[-1]))) if remaining else len(weights)
        end = min(max(end, len(out) + 1), len(weights) - remaining)
        out += [name] * (end - len(out))
    return out


def _hash(seed: int, key: tuple[str, str]) -> bytes:
    return hashlib.sha256(f"{seed}\0{key[0]}\0{key[1]}".encode("utf-8", "surrogatepass")).digest()
