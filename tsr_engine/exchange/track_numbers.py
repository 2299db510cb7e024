"""Gives tracks whole numbers, for formats whose ids are numbers."""

from __future__ import annotations

import re
from collections.abc import Iterable

_NUMBERED = re.compile(r"(?:track|[a-z]{0,2})0*([0-9]{1,9})", re.ASCII)


def track_numbers(uids: Iterable[str], min_number: int = 1) -> dict[str, int]:
    """A number for each name: the one in it (``7``, ``m7``, ``track007``) if no other has it, else the next free one.

    Args:
        uids: different names.
        min_number: smallest number in a name that may be used, 0 or 1; free numbers begin at 1.
    """
    names = list(uids)
    found: dict[str, int] = {}
    used = set(range(min_number))
    for name in names:
        match = _NUMBERED.fullmatch(name)
        if match and int(match[1]) not in used:
            found[name] = int(match[1])
            used.add(found[name])
    next_number = 1
    for name in names:
        if name not in found:
            while next_number in used:
                next_number += 1
            found[name] = next_number
            used.add(next_number)
    return found
