"""The figures of a check: before and after, their differences with intervals, and what a budget allows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import UsageError
from tsr_engine.evaluation.tracking import VideoReport

FIGURES: Final[Mapping[str, tuple[str, bool]]] = {
    "found": ("signs found, %", True),
    "coverage": ("frames of signs covered at IoU 0.5, %", True),
    "read": ("signs classified correctly, %", True),
    "false": ("false tracks per 1,000 frames", False),
    "error": ("mean of Eq. 7 over covered frames", False),
}
"""Name -> description, and whether more is better."""
Unit = Literal["drives", "signs"]
_SAMPLES: Final = 2000
_MIN_DRIVES: Final = 8
"""With at least this many drives the bootstrap draws drives; with fewer it draws signs."""
_MIN_SIGNS: Final = 5
"""Fewest signs for an interval; false tracks belong to drives, so drawing signs gives no interval for them."""
_COLUMNS: Final = ("found", "signs", "covered", "frames", "right", "readable", "error", "matched", "false", "video")
Table = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Change:
    """One figure.

    Attributes:
        name: key of ``FIGURES``.
        before, after: the values; None: there is nothing to measure.
        difference: ``after - before``.
        interval: holds 95 % of paired bootstrap samples of the difference; None: there is too little data.
    """

    name: str
    before: float | None
    after: float | None
    difference: float | None
    interval: tuple[float, float] | None

    def shown(self) -> tuple[str, str, str, str]:
        """Before, after, difference and interval as text."""
        before, after = ("-" if value is None else f"{value:.4g}" for value in (self.before, self.after))
        difference = "-" if self.difference is None else f"{self.difference:+.4g}"
        interval = "-" if self.interval is None else f"{self.interval[0]:+.4g} to {self.interval[1]:+.4g}"
        return before, after, difference, interval


def changes(before: Sequence[VideoReport], after: Sequence[VideoReport], seed: int = 0) -> tuple[list[Change], Unit]:
    """Compute all figures of two results on the same drives, in the same order.

    Args:
        before: reports on the old results, one per drive.
        after: reports on the new results, one per drive.
        seed: seed of the bootstrap.

    Returns:
        The figures, and the unit that the bootstrap draws.
    """
    old, new = (np.concatenate([_rows(report) for report in reports]) for reports in (before, after))
    groups = np.concatenate([np.full(len(report.signs) + 1, k) for k, report in enumerate(before)])
    unit: Unit = "drives" if len(before) >= _MIN_DRIVES else "signs"
    if unit == "signs":
        groups = np.arange(len(old))
    kinds = [np.flatnonzero(groups == group) for group in np.unique(groups)]
    sums = np.stack([np.stack([table[rows].sum(axis=0) for rows in kinds]) for table in (old, new)])
    random = np.random.default_rng(seed)
    drawn = random.integers(0, len(kinds), size=(_SAMPLES, len(kinds)))
    weights = np.stack([np.bincount(row, minlength=len(kinds)) for row in drawn]).astype(np.float64)
    found = []
    for name in FIGURES:
        first, second = (_figure(name, table.sum(axis=0)) for table in (old, new))
        difference = None if first is None or second is None else second - first
        earlier, later = (_figures(name, weights @ side) for side in sums)  # NaN where a sample has nothing to measure
        gaps = (later - earlier)[np.isfinite(later - earlier)]
        interval = None
        enough = unit == "drives" or (name != "false" and int(new[:, 1].sum()) >= _MIN_SIGNS)
        if difference is not None and enough and len(gaps) >= _SAMPLES // 2:
            low, high = np.percentile(gaps, (2.5, 97.5)).tolist()
            interval = (low, high)
        found.append(Change(name, first, second, difference, interval))
    return found, unit


def budgets(texts: Sequence[str]) -> dict[str, float]:
    """Parse budgets such as ``["coverage=-0.5", "false=1"]`` to allowed differences by figure.

    Raises:
        UsageError: a figure is unknown, or a number is invalid.
    """
    allowed: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            number = float(value)
        except ValueError:
            number = float("nan")
        if not equals or name not in FIGURES or not np.isfinite(number):
            raise UsageError(
                f"--budget expects FIGURE=DIFFERENCE, for example coverage=-0.5; figures are {', '.join(FIGURES)}. "
                f"Got {text!r} instead."
            )
        better_up = FIGURES[name][1]
        if (better_up and number > 0) or (not better_up and number < 0):
            raise UsageError(
                f"--budget {name} says how much worse it may get, so it is 0 or {'less' if better_up else 'more'}. "
                f"Got {value}."
            )
        allowed[name] = number
    return allowed


def over_budget(found: Sequence[Change], allowed: Mapping[str, float]) -> list[str]:
    """Return one sentence for each figure that got worse by more than its budget."""
    reported = []
    for change in found:
        if change.name not in allowed or change.difference is None:
            continue
        worse = -change.difference if FIGURES[change.name][1] else change.difference
        if worse > abs(allowed[change.name]) + 1e-9:
            reported.append(
                f"{change.name} went from {change.before:.4g} to {change.after:.4g}, by {change.difference:+.4g}; "
                f"its budget is {allowed[change.name]:+g}."
            )
    return reported


def _rows(report: VideoReport) -> Table:
    """One row per sign, and one row for what belongs to the drive alone; columns as in ``_COLUMNS``."""
    errors: dict[int, list[float]] = {}
    for (_, number), (error, _) in zip(report.matched, report.errors, strict=True):
        errors.setdefault(number, []).append(error)
    rows: list[tuple[float, ...]] = []
    for sign in report.signs:
        sign_errors = errors.get(sign.track_id, [])
        readable = sign.class_id >= 0
        right = readable and bool(sign.ids) and sign.predicted_class == sign.class_id
        rows.append(
            (bool(sign.ids), 1, sign.covered, sign.frames, right, readable, sum(sign_errors), len(sign_errors), 0, 0)
        )
    rows.append((0, 0, 0, 0, 0, 0, 0.0, 0, len(report.false_tracks), report.frames))
    return np.array(rows, np.float64)


_PARTS: Final[Mapping[str, tuple[str, str, float]]] = {
    "found": ("found", "signs", 100.0),
    "coverage": ("covered", "frames", 100.0),
    "read": ("right", "readable", 100.0),
    "false": ("false", "video", 1000.0),
    "error": ("error", "matched", 1.0),
}


def _figures(name: str, sums: Table) -> Table:
    part, whole, factor = _PARTS[name]
    above, below = sums[:, _COLUMNS.index(part)], sums[:, _COLUMNS.index(whole)]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(below > 0, factor * above / below, np.nan))


def _figure(name: str, sums: Table) -> float | None:
    value = float(_figures(name, sums[None])[0])
    return None if np.isnan(value) else value
