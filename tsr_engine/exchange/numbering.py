"""Whole numbers for tracks, for formats whose ids are such."""

from __future__ import annotations

import re
from collections.abc import Iterable

__all__ = ["track_numbers"]

_NUMBERED = re.compile(r"(?:track|[a-z]{0,2})0*([0-9]{1,9})", re.ASCII)


def track_numbers(uids: Iterable[str]) -> dict[str, int]:
    """A number >= 1 for each name: the one in it (``7``, ``m7``, ``track7``) if no other has that, else the next free.

    Args:
        uids: different names.
    """
    names = list(uids)
    found: dict[str, int] = {}
    taken: set[int] = {0}
    for name in names:
        match = _NUMBERED.fullmatch(name)
        if match and int(match[1]) not in taken:
            found[name] = int(match[1])
            taken.add(found[name])
    free = 1
    for name in names:
        if name not in found:
            while free in taken:
                free += 1
            found[name] = free
            taken.add(free)
    return found
