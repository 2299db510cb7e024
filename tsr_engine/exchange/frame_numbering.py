"""Decides over a whole list whether frame numbers count from 0 or from 1; reports the choice, or refuses the list."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Final

from tsr_engine.exchange.formats import Switch

FIRST_FRAME_SWITCH: Final = Switch(
    "first_frame",
    ("auto", "0", "1"),
    "Number of the first frame in picture names; auto: decided over all names, and reported.",
)


@dataclass(frozen=True, slots=True)
class NumberingScheme:
    """How a tool numbers frames, and which names it writes.

    Attributes:
        origin: number of the first frame.
        reason: the reason in the report; empty: nothing is reported.
        prefix_pattern: pattern of the whole text before the number.
        digits: width of a number that is padded with zeros; 1: it is not padded.
    """

    origin: int
    reason: str = ""
    prefix_pattern: str = ".*"
    digits: int = 1

    def matches(self, prefix: str, widths: Collection[tuple[int, bool]]) -> bool:
        """Whether the tool can have written these names.

        Args:
            prefix: the text before the numbers.
            widths: digits of each number, and whether the first of several digits is a zero.
        """
        return re.fullmatch(self.prefix_pattern, prefix) is not None and all(
            digits == self.digits or (digits > self.digits and not padded) for digits, padded in widths
        )


@dataclass(frozen=True, slots=True)
class FoundOrigin:
    """The number of the first frame.

    Attributes:
        origin: number of the first frame.
        report: the sentence that reports it, without the file; empty: there is nothing to report.
    """

    origin: int
    report: str = ""


def find_origin(
    lowest: int,
    highest: int,
    frames: int,
    *,
    requested: str,
    scheme: NumberingScheme | None,
    what: str,
    fail: Callable[[str], Exception],
) -> FoundOrigin:
    """Find the number of the first frame in one list of numbers.

    Args:
        lowest: the smallest number.
        highest: the largest number.
        frames: number of frames of the video.
        requested: value of the switch ``first_frame``.
        scheme: of the tool that wrote the names; None: not known.
        what: what the numbers are, for messages: ``picture numbers``.
        fail: makes an error from a sentence.

    Raises:
        ImportFormatError: the numbers fit a count from 0 and a count from 1.
    """
    if requested != "auto":
        return FoundOrigin(int(requested))
    fits = [origin for origin in (0, 1) if origin <= lowest and highest - origin < frames]
    if scheme is not None and scheme.origin in fits:
        return FoundOrigin(scheme.origin, _reported(what, scheme.origin, scheme.reason) if scheme.reason else "")
    if fits == [0] and not lowest:
        return FoundOrigin(0, _reported(what, 0, "0 is among them"))
    is_complete = lowest == 1 and highest == frames
    if fits == [1] and (scheme is None or is_complete):
        why = f"they run from 1 to {frames}, the number of frames" if is_complete else f"frame {frames} is among them"
        return FoundOrigin(1, _reported(what, 1, why))
    if len(fits) == 2:
        raise fail(
            f"{what} ({_span(lowest, highest)}) fit a count from 0 and one from 1, and nothing says which it is. "
            "Import with first_frame=0 or first_frame=1."
        )
    return FoundOrigin(0 if scheme is None else scheme.origin)


def _span(lowest: int, highest: int) -> str:
    return str(lowest) if lowest == highest else f"{lowest} to {highest}"


def _reported(what: str, origin: int, reason: str) -> str:
    return f"{what} were counted from {origin}: {reason} (first_frame)."
