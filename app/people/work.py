"""Figures of people's work, from rows of the log: tracks decided, hours, agreement. Nothing here reads a database.

Rows count in the order of the log. Clocks of servers can differ, so a step back in time counts as none.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from itertools import pairwise
from typing import Final

from tsr_engine.json_shapes import JsonMapping

__all__ = ["BREAK", "Decision", "agreement", "clocks_differ", "decided", "decisions", "hours_of", "share_interval"]

BREAK: Final = timedelta(minutes=5)
"""Of a longer pause between two operations, as much as this counts as work."""
_SKEW: Final = timedelta(minutes=1)
_DECIDED: Final = ("accepted", "rejected")


@dataclass(frozen=True, slots=True)
class Decision:
    """A verdict of a person on a track."""

    author: str
    run: str
    track: str
    verdict: str


def decisions(rows: Iterable[tuple[str, str, str, JsonMapping]], undone: Iterable[str] = ()) -> list[Decision]:
    """Verdicts in the order of the log.

    Args:
        rows: operation, author, run and command of each ``set_review`` and ``review_tracks``.
        undone: operations that stand as undone: they decided nothing.
    """
    gone = set(undone)
    return [
        Decision(author, run, track, command["review"])
        for op_id, author, run, command in rows
        if op_id not in gone
        for track in dict.fromkeys([command["key"], *command.get("others", ())])
    ]


def decided(found: Iterable[Decision]) -> dict[str, set[tuple[str, str]]]:
    """Tracks that each person has accepted or rejected, by author."""
    by: dict[str, set[tuple[str, str]]] = {}
    for one in found:
        if one.verdict in _DECIDED:
            by.setdefault(one.author, set()).add((one.run, one.track))
    return by


def agreement(found: Iterable[Decision]) -> tuple[int, int]:
    """Of the tracks that two people have decided: how many, and on how many they say the same.

    The last verdict of each person counts, and of more than two people all must agree.
    """
    verdicts: dict[tuple[str, str], dict[str, str]] = {}
    for one in found:
        if one.verdict in _DECIDED:
            verdicts.setdefault((one.run, one.track), {})[one.author] = one.verdict
    several = [each for each in verdicts.values() if len(each) > 1]
    return len(several), sum(len(set(each.values())) == 1 for each in several)


def share_interval(count: int, of: int) -> tuple[float, float]:
    """The 95 % interval of a share that was counted (Wilson 1927); 0 to 1 where nothing was."""
    if of == 0:
        return 0.0, 1.0
    z, share = 1.959964, count / of
    middle = (share + z * z / (2 * of)) / (1 + z * z / of)
    half = z * math.sqrt(share * (1 - share) / of + z * z / (4 * of * of)) / (1 + z * z / of)
    return max(0.0, middle - half), min(1.0, middle + half)


def hours_of(moments: Sequence[datetime]) -> float:
    """Hours of work between a person's operations, given in the order of the log; pauses count up to ``BREAK``."""
    gaps = (later - earlier for earlier, later in pairwise(moments))
    return sum((min(max(gap, timedelta()), BREAK) for gap in gaps), timedelta()) / timedelta(hours=1)


def clocks_differ(moments: Iterable[datetime], now: datetime) -> timedelta | None:
    """How far clocks must differ for rows of the log to have these times; None: they need not.

    Args:
        moments: times of rows, in the order of the log.
        now: this moment, by the clock of this server.
    """
    most = timedelta()
    latest: datetime | None = None
    for moment in moments:
        most = max(most, moment - now)
        if latest is not None:
            most = max(most, latest - moment)
        latest = moment if latest is None else max(latest, moment)
    return most if most > _SKEW else None
