"""Numbers, names and colours of a recording's labels, and their mapping from the run's class numbers."""

from __future__ import annotations

from colorsys import hls_to_rgb
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.labels.classes import RunClasses
from tsr_engine.labels.model import Category, Label
from tsr_engine.recording.layers import Rgb

_HUES: Final[dict[Category, float]] = {
    "prohibitory": 0.0,
    "danger": 0.11,
    "mandatory": 0.6,
    "information": 0.53,
    "direction": 0.3,
    "additional": 0.78,
    "priority": 0.42,
    "other": 0.42,
}
_UNKNOWN: Final[Rgb] = (190, 190, 190)
_MAX_CLASS_NUMBER: Final = 60_000
"""Largest class number of a viewer: 16 bits."""


class RecordedClasses:
    """Numbers, names and colours of a recording's labels.

    A label's number is its id, unless the set has ids beyond a viewer's range. Boxes without a label get the
    next number, and classes of the model that the set lacks come last.
    """

    def __init__(self, classes: RunClasses) -> None:
        """Take the mapping of the run's class numbers."""
        self._classes = classes
        labels = sorted(classes.labels, key=lambda label: label.id)
        ids_fit = classes.labels.next_id < _MAX_CLASS_NUMBER
        self._labels = {label.id: label.id if ids_fit else index for index, label in enumerate(labels)}
        self._short_names = {label.id: label.shown_short for label in labels}
        self.unknown = max(self._labels.values(), default=-1) + 1
        """Number for boxes without a label."""
        unmapped = [number for number in classes.numbers() if classes.is_unmapped(number)]
        self._unmapped = {number: self.unknown + 1 + index for index, number in enumerate(unmapped)}
        self.infos: list[tuple[int, str, Rgb]] = [
            *((self._labels[label.id], f"{label.id} {label.name}", _colour(label)) for label in labels),
            (self.unknown, "unknown", _UNKNOWN),
            *((index, classes.name(number), _UNKNOWN) for number, index in self._unmapped.items()),
        ]
        """Number, name and colour of each label."""

    def of_classes(self, class_numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Convert the run's class numbers (-1: none) to numbers of the recording, shape (n,)."""
        found = self.of_labels(self._classes.to_labels(class_numbers))
        for number, index in self._unmapped.items():
            found[class_numbers == number] = index
        return found

    def of_labels(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """Convert label ids (-1: none) to numbers of the recording, shape (n,)."""
        return np.array([self._labels.get(label, self.unknown) for label in ids.tolist()], np.int64)

    def short_name(self, class_number: int | None) -> str:
        """Short name of one of the run's classes; ``?``: none."""
        return "?" if class_number is None or class_number < 0 else self._classes.short(class_number)

    def title(self, class_number: int) -> str:
        """Number and short name of one of the run's classes."""
        label = self._classes.to_label(class_number)
        return self.short_name(class_number) if label < 0 else f"{label} {self.short_name(class_number)}"


def _colour(label: Label) -> Rgb:
    """The label's colour, else one near its category's with a hue and lightness that vary by label."""
    if label.colour is not None:
        r, g, b = bytes.fromhex(label.colour[1:])
        return r, g, b
    hue = _HUES[label.category] + 0.022 * (label.id % 5 - 2)
    red, green, blue = hls_to_rgb(hue % 1.0, 0.5 + 0.07 * (label.id % 3), 0.85)
    return round(red * 255), round(green * 255), round(blue * 255)
