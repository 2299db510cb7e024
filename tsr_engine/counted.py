"""A number with its noun in messages."""

from __future__ import annotations

__all__ = ["counted"]


def counted(number: int, one: str, many: str | None = None) -> str:
    """``1 frame``, ``2 frames``.

    Args:
        number: how many.
        one: the noun for 1, and what else depends on it: ``box``, ``frame differs``.
        many: for other numbers; unset: ``one`` with an s.
    """
    return f"{number} {one if number == 1 else many or one + 's'}"
