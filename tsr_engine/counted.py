"""A number with its noun in messages."""

from __future__ import annotations

__all__ = ["counted"]


def counted(number: int, one: str, many: str | None = None) -> str:
    """The number with its noun: ``1 frame``, ``2 frames``.

    Args:
        number: the number.
        one: singular noun, with a verb if the verb depends on it: ``box``, ``frame differs``.
        many: plural noun; unset: ``one`` with an s.
    """
    return f"{number} {one if number == 1 else many or one + 's'}"
