"""Divides signs among training, validation and test so that no sign or frame is on two sides.

The same sign in thirty frames is thirty near copies, so signs stay whole, and so do frames. Signs that share a
frame of a video form a group, and a group goes to one side as a whole.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsr_engine.counted import counted
from tsr_engine.errors import ExportError, UsageError
from tsr_engine.exchange.dataset import REJECTED, Dataset, DatasetVideo
from tsr_engine.track_table import NO_CLASS

__all__ = ["SUBSETS", "Split", "check_leaks", "deal", "lacking", "subset_of", "subsets_of_frames", "video_key"]

SUBSETS = ("train", "val", "test")
WHOLE = "default"
"""Name of the one subset of an export without split."""


@dataclass(frozen=True, slots=True, eq=False)
class Split(Mapping[tuple[str, str], str]):
    """Subset of each (video key, track uid), with how it came about.

    Attributes:
        sides: the subsets.
        rule: ``sign`` (groups of signs that share frames), ``track`` (single signs, for crops) or ``video``.
        seed: of the deal.
        shares: subset -> wanted share of the boxes.
        groups: how many groups were divided.
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
    """What names a video in a split: its SHA-256, else its name."""
    return video.sha256 or video.name


def subset_of(video: DatasetVideo, uid: str, split: Mapping[tuple[str, str], str]) -> str | None:
    """Subset of a track; ``default`` without a split, None: on no side, leave it out."""
    return split.get((video_key(video), uid)) if split else WHOLE


def deal(
    dataset: Dataset, shares: Mapping[str, float], seed: int, rule: str = "sign", *, balance: bool = False
) -> Split:
    """Deal signs to subsets, weighted by boxes.

    Groups are put in the order of a hash of seed and name, then cut where the shares are reached, so the same data and
    seed give the same sides on every machine. A subset with a share gets at least one group while there are enough.

    Args:
        dataset: its tracks are read once.
        shares: of ``train``, ``val`` and ``test``, each >= 0; scaled to a sum of 1.
        seed: any whole number.
        rule: ``sign``, ``track`` or ``video``; ``track`` suits only formats that cut signs out of their frames.
        balance: give each subset every label that enough groups have; the shares are met less exactly then.

    Raises:
        UsageError: shares that are not such, or an unknown rule.
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
            f"The signs form {counted(len(weights), 'group')} that must stay whole, too few for {' / '.join(wanted)}. "
            + ("Use more videos." if rule == "video" else "Use more videos, or fewer subsets.")
        )
    order = sorted(range(len(weights)), key=lambda g: _hash(seed, min(members[g])))
    # What shares a frame with no sign is there to be learned from.
    sides: dict[tuple[str, str], str] = dict.fromkeys(alone, next(iter(wanted)))
    subsets = _cut([weights[g] for g in order], wanted)
    if balance:
        _balance(subsets, [kinds[g] for g in order], [weights[g] for g in order], list(wanted))
    for group, side in zip(order, subsets, strict=True):
        sides.update(dict.fromkeys(members[group], side))
    return Split(sides, rule, seed, wanted, len(weights))


def lacking(dataset: Dataset, split: Mapping[tuple[str, str], str]) -> dict[str, list[str]]:
    """Names of the labels that others have signs of and a subset has not, by subset; subsets that lack none left out.

    Args:
        dataset: its tracks are read once.
        split: of it.
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
    """Prove that no sign, and with ``whole_frames`` no picture, is on two sides.

    A mapping cannot hold one sign twice; what can leak is a frame whose signs are on different sides.

    Raises:
        ExportError: something is on two sides; names it.
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

    A frame without signs goes with the nearest frame that has one: neighbours are near copies too.

    Returns:
        names of the subsets, and the number of the subset of each frame, shape (frames,); without signs all are 0.
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
        # Number of a track that shows in each frame: enough to join all tracks of the frame.
        shown = shown_in.setdefault(name, np.full(video.frames, -1, dtype=np.int64))
        for track in video.tracks():
            key = (name, track.uid)
            number = place.setdefault(key, len(keys))
            if number == len(keys):
                keys.append(key)
                parent.append(number)
                boxes.append(0)
                labels.append(NO_CLASS if track.state == REJECTED else track.label)
            # What is no sign goes where the signs of its frames go, and does not count for the shares.
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
    """Move groups, few and small ones, until each side has every label that enough groups have; changes ``sides``.

    Labels that the fewest groups have come first. A group leaves a side only if that keeps what it has been given for.
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
    """Side of each group in order: the cuts lie where the sum of the weights comes nearest to the shares."""
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
