"""Maps the class numbers of a model, or of a run's evidence, to the labels of a set."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import NO_LABEL, Label, LabelSet

__all__ = [
    "RunClasses",
    "class_words",
    "classes_of_keys",
    "classes_of_set",
    "default_keys",
    "resolved_labels",
]


class RunClasses:
    """Class numbers of one model or run, and the labels of a set that stand for them.

    Numbers without a label of the set keep the model's own word. A merged label gives the label that it was merged
    into.
    """

    def __init__(
        self, labels: LabelSet, words: Mapping[int, str], ids: Mapping[int, int], nameless: str = "class {}"
    ) -> None:
        """Take both sides.

        Args:
            labels: the set.
            words: class number -> the model's own word.
            ids: class number -> id of a label of the set; numbers without one are missing.
            nameless: word for a number without one.
        """
        self.labels = labels
        self._words = dict(words)
        self._labels = {label.id: label for label in labels}
        merged = labels.merged_ids()
        self._ids = {number: merged.get(label, label) for number, label in ids.items()}
        self._back: dict[int, int] = {}
        for number in sorted(self._ids):
            self._back.setdefault(self._ids[number], number)
        self._nameless = nameless
        size = max(self._words, default=-1) + 1
        self._column = np.array([self.to_label(number) for number in range(size)] + [NO_LABEL], np.int64)

    def to_label(self, class_number: int) -> int:
        """The label's id; ``NO_LABEL``: the set has none for that number."""
        return self._ids.get(class_number, NO_LABEL)

    def to_class(self, label_id: int) -> int | None:
        """The lowest class number that a label stands for; None: the model lacks the label, or it is ``NO_LABEL``."""
        return self._back.get(self.labels.resolved(label_id))

    def to_labels(self, class_numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """A column of class numbers as labels; negative ones (no class) stay as they are."""
        places = np.minimum(class_numbers, len(self._column) - 1)
        return np.where(class_numbers < 0, class_numbers, self._column[places])

    def is_unmapped(self, class_number: int) -> bool:
        """Whether a class is none of the set's labels."""
        return class_number >= 0 and class_number not in self._ids

    def label(self, class_number: int) -> Label | None:
        """The label; None: the set has none for that number."""
        return self._labels.get(self._ids.get(class_number, NO_LABEL))

    def name(self, class_number: int) -> str:
        """The model's own word for a class."""
        return self._words.get(class_number, self._nameless.format(class_number))

    def shown(self, class_number: int) -> str:
        """What people read: the label's name, or the model's own word where the set has no such label."""
        label = self.label(class_number)
        return self.name(class_number) if label is None else label.name

    def short(self, class_number: int) -> str:
        """The same for pictures and narrow tables."""
        label = self.label(class_number)
        return self.name(class_number)[:12] if label is None else label.shown_short

    def numbers(self) -> Iterable[int]:
        """All class numbers, in order."""
        return sorted(self._words)

    def lacking(self) -> list[Label]:
        """Labels of the set that no class stands for, though they are offered and are signs; in the set's order."""
        return [label for label in self.labels.offered() if label.teach == "sign" and label.id not in self._back]


def resolved_labels(ids: NDArray[np.int64], labels: LabelSet) -> NDArray[np.int64]:
    """A column of labels with the label that stands for each since labels were merged; all others stay as they are."""
    for old, new in labels.merged_ids().items():
        ids = np.where(ids == old, new, ids)
    return ids


def class_words(keys: Sequence[str] | None) -> tuple[str, ...]:
    """What people read for each class of a model without a label set beside it: the name in ``gtsrb-43``, or the key.

    Args:
        keys: by class number; None: those of ``gtsrb-43``.
    """
    shipped = shipped_set(DEFAULT)
    known = [shipped.by_key(key) for key in (default_keys() if keys is None else keys)]
    return tuple(key if label is None else label.name for key, label in zip(keys or default_keys(), known, strict=True))


def default_keys() -> tuple[str, ...]:
    """Keys of the classes of models and runs that name none: those of ``gtsrb-43``, in order."""
    return tuple(label.key for label in shipped_set(DEFAULT))


def classes_of_keys(keys: Sequence[str] | None, labels: LabelSet) -> RunClasses:
    """Classes whose keys are known by number.

    A key is looked for among keys, names and aliases of the set; then, where it is one of ``gtsrb-43``, the name and
    the aliases that it has there.

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
    return RunClasses(labels, dict(enumerate(class_words(keys))), ids)


def classes_of_set(key: str, labels: LabelSet) -> RunClasses:
    """Classes that are ids of a label set already.

    Args:
        key: of that set; ids that ``labels`` has given out mean the same there.
        labels: the set of the video.
    """
    words = {label.id: label.name for label in labels}
    nameless = f"label {{}} of {key.replace('{', '(').replace('}', ')')}"
    return RunClasses(labels, words, {number: number for number in words}, nameless)
