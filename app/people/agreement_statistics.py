"""Figures of people's work, without access to a database."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from operator import itemgetter
from typing import TypeVar

import numpy as np

from tsr_engine.labels.model import LabelSet

T = TypeVar("T")


def by_name(named: Iterable[tuple[str, T]]) -> list[tuple[str, list[T]]]:
    """Group values by name, sorted by name."""
    found: dict[str, list[T]] = defaultdict(list)
    for name, value in named:
        found[name].append(value)
    return sorted(found.items(), key=itemgetter(0))


def label_name(labels: LabelSet, label: int | None) -> str:
    """Current name of a label; None: the person says that there is no sign."""
    if label is None:
        return "no sign"
    found = labels.get(labels.resolved(label))
    return "none of the set" if found is None else found.name


def share_interval(count: int, of: int) -> tuple[float, float]:
    """95 % interval of a share (Wilson 1927); 0 to 1 if ``of`` is 0."""
    if of == 0:
        return 0.0, 1.0
    z, share = 1.959964, count / of
    middle = (share + z * z / (2 * of)) / (1 + z * z / of)
    half = z * math.sqrt(share * (1 - share) / of + z * z / (4 * of * of)) / (1 + z * z / of)
    return max(0.0, middle - half), min(1.0, middle + half)


def mean_interval(values: Sequence[float]) -> tuple[float, float, float]:
    """Mean of shares and its 95 % interval (Student's t, cut to 0 to 1); 0 to 1 for fewer than two values."""
    if not values:
        return 0.0, 0.0, 1.0
    mean = math.fsum(values) / len(values)
    if len(values) < 2:
        return mean, 0.0, 1.0
    from scipy.special import stdtrit  # loaded here: takes 0.1 s that most servers never need

    half = float(stdtrit(len(values) - 1, 0.975)) * float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return mean, max(0.0, mean - half), min(1.0, mean + half)
