"""Maps the class numbers of a model, or of a run's evidence, to the labels of a set."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import NO_LABEL, Label, LabelSet


class RunClasses:
    """Maps class numbers of a model or run to labels of a set.

    Numbers without a label of the set keep the model's word. A merged label is replaced by its target.
    """

    def __init__(
        self, labels: LabelSet, words: Mapping[int, str], ids: Mapping[int, int], nameless: str = "class {}"
    ) -> None:
        """Take the set and the model's classes.

        Args:
            labels: the set.
            words: class number -> the model's word.
            ids: class number -> id of a label of the set; numbers without a label are missing.
            nameless: word for a number without a word.
        """
        self.labels = labels
        self._words = dict(words)
        self._labels = {label.id: label for label in labels}
        merged = labels.merged_ids()
        self._ids = {number: merged.get(label, label) for number, label in ids.items()}
        self._class_of_label: dict[int, int] = {}
        for number in sorted(self._ids):
            self._class_of_label.setdefault(self._ids[number], number)
        self._nameless = nameless
        size = max(self._words, default=-1) + 1
        self._column = np.array([self.to_label(number) for number in range(size)] + [NO_LABEL], np.int64)

    def to_label(self, class_number: int) -> int:
        """Id of the label of a class; ``NO_LABEL``: the set has none."""
        return self._ids.get(class_number, NO_LABEL)

    def to_class(self, label_id: int) -> int | None:
        """The lowest class number of a label; None: the model lacks the label, or it is ``NO_LABEL``."""
        return self._class_of_label.get(self.labels.resolved(label_id))

    def to_labels(self, class_numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Convert an array of class numbers to label ids; negative numbers (no class) are kept."""
        indices = np.minimum(class_numbers, len(self._column) - 1)
        return np.where(class_numbers < 0, class_numbers, self._column[indices])

    def is_unmapped(self, class_number: int) -> bool:
        """Whether the set has no label for a class."""
        return class_number >= 0 and class_number not in self._ids

    def label(self, class_number: int) -> Label | None:
        """The label of a class; None: the set has none."""
        return self._labels.get(self._ids.get(class_number, NO_LABEL))

    def name(self, class_number: int) -> str:
        """The model's word for a class."""
        return self._words.get(class_number, self._nameless.format(class_number))

    def shown(self, class_number: int) -> str:
        """The name for people: the label's, or the model's word if the set has no such label."""
        label = self.label(class_number)
        return self.name(class_number) if label is None else label.name

    def short(self, class_number: int) -> str:
        """The short name for pictures and narrow tables."""
        label = self.label(class_number)
        return self.name(class_number)[:12] if label is None else label.shown_short

    def numbers(self) -> Iterable[int]:
        """All class numbers, in order."""
        return sorted(self._words)

    def labels_without_class(self) -> list[Label]:
        """Labels of the set that are offered signs and have no class, in the set's order."""
        return [
            label for label in self.labels.offered() if label.teach == "sign" and label.id not in self._class_of_label
        ]


def resolved_labels(ids: NDArray[np.int64], labels: LabelSet) -> NDArray[np.int64]:
    """Replace merged labels in an array of ids by their targets."""
    for old, new in labels.merged_ids().items():
        ids = np.where(ids == old, new, ids)
    return ids


def class_names_of(keys: Sequence[str] | None) -> tuple[str, ...]:
    """Names of a model's classes without a label set: the name in ``gtsrb-43``, or the key.

    Args:
        keys: by class number; None: those of ``gtsrb-43``.
    """
    keys = default_keys() if keys is None else keys
    known = map(shipped_set(DEFAULT).by_key, keys)
    return tuple(key if label is None else label.name for key, label in zip(keys, known, strict=True))


def default_keys() -> tuple[str, ...]:
    """Keys of the classes of models and runs without keys: those of ``gtsrb-43``, in order."""
    return tuple(label.key for label in shipped_set(DEFAULT))


def classes_of_keys(keys: Sequence[str] | None, labels: LabelSet) -> RunClasses:
    """Map classes by their keys.

    A key is searched among keys, names and aliases of the set. A key of ``gtsrb-43`` is then searched by its name and
    aliases there.

    Args:
        keys: by class number; None: those of ``gtsrb-43``.
        labels: the set.
    """
    shipped, finder = shipped_set(DEFAULT), LabelFinder(labels)
    ids = {}
    for number, key in enumerate(default_keys() if keys is None else keys):
        known = shipped.by_key(key)
        for word in (key,) if known is None else (key, known.name, *known.aliases):
            match = finder.find(word)
            if match is not None and match.how != "number":
                ids[number] = match.label.id
                break
    return RunClasses(labels, dict(enumerate(class_names_of(keys))), ids)


def classes_of_set(key: str, labels: LabelSet) -> RunClasses:
    """Map classes that are already ids of a label set.

    Args:
        key: key of that set; ids that ``labels`` has ever had mean the same there.
        labels: the label set of the video.
    """
    words = {label.id: label.name for label in labels}
    nameless = f"label {{}} of {key.replace('{', '(').replace('}', ')')}"
    return RunClasses(labels, words, {number: number for number in words}, nameless)
