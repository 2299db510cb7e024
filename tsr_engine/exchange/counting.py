"""Decides on the whole list whether frame numbers count from 0 or from 1, reports it, or refuses the list."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Final

from tsr_engine.exchange.formats import Switch

__all__ = ["FIRST_FRAME_SWITCH", "Counted", "Custom", "origin_of"]

FIRST_FRAME_SWITCH: Final = Switch(
    "first_frame",
    ("auto", "0", "1"),
    "Number of the first frame in names of pictures; auto: decided on all of them, and told.",
)


@dataclass(frozen=True, slots=True)
class Custom:
    """How a tool counts frames, and which names it writes.

    Attributes:
        origin: number of its first frame.
        why: the end of the sentence that reports it; empty: nothing is reported.
        before: the whole text before the number, as a pattern.
        digits: how many digits numbers are filled up to with zeros; 1: not at all.
    """

    origin: int
    why: str = ""
    before: str = ".*"
    digits: int = 1

    def wrote(self, before: str, widths: Collection[tuple[int, bool]]) -> bool:
        """Whether the tool can have written names with this text before these numbers.

        Args:
            before: the text.
            widths: digits of each number, and whether the first of several is a zero.
        """
        return re.fullmatch(self.before, before) is not None and all(
            digits == self.digits or (digits > self.digits and not padded) for digits, padded in widths
        )


@dataclass(frozen=True, slots=True)
class Counted:
    """Where numbers count from.

    Attributes:
        origin: number of the first frame.
        reported: the sentence that says so, without the file; empty: there is nothing to report.
    """

    origin: int
    reported: str = ""


def origin_of(
    least: int,
    largest: int,
    frames: int,
    *,
    asked: str,
    custom: Custom | None,
    what: str,
    fail: Callable[[str], Exception],
) -> Counted:
    """Where the numbers of one list count from.

    Args:
        least: smallest number.
        largest: largest number.
        frames: frames of the video.
        asked: the switch ``first_frame``.
        custom: of the tool that wrote the names, if it is known.
        what: the numbers, for messages: ``picture numbers``.
        fail: makes the error about a rule that they break.

    Raises:
        ImportFormatError: both ways of counting fit.
    """
    if asked != "auto":
        return Counted(int(asked))
    fits = [origin for origin in (0, 1) if origin <= least and largest - origin < frames]
    if custom is not None and custom.origin in fits:
        return Counted(custom.origin, _reported(what, custom.origin, custom.why) if custom.why else "")
    if fits == [0] and not least:
        return Counted(0, _reported(what, 0, "0 is among them"))
    whole = least == 1 and largest == frames
    if fits == [1] and (custom is None or whole):
        why = f"they run from 1 to {frames}, the number of frames" if whole else f"frame {frames} is among them"
        return Counted(1, _reported(what, 1, why))
    if len(fits) == 2:
        raise fail(
            f"{what} ({_span(least, largest)}) fit a count from 0 and one from 1, and nothing says which it is. Import "
            "with first_frame=0 or first_frame=1.",
        )
    return Counted(0 if custom is None else custom.origin)


def _span(least: int, largest: int) -> str:
    return str(least) if least == largest else f"{least} to {largest}"


def _reported(what: str, origin: int, why: str) -> str:
    return f"{what} were counted from {origin}: {why} (first_frame)."
