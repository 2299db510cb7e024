"""Finds the label for a name in another tool's file, and the name and number under which a label is written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Final

from tsr_engine.errors import UsageError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.matching import LabelFinder, Suggestions
from tsr_engine.labels.model import Label, LabelSet
from tsr_engine.labels.name_matching import comparable
from tsr_engine.track_table import NO_CLASS

UNKNOWN: Final = "unknown sign"
"""The name of tracks without a label of the set."""


def label_name(labels: LabelSet, label: int) -> str:
    """The name under which a label is written; ``UNKNOWN`` for -1. Searches the set, so use it for single labels."""
    found = labels.get(label)
    return UNKNOWN if found is None else found.name


class LabelMatcher:
    """Finds the label for a name in a file.

    The order is: a person's choice for the name; key, name, alias or short name of a label; ``UNKNOWN`` is no label. A
    name that is a number, such as ``50`` or ``class 14``, is not an id: other tools count differently, and ``50`` may
    be a speed limit. Only for files with numbers instead of names does :meth:`numbered` look up ids.
    """

    def __init__(self, labels: LabelSet, label_map: Mapping[str, int | str] | None = None) -> None:
        """Take a label set and a person's choices: name in the file -> id or key of a label, -1: no label of the set.

        Raises:
            UsageError: a choice is a label that the set does not have.
        """
        self._finder = LabelFinder(labels)
        self._choices = {name: _chosen_label(name, choice, labels) for name, choice in (label_map or {}).items()}
        self._found: dict[str, int | None] = {}

    def __call__(self, name: str) -> int | None:
        """The id for a name, -1 if the name means no label of the set; None: no label matches."""
        if name not in self._found:
            self._found[name] = self._find(name)
        return self._found[name]

    def numbered(self, name: str) -> int | None:
        """As a call, but a number is an id, whatever the labels' names are."""
        match = None if name in self._choices else self._finder.numbered(name)
        return self(name) if match is None else match.label.id

    def suggestions(self, name: str) -> Suggestions:
        """Labels that a name may mean."""
        return self._finder.suggestions(name)

    def _find(self, name: str) -> int | None:
        if name in self._choices:
            return self._choices[name]
        match = self._finder.named(name)
        if match is not None:
            return match.label.id
        return NO_CLASS if comparable(name) == comparable(UNKNOWN) else None


def _chosen_label(name: str, choice: int | str, labels: LabelSet) -> int:
    if choice == NO_CLASS:
        return NO_CLASS
    found = labels.by_key(choice) if isinstance(choice, str) else labels.get(choice)
    if found is not None:
        return labels.resolved(found.id)
    if isinstance(choice, str):
        similar = [f"'{label.key}'" for label in LabelFinder(labels).suggestions(choice).labels]
        hint = f" Did you mean {' or '.join(similar)}?" if similar else ""
        raise UsageError(f"{name!r} is to become {choice!r}, which is the key of no label of {labels.name}.{hint}")
    last = max((label.id for label in labels), default=NO_CLASS)
    raise UsageError(
        f"The label of {name!r} must be a number of {labels.name}, 0 to {last}, its key, or -1 for none. Got {choice}."
    )


@dataclass(frozen=True, slots=True)
class ClassMap:
    """The labels that a file declares, in the order of their ids; a label's number in the file is its index.

    Attributes:
        labels: the labels.
        unknown: whether ``UNKNOWN`` is declared after them.
        ignore: whether any box is to be ignored.
        changes: whether the label of a track changes.
    """

    labels: tuple[Label, ...]
    unknown: bool
    ignore: bool
    changes: bool
    _names: Mapping[int, str]
    _indices: Mapping[int, int]

    @property
    def names(self) -> list[str]:
        """The declared names by index."""
        return [*(label.name for label in self.labels), *([UNKNOWN] if self.unknown else [])]

    def name(self, label: int) -> str:
        """The name of a label of the map; ``UNKNOWN`` for -1."""
        return self._names[label]

    def index(self, label: int) -> int:
        """The index of a label of the map, or of ``UNKNOWN`` for -1."""
        return self._indices[label]


def class_map(dataset: Dataset, used_only: bool = False) -> ClassMap:
    """The labels to declare for a data set; reads its tracks once.

    Args:
        dataset: its labels and tracks.
        used_only: declare only labels that tracks have, not all of the set.
    """
    used: set[int] = set()
    ignore = changes = False
    for video in dataset.videos:
        for track in video.tracks():
            used.add(track.label)
            if track.labels is not None:
                used.update(set(track.labels.tolist()))
                changes |= bool((track.labels != track.label).any())
            ignore |= track.ignore is not None and bool(track.ignore.any())
    offered = set() if used_only else {label.id for label in dataset.labels.offered()}
    labels = tuple(sorted((each for each in dataset.labels if each.id in used | offered), key=lambda each: each.id))
    names = {label.id: label.name for label in labels}
    indices = {label.id: index for index, label in enumerate(labels)}
    return ClassMap(
        labels, NO_CLASS in used, ignore, changes, names | {NO_CLASS: UNKNOWN}, indices | {NO_CLASS: len(labels)}
    )


@cache
def benchmark_keys() -> tuple[str, ...]:
    """Keys of the labels of GTSRB and GTSDB, by class number."""
    return tuple(label.key for label in shipped_set("gtsrb-43"))


def benchmark_numbers(labels: Iterable[Label]) -> dict[int, int]:
    """The benchmarks' class numbers by label id, for the labels that the benchmarks have; found by key."""
    numbers = {key: number for number, key in enumerate(benchmark_keys())}
    return {label.id: numbers[label.key] for label in labels if label.key in numbers}
