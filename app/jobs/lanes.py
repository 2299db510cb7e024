"""Lanes of the queue, each with its own workers: short jobs do not wait for long ones."""

from __future__ import annotations

from typing import Final, Literal

Lane = Literal["long", "short", "imports", "scenes"]
LANES: Final[tuple[Lane, ...]] = ("long", "short", "imports", "scenes")
STANDBY: Final = "stay"
"""Third argument of a worker that does not end when it is idle."""
MAX_WORKERS: Final = 2
"""Maximum number of processes in every lane except the long one, which has a setting.

An import decodes a whole video, so imports have a separate lane: two long ones must not delay a what-if, and a small
one gets the second process while a long one runs. Scenes need connections, because a server in their process makes
them; their workers are separate, so that no other worker needs connections.
"""
