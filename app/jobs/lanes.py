"""Two lanes of the queue, each with its own workers: what somebody waits for runs beside what takes hours."""

from __future__ import annotations

from typing import Final, Literal

__all__ = ["LANES", "SHORT_WORKERS", "Lane"]

Lane = Literal["long", "short"]
LANES: Final[tuple[Lane, ...]] = ("long", "short")
SHORT_WORKERS: Final = 2
"""Processes at most in the short lane: the import of a long video must not hold up a what-if either."""
