"""Two lanes of the queue, each with workers of its own, so that what somebody waits for runs beside what takes hours.

A kind of job that is not listed here is long.
"""

from __future__ import annotations

from typing import Final, Literal

__all__ = ["LANES", "SHORT_KINDS", "SHORT_WORKERS", "Lane", "lane_of"]

Lane = Literal["long", "short"]
LANES: Final[tuple[Lane, ...]] = ("long", "short")
SHORT_KINDS: Final = ("import", "whatif", "export", "recording", "bundle", "scene")
SHORT_WORKERS: Final = 2
"""Processes at most in the short lane: the import of a long video must not hold up a what-if either."""


def lane_of(kind: str) -> Lane:
    """The lane of a kind of job."""
    return "short" if kind in SHORT_KINDS else "long"
