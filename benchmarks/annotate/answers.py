"""The annotator's answers: one row for each place, one column for each look at it."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.experiment import ROOT

PLACES: Final = ROOT / "data" / "gtsdb_signs_seen.csv"
CONTROLS: Final = ROOT / "data" / "gtsdb_signs_controls.csv"
WORDS: Final = ("", "unsure", "none", "other", "unread", "vehicle", "board")
"""Answers other than label keys: not noted; undecided; no sign; a sign that the label set lacks; an unreadable sign; a
sign on a vehicle, a sticker or a lorry's board; a direction board, an advertisement or the like."""


@dataclass(frozen=True, slots=True)
class AnnotatedPlace:
    """A place that may show a sign.

    Attributes:
        scene: stem of the picture, ``00001``.
        box: shape (4,), rough, px.
        cutouts: the answer when cut-outs of candidates were sorted; empty: not noted.
        scenes: the answer when whole scenes were searched; empty: not noted.
        close: the answer at a close look, made for every place but boards.
        again: the answer when all signs were named a second time in shuffled order; empty: not asked.
        settled: the answer after a review of a disagreement; empty: there was none.
    """

    scene: str
    box: tuple[float, float, float, float]
    cutouts: str
    scenes: str
    close: str
    again: str
    settled: str

    @property
    def answer(self) -> str:
        """The final answer: settled, or agreed on; ``unread`` if two looks disagree."""
        if self.settled:
            return self.settled
        return self.close if self.alike else "unread"

    @property
    def alike(self) -> bool:
        """Whether the second naming agrees with the close look; ``unread`` agrees with ``vehicle``."""
        return self.again in ("", self.close) or (self.close, self.again) == ("vehicle", "unread")


@dataclass(frozen=True, slots=True)
class Control:
    """A sign of ``gt.txt`` that was mixed with the others, to measure the annotator's error rate.

    Attributes:
        truth: key of its label in ``gt.txt``.
        again: the answer.
    """

    truth: str
    again: str


def read_places() -> list[AnnotatedPlace]:
    """All places, in the order of the file."""
    return [
        AnnotatedPlace(
            row["scene"], _box(row), *(row[name] for name in ("cutouts", "scenes", "close", "again", "settled"))
        )
        for row in _rows(PLACES)
    ]


def read_controls() -> list[Control]:
    """All controls."""
    return [Control(row["truth"], row["again"]) for row in _rows(CONTROLS)]


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _box(row: dict[str, str]) -> tuple[float, float, float, float]:
    x1, y1, x2, y2 = (float(row[name]) for name in ("x1", "y1", "x2", "y2"))
    return x1, y1, x2, y2
