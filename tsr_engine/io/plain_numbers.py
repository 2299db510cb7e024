"""Parses numbers of tables and attributes.

Python accepts more: ``1_0`` as ten, and digits of other scripts. In a file these are mistakes, and other tools read
them differently or not at all.
"""

from __future__ import annotations

__all__ = ["real_number", "whole_number"]


def real_number(text: str) -> float:
    """A number with or without sign, decimals and exponent. ``nan`` and ``inf`` are left for the caller to judge.

    Raises:
        ValueError: it is none.
    """
    return float(_plain(text))


def whole_number(text: str) -> int:
    """Digits with or without a sign.

    Raises:
        ValueError: it is none.
    """
    return int(_plain(text))


def _plain(text: str) -> str:
    # without these two, what Python reads is what the file says
    if "_" in text or not text.isascii():
        raise ValueError(f"{text[:40]!r} is no number")
    return text
