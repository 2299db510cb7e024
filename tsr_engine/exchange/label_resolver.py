"""Finds the label for each name in a file, and handles names that match no label."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from tsr_engine.exchange.added_labels import DeclaredLabel, UnknownLabel, unknown_labels_error, with_new_labels
from tsr_engine.exchange.dataset import UNSTATED_LABEL, Skipped
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.labels import LabelMatcher
from tsr_engine.exchange.reading import location_of
from tsr_engine.exchange.track_rows import BOX, TrackRows
from tsr_engine.labels.model import LabelSet
from tsr_engine.plural import plural
from tsr_engine.records import FloatArray
from tsr_engine.track_table import NO_CLASS

SKIPPED_LABEL: Final = -(2**31)
"""Label of rows to leave out, because their name matches no label."""
_HIDDEN_WEIGHT, _CUT_WEIGHT = 0.1, 0.2
"""Weight of a box's area as an example if its sign is hidden, ignored, or cut by the picture's edge."""


class LabelResolver:
    """Maps each name of a file to a label. A name without one gets a placeholder until the whole file is read.

    Attributes:
        skipped: boxes that ``resolve`` leaves out.
        repaired: sentences about labels that it adds.
        declared: the file's declarations by name; the empty name declares for every label.
    """

    def __init__(self, target: ImportTarget) -> None:
        """Take the video, labels and choices of the import."""
        self._target = target
        self._matcher = LabelMatcher(target.labels, {**target.remembered, **target.label_map})
        self._known = frozenset(label.id for label in target.labels)
        self._remembered_used: set[str] = set()
        self._unmatched: dict[str, int] = {}
        self._locations: dict[str, str] = {}
        self.declared: dict[str, DeclaredLabel] = {}
        self.skipped: list[Skipped] = []
        self.repaired: list[str] = []

    def label(self, name: str, file: str, line: int | str | None, number: bool) -> int:
        """The id for a name, -1 for "unknown sign", or a placeholder below ``UNSTATED_LABEL``.

        Args:
            name: as in the file.
            file: for messages.
            line: for messages.
            number: whether the file has a number there, not a name.
        """
        found = self._matcher.numbered(name) if number else self._matcher(name)
        if found is None:
            if name not in self._unmatched:
                self._unmatched[name] = UNSTATED_LABEL - 1 - len(self._unmatched)
                self._locations[name] = location_of(file, line)
            return self._unmatched[name]
        if name in self._target.remembered and name not in self._target.label_map:
            self._remembered_used.add(name)
        return found

    def resolve(self, tracks: Iterable[TrackRows], file: str) -> tuple[LabelSet, dict[int, int]]:
        """Decide about names that match no label.

        Args:
            tracks: all rows of the file.
            file: for messages.

        Returns:
            The set, and the id, or ``SKIPPED_LABEL``, of each placeholder.

        Raises:
            UnknownLabels: the caller has not said what to do with them.
            ImportFormatError: a name cannot become a label.
        """
        labels, used, target = self._target.labels, self._unmatched_with_boxes(tracks), self._target
        if not used:
            return labels, {}
        new = [name for name in used if target.unknown == "add" or name in target.added]
        others = [each for name, each in used.items() if name not in new]
        if others and target.unknown == "refuse":
            raise unknown_labels_error(file, labels, self._matcher, others)
        for each in others:
            what = f"{plural(each.boxes, 'box', 'boxes')} of {plural(each.tracks, 'track')} named {each.name[:80]!r}"
            self.skipped.append(Skipped(what, f"No label of {labels.name} has that name (unknown=skip)."))
        labels, ids = with_new_labels(labels, new, self.declared, file)
        for name in new:
            added = labels.get(ids[name])
            assert added is not None
            self.repaired.append(f"Label {name[:80]!r} was added to {labels.name} as {added.key!r}, number {added.id}.")
        return labels, {self._unmatched[name]: ids.get(name, SKIPPED_LABEL) for name in used}

    def adds_attributes(self, label_id: int) -> bool:
        """Whether missing attributes are added to a label."""
        return self._target.unknown == "add" or label_id not in self._known

    def declared_by_id(self, labels: LabelSet, ids: Mapping[int, int]) -> dict[int, DeclaredLabel]:
        """The file's declarations by label id; the arguments are the results of ``resolve``."""
        declared = {
            label: declaration
            for name, declaration in self.declared.items()
            if (label := ids.get(self._unmatched.get(name, 0), self._matcher(name))) is not None
        }
        for each in labels:
            declared.setdefault(each.id, self.declared.get("", DeclaredLabel()))
        return declared

    def remembered_reports(self) -> list[str]:
        """Sentences about names for which an earlier file's choice was used."""
        return [
            f"{name[:80]!r} was taken as {self._describe_label(name)}, the choice for an earlier file."
            for name in sorted(self._remembered_used)
        ]

    def _describe_label(self, name: str) -> str:
        found = self._matcher(name)
        label = None if found is None or found == NO_CLASS else self._target.labels.get(found)
        return "no label of the set" if label is None else repr(label.key)

    def _unmatched_with_boxes(self, tracks: Iterable[TrackRows]) -> dict[str, UnknownLabel]:
        """Names that match no label and have boxes, in the order of the file."""
        if not self._unmatched:
            return {}
        names = {placeholder: name for name, placeholder in self._unmatched.items()}
        found: dict[str, UnknownLabel] = {}
        best: dict[str, float] = {}
        for rows in tracks:
            label = np.where(np.frombuffer(rows.kind, dtype=np.int8) == BOX, rows.label, UNSTATED_LABEL)
            if not (label < UNSTATED_LABEL).any():
                continue
            visibility = self._box_visibility(rows)
            for placeholder in np.unique(label[label < UNSTATED_LABEL]).tolist():
                name, row_indices = names[placeholder], np.flatnonzero(label == placeholder)
                clearest = int(row_indices[np.argmax(visibility[row_indices])])
                each = found.get(name) or UnknownLabel(
                    name, 0, 0, (), False, 0, (0.0, 0.0, 0.0, 0.0), self._locations[name]
                )
                if visibility[clearest] > best.get(name, -1.0):
                    best[name] = float(visibility[clearest])
                    x1, y1, x2, y2 = rows.edges[4 * clearest : 4 * clearest + 4]
                    each = replace(each, frame=rows.frame[clearest], box=(x1, y1, x2, y2))
                found[name] = replace(each, tracks=each.tracks + 1, boxes=each.boxes + len(row_indices))
        return {name: found[name] for name in self._unmatched if name in found}

    def _box_visibility(self, rows: TrackRows) -> FloatArray:
        """How well each box shows its sign: its area in px², less if it is hidden or cut by the picture's edge."""
        x1, y1, x2, y2 = np.frombuffer(rows.edges, dtype=np.float64).reshape(-1, 4).T
        is_hidden = (np.frombuffer(rows.flags, dtype=np.int8) & 6) > 0
        is_cut = (x1 <= 0) | (y1 <= 0) | (x2 >= self._target.video.width) | (y2 >= self._target.video.height)
        visibility: FloatArray = (
            (x2 - x1) * (y2 - y1) * np.where(is_hidden, _HIDDEN_WEIGHT, 1) * np.where(is_cut, _CUT_WEIGHT, 1)
        )
        return visibility
