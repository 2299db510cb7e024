"""Reads class, score, ignored and occluded from a MOT row by the meaning of its columns."""

from __future__ import annotations

import math

from tsr_engine.exchange.dataset import UNSTATED_LABEL
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.mot.columns import MIN_VISIBILITY, VISDRONE, Columns, Row
from tsr_engine.exchange.reading import rule_error

LABELS_FILE = "labels.txt"
"""The list of class names beside the rows."""
_MOSTLY_OCCLUDED = 2
"""VisDrone's occlusion of more than half of a sign."""


class RowValues:
    """Reads class, score, ignored and occluded from a row."""

    def __init__(
        self, columns: Columns, names: list[str] | None, first: int | None, file: str, validator: ImportValidator
    ) -> None:
        """Take what holds for all rows.

        Args:
            columns: index of each column.
            names: lines of ``labels.txt``; None: there is none.
            first: number of the first class chosen by a person; None: no choice.
            file: for messages.
            validator: takes the reports.
        """
        self._columns = columns
        self._listed = names is not None
        self._names = names if columns.names is None else list(columns.names)
        self._first = columns.first_class if first is None or columns.names is not None else first
        self._file = file
        self._validator = validator

    def __call__(self, values: Row, line: int) -> tuple[int, float, bool, bool]:
        """Return class, score, ignored and occluded of one row.

        Raises:
            ImportFormatError: a column holds an invalid value.
        """
        columns = self._columns
        flag = (
            1.0
            if columns.flag is None or (columns.score is not None and values[columns.flag] == -1)
            else values[columns.flag]
        )
        if flag not in (0.0, 1.0):
            description = f"Got {flag:g}; results have 10 columns."
            raise rule_error(self._file, line, f"column 7 must be 0 (ignore) or 1. {description}")
        visibility = 1.0 if columns.visibility is None else values[columns.visibility]
        if not -1 <= visibility <= 1:
            raise rule_error(self._file, line, f"the visibility must be in 0 to 1, or -1. Got {visibility:g}.")
        score = (
            math.nan
            if columns.score is None or values[columns.score] == -1
            else self._score(values[columns.score], line)
        )
        occluded = 0 <= visibility < MIN_VISIBILITY or (
            columns.occlusion is not None and values[columns.occlusion] >= _MOSTLY_OCCLUDED
        )
        is_ignored_region = columns.names is VISDRONE and columns.label is not None and values[columns.label] == 0
        label = (
            UNSTATED_LABEL if columns.label is None or is_ignored_region else self._label(values[columns.label], line)
        )
        return label, score, flag == 0.0 or is_ignored_region, occluded

    def _score(self, score: float, line: int) -> float:
        if score != score or 0 <= score <= 1:
            return score
        if self._validator.target.switches.get("scores") != "drop":
            rule = f"score {score:g} must be in 0 to 1. Scale the scores, or leave them out with scores=drop."
            raise rule_error(self._file, line, rule)
        self._validator.count("Scores outside 0 to 1 were left out", self._file, line)
        return math.nan

    def _label(self, number: float, line: int) -> int:
        if not (math.isfinite(number) and number == int(number)):
            raise rule_error(self._file, line, f"the class must be a whole number. Got {number:g}.")
        if number == -1:  # unused columns hold it
            return UNSTATED_LABEL
        if not self._listed and str(int(number)) in self._validator.target.label_map:
            return self._validator.label(str(int(number)), self._file, line, number=True)
        index = int(number) - self._first
        if self._names is not None:
            if not 0 <= index < len(self._names):
                rule = f"class {int(number)} must be {self._first} to {len(self._names) - 1 + self._first}"
                if not self._listed:
                    raise rule_error(self._file, line, f"{rule}, VisDrone's classes. Import with columns=results.")
                hint = f"Import with first_class={1 - self._first} if the file counts from there."
                raise rule_error(self._file, line, f"{rule}, the lines of {LABELS_FILE}. {hint}")
            return self._validator.label(self._names[index], self._file, line)
        self._validator.count(
            f"Rows without {LABELS_FILE} took their class number, counted from {self._first} (first_class), "
            "as the tool's",
            self._file,
            line,
        )
        return self._validator.label(f"class {index}", self._file, line, number=True)
