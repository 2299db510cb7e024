"""Parses numbers of tables and attributes.

Python accepts more: ``1_0`` as ten, and digits of other scripts. In files these are mistakes, and other tools read
them differently or not at all.
"""

from __future__ import annotations


def parse_real(text: str) -> float:
    """Parse a number with or without sign, decimals and exponent; ``nan`` and ``inf`` are accepted.

    Raises:
        ValueError: the text is not a number.
    """
    return float(_plain(text))


def parse_whole(text: str) -> int:
    """Parse digits with or without a sign.

    Raises:
        ValueError: the text is not a whole number.
    """
    return int(_plain(text))


def _plain(text: str) -> str:
    # without these two checks, Python reads what the file says
    if "_" in text or not text.isascii():
        raise ValueError(f"{text[:40]!r} is no number")
    return text
