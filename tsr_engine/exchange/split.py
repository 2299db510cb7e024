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

__all__ = ["SUBSETS", "Split", "check_leaks", "deal", "lacking", "subset_of", "subsets_of_frames", "video_key"]

SUBSETS = ("train", "val", "test")
WHOLE = "default"
"""Name of the only subset of an export without a split."""


@dataclass(frozen=True, slots=True, eq=False)
class Split(Mapping[tuple[str, str], str]):
    """Maps (video key, track uid) to a subset, and stores how it was made.

    Attributes:
        sides: the mapping.
        rule: ``sign`` (groups of signs that share frames), ``track`` (single signs, for crops) or ``video``.
        seed: seed of the order.
        shares: wanted share of the boxes by subset.
        groups: number of groups.
    """

    sides: Mapping[tuple[str, str], str]
    rule: str
    seed: int
    shares: Mapping[str, float]
    groups: int

    def __getitem__(self, key: tuple[str, str]) -> str:
        return self.sides[key]

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return iter(self.sides)

    def __len__(self) -> int:
        return len(self.sides)


def video_key(video: DatasetVideo) -> str:
    """The key of a video in a split: its SHA-256, else its name."""
    return video.sha256 or video.name


def subset_of(video: DatasetVideo, uid: str, split: Mapping[tuple[str, str], str]) -> str | None:
    """Subset of a track; ``default`` without a split; None: in no subset, leave the track out."""
    return split.get((video_key(video), uid)) if split else WHOLE


def deal(
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
    wanted = {name: float(shares.get(name, 0.0)) for name in SUBSETS}
    total = sum(wanted.values())
    if set(shares) - set(SUBSETS) or not all(0 <= share < float("inf") for share in wanted.values()) or not total > 0:
        raise UsageError(f"The split must be shares >= 0 of {', '.join(SUBSETS)}, not all 0. Got {dict(shares)}.")
    if rule not in ("sign", "track", "video"):
        raise UsageError(f"A split must be by sign, track or video. Got {rule!r}.")
    wanted = {name: share / total for name, share in wanted.items() if share > 0}
    members, weights, kinds = _groups(dataset, rule)
    alone = [key for group, weight in zip(members, weights, strict=True) if not weight for key in group]
    members = [group for group, weight in zip(members, weights, strict=True) if weight]
    kinds = [group for group, weight in zip(kinds, weights, strict=True) if weight]
    weights = [weight for weight in weights if weight]
    if len(weights) < len(wanted):
        raise ExportError(
            f"The signs form {plural(len(weights), 'group')} that must stay whole, too few for {' / '.join(wanted)}. "
            + ("Use more videos." if rule == "video" else "Use more videos, or fewer subsets.")
        )
    order = sorted(range(len(weights)), key=lambda g: _hash(seed, min(members[g])))
    # Rejected tracks that share no frame with a sign are for training.
    sides: dict[tuple[str, str], str] = dict.fromkeys(alone, next(iter(wanted)))
    subsets = _cut([weights[g] for g in order], wanted)
    if balance:
        _balance(subsets, [kinds[g] for g in order], [weights[g] for g in order], list(wanted))
    for group, side in zip(order, subsets, strict=True):
        sides.update(dict.fromkeys(members[group], side))
    return Split(sides, rule, seed, wanted, len(weights))


def lacking(dataset: Dataset, split: Mapping[tuple[str, str], str]) -> dict[str, list[str]]:
    """Labels that other subsets have signs of, by the subset that has none; subsets that lack no label are left out.

    Args:
        dataset: its tracks are read once.
        split: the split of its tracks.
    """
    there: dict[str, set[int]] = {side: set() for side in SUBSETS if side in set(split.values())}
    for video in dataset.videos:
        for track in video.tracks():
            side = subset_of(video, track.uid, split) if split else None
            if side is not None and track.state != REJECTED and track.label != NO_CLASS:
                there[side].add(track.label)
    every = set().union(*there.values())
    missing = {side: [label.name for label in dataset.labels if label.id in every - own] for side, own in there.items()}
    return {side: names for side, names in missing.items() if names}


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
        side = seen.setdefault(video_key(video), np.full(video.frames, -1, dtype=np.int8))
        for track in video.tracks():
            subset = subset_of(video, track.uid, split)
            if subset is None:
                continue
            number = names.index(subset)
            before = side[track.frames]
            clash = (before >= 0) & (before != number)
            if clash.any():
                k = int(track.frames[np.flatnonzero(clash)[0]])
                raise ExportError(
                    f"{video.name}: frame {k} would be in {names[side[k]]} and, with track {track.uid!r}, in {subset}. "
                    "Split by sign, which keeps frames whole."
                )
            side[track.frames] = number


def subsets_of_frames(video: DatasetVideo, split: Mapping[tuple[str, str], str]) -> tuple[list[str], NDArray[np.int8]]:
    """Subset of every frame of a video, for formats that put pictures into subsets.

    A frame without signs follows the nearest frame with one, because neighbours are near copies too.

    Returns:
        Names of the subsets, and the index of the subset of each frame, shape (frames,); without signs all are 0.
    """
    if not split:
        return [WHOLE], np.zeros(video.frames, dtype=np.int8)
    names = [name for name in SUBSETS if name in set(split.values())]
    side = np.full(video.frames, -1, dtype=np.int8)
    for track in (*video.negatives, *video.tracks()):
        subset = subset_of(video, track.uid, split)
        if subset is not None:
            side[track.frames] = names.index(subset)
    with_sign = np.flatnonzero(side >= 0)
    if not len(with_sign):
        return names, np.zeros(video.frames, dtype=np.int8)
    middles = (with_sign[1:] + with_sign[:-1]) / 2
    nearest = with_sign[np.searchsorted(middles, np.arange(video.frames), side="left")]
    return names, side[nearest]


def _groups(dataset: Dataset, rule: str) -> tuple[list[list[tuple[str, str]]], list[int], list[set[int]]]:
    """Members, boxes and labels of each group."""
    keys: list[tuple[str, str]] = []
    place: dict[tuple[str, str], int] = {}
    boxes: list[int] = []
    labels: list[int] = []
    parent: list[int] = []
    shown_in: dict[str, NDArray[np.int64]] = {}
    lead: dict[str, int] = {}

    def root(at: int) -> int:
        while parent[at] != at:
            parent[at] = parent[parent[at]]
            at = parent[at]
        return at

    for video in dataset.videos:
        name = video_key(video)
        # Index of one track per frame is enough to join all tracks of the frame.
        shown = shown_in.setdefault(name, np.full(video.frames, -1, dtype=np.int64))
        for track in video.tracks():
            key = (name, track.uid)
            number = place.setdefault(key, len(keys))
            if number == len(keys):
                keys.append(key)
                parent.append(number)
                boxes.append(0)
                labels.append(NO_CLASS if track.state == REJECTED else track.label)
            # Rejected tracks follow the signs of their frames, and do not count for the shares.
            boxes[number] += 0 if track.state == REJECTED else len(track.frames)
            if rule == "sign":
                for other in np.unique(shown[track.frames]).tolist():
                    if other >= 0:
                        parent[root(other)] = root(number)
                shown[track.frames] = number
            elif rule == "video":
                parent[number] = lead.setdefault(name, number)
    members: dict[int, list[tuple[str, str]]] = {}
    weights: dict[int, int] = {}
    kinds: dict[int, set[int]] = {}
    for number, key in enumerate(keys):
        group = root(number)
        members.setdefault(group, []).append(key)
        weights[group] = weights.get(group, 0) + boxes[number]
        kinds.setdefault(group, set()).update({labels[number]} - {NO_CLASS})
    return list(members.values()), [weights[group] for group in members], [kinds[group] for group in members]


def _balance(sides: list[str], kinds: list[set[int]], weights: list[int], names: list[str]) -> None:
    """Move few and small groups until each subset has every label that has enough groups; changes ``sides``.

    Labels with the fewest groups come first. A group is not moved if its subset would lose a label that it was given.
    """
    holders: dict[int, list[int]] = {}
    for group, own in enumerate(kinds):
        for label in own:
            holders.setdefault(label, []).append(group)
    wanted = {label for label, groups in holders.items() if len(groups) >= len(names)}
    count = {(side, label): 0 for side in names for label in holders}
    for group, side in enumerate(sides):
        for label in kinds[group]:
            count[side, label] += 1
    for label in sorted(wanted, key=lambda each: (len(holders[each]), each)):
        for side in names:
            if count[side, label]:
                continue
            free = [
                group
                for group in holders[label]
                if all(count[sides[group], own] > 1 for own in kinds[group] & wanted) and sides.count(sides[group]) > 1
            ]
            if not free:
                continue
            group = min(free, key=lambda each: (weights[each], each))
            for each in kinds[group]:
                count[sides[group], each] -= 1
                count[side, each] += 1
            sides[group] = side


def _cut(weights: list[int], wanted: Mapping[str, float]) -> list[str]:
    """Subset of each group in order; cuts lie where the cumulated weight is nearest to the shares."""
    sums = np.concatenate(([0], np.cumsum(weights)))
    out: list[str] = []
    share, left = 0.0, len(wanted)
    for name, part in wanted.items():
        share += part
        left -= 1
        end = int(np.argmin(np.abs(sums - share * sums[-1]))) if left else len(weights)
        end = min(max(end, len(out) + 1), len(weights) - left)
        out += [name] * (end - len(out))
    return out


def _hash(seed: int, key: tuple[str, str]) -> bytes:
    return hashlib.sha256(f"{seed}\0{key[0]}\0{key[1]}".encode("utf-8", "surrogatepass")).digest()
