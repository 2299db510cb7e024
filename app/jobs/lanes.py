"""Lanes of the queue, each with its own workers: short jobs do not wait for long ones."""

from __future__ import annotations

from typing import Final, Literal

__all__ = ["AT_ONCE", "LANES", "Lane"]

Lane = Literal["long", "short", "imports", "scenes"]
LANES: Final[tuple[Lane, ...]] = ("long", "short", "imports", "scenes")
AT_ONCE: Final = 2
"""Processes at most in every lane but the long one, for which a setting says it.

An import decodes a whole video. So imports have a lane of their own: two long ones must not hold up a what-if; and a
small one finds the second place while a long one goes on. Scenes need connections, because a
server in their process makes them; they have workers of their own, so no other worker needs any.
"""
