"""Names of classes in other tools' files, matched to the classes of the tool."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from tsr_engine.errors import UsageError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.recognition.catalogue import CATALOGUE

__all__ = ["CLASS_NAMES", "UNKNOWN", "LabelMatcher", "label_name", "used_labels"]

CLASS_NAMES: tuple[str, ...] = tuple(sign.name for sign in CATALOGUE)
"""The 43 classes; the place is the class number."""

UNKNOWN = "unknown sign"
"""Written for a track whose class is not known."""

_NUMBER = re.compile(r"(?:(?:class|id|c)[\s_:#-]*)?0*(\d{1,4})", re.ASCII | re.IGNORECASE)
_LOOSE = re.compile(r"[\s_-]+")


def label_name(labels: Sequence[str], label: int, unknown: str = UNKNOWN) -> str:
    """The name that is written for a class; ``unknown`` for -1."""
    return labels[label] if 0 <= label < len(labels) else unknown


class LabelMatcher:
    """Finds the class of a name.

    In this order: what a person said; the exact name; the name without case, spaces, dashes and underscores; the short
    name of the catalogue, the same way; a class number such as ``14``, ``00014``, ``class 14``.
    """

    def __init__(self, labels: Sequence[str], label_map: Mapping[str, int] | None = None) -> None:
        """Take the class names and what a person said about names.

        Raises:
            UsageError: a person named a class number that does not exist; -1 stands for "not known".
        """
        self._count = len(labels)
        self._said = dict(label_map or {})
        for name, label in self._said.items():
            if not -1 <= label < self._count:
                raise UsageError(
                    f"The class of {name!r} must be 0 to {self._count - 1}, or -1 for none. Got {label}; correct it."
                )
        self._exact = {name: place for place, name in reversed(list(enumerate(labels)))}
        self._loose = {_loose(name): place for place, name in reversed(list(enumerate(labels)))}
        if tuple(labels) == CLASS_NAMES:
            for place, sign in enumerate(CATALOGUE):
                # Short names are words for most signs; the numbers among them are class numbers to everybody else.
                if not sign.short.isdigit():
                    self._loose.setdefault(_loose(sign.short), place)
        self._found: dict[str, int | None] = {}

    def __call__(self, name: str) -> int | None:
        """The class number of a name, -1 where a person said that it stands for none, None: no class has it."""
        if name not in self._found:
            self._found[name] = self._find(name)
        return self._found[name]

    def is_number(self, name: str) -> bool:
        """Whether a name counts as a class only since it is a number."""
        said = name in self._said or name in self._exact or _loose(name) in self._loose
        return not said and _NUMBER.fullmatch(name.strip()) is not None

    def _find(self, name: str) -> int | None:
        if name in self._said:
            return self._said[name]
        if name in self._exact:
            return self._exact[name]
        loose = _loose(name)
        if loose in self._loose:
            return self._loose[loose]
        if loose == _loose(UNKNOWN):
            return -1
        number = _NUMBER.fullmatch(name.strip())
        if number and int(number[1]) < self._count:
            return int(number[1])
        return None


def _loose(name: str) -> str:
    return _LOOSE.sub("", name).casefold()


def used_labels(dataset: Dataset) -> tuple[list[str], bool, bool]:
    """Label names to declare; whether boxes are ignored; whether classes change within a track. One pass."""
    unknown = ignore = changes = False
    for video in dataset.videos:
        for track in video.tracks():
            unknown |= track.label < 0 or (track.labels is not None and bool((track.labels < 0).any()))
            ignore |= track.ignore is not None and bool(track.ignore.any())
            changes |= track.labels is not None and bool((track.labels != track.label).any())
    return [*dataset.labels, *([UNKNOWN] if unknown else [])], ignore, changes
