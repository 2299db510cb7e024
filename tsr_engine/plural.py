"""A number with its noun in messages."""

from __future__ import annotations


def plural(number: int, singular: str, plural_form: str | None = None) -> str:
    """The number with its noun: ``1 frame``, ``2 frames``.

    Args:
        number: the number.
        singular: singular noun, with a verb if the verb depends on it: ``box``, ``frame differs``.
        plural_form: plural noun; unset: ``singular`` with an s.
    """
    return f"{number} {singular if number == 1 else plural_form or singular + 's'}"
