"""Decides over a whole list whether frame numbers count from 0 or from 1; reports the choice, or refuses the list."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Final

from tsr_engine.exchange.formats import Switch

__all__ = ["FIRST_FRAME_SWITCH", "FoundOrigin", "NumberingScheme", "find_origin"]

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
        why: the reason in the report; empty: nothing is reported.
        before: pattern of the whole text before the number.
        digits: width of a number that is padded with zeros; 1: it is not padded.
    """

    origin: int
    why: str = ""
    before: str = ".*"
    digits: int = 1

    def wrote(self, before: str, widths: Collection[tuple[int, bool]]) -> bool:
        """Whether the tool can have written these names.

        Args:
            before: the text before the numbers.
            widths: digits of each number, and whether the first of several digits is a zero.
        """
        return re.fullmatch(self.before, before) is not None and all(
            digits == self.digits or (digits > self.digits and not padded) for digits, padded in widths
        )


@dataclass(frozen=True, slots=True)
class FoundOrigin:
    """The number of the first frame.

    Attributes:
        origin: number of the first frame.
        reported: the sentence that reports it, without the file; empty: there is nothing to report.
    """

    origin: int
    reported: str = ""


def find_origin(
    least: int,
    largest: int,
    frames: int,
    *,
    asked: str,
    custom: NumberingScheme | None,
    what: str,
    fail: Callable[[str], Exception],
) -> FoundOrigin:
    """Find the number of the first frame in one list of numbers.

    Args:
        least: the smallest number.
        largest: the largest number.
        frames: number of frames of the video.
        asked: value of the switch ``first_frame``.
        custom: of the tool that wrote the names; None: not known.
        what: what the numbers are, for messages: ``picture numbers``.
        fail: makes an error from a sentence.

    Raises:
        ImportFormatError: the numbers fit a count from 0 and a count from 1.
    """
    if asked != "auto":
        return FoundOrigin(int(asked))
    fits = [origin for origin in (0, 1) if origin <= least and largest - origin < frames]
    if custom is not None and custom.origin in fits:
        return FoundOrigin(custom.origin, _reported(what, custom.origin, custom.why) if custom.why else "")
    if fits == [0] and not least:
        return FoundOrigin(0, _reported(what, 0, "0 is among them"))
    whole = least == 1 and largest == frames
    if fits == [1] and (custom is None or whole):
        why = f"they run from 1 to {frames}, the number of frames" if whole else f"frame {frames} is among them"
        return FoundOrigin(1, _reported(what, 1, why))
    if len(fits) == 2:
        raise fail(
            f"{what} ({_span(least, largest)}) fit a count from 0 and one from 1, and nothing says which it is. Import "
            "with first_frame=0 or first_frame=1.",
        )
    return FoundOrigin(0 if custom is None else custom.origin)


def _span(least: int, largest: int) -> str:
    return str(least) if least == largest else f"{least} to {largest}"


def _reported(what: str, origin: int, why: str) -> str:
    return f"{what} were counted from {origin}: {why} (first_frame)."
