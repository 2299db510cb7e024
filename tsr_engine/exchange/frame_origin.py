"""Finds the first frame number of a table that does not state it."""

from __future__ import annotations

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.formats import Switch
from tsr_engine.exchange.import_validator import ImportValidator

FIRST_FRAME_SWITCH = Switch(
    "first_frame",
    ("auto", "0", "1"),
    "Number of the first frame; auto: 1 with MOT's bb_left, or if the numbers run from 1 to the number of frames.",
)


class FrameOrigin:
    """Collects the frame numbers of a file, finds where they begin, and converts them to ordinals.

    Attributes:
        origin: number of the first frame.
        decided: whether the origin is decided.
    """

    def __init__(self, validator: ImportValidator, default: int | None = None, *, is_certain: bool = False) -> None:
        """Take the video and the switch ``first_frame``.

        Args:
            validator: of the import.
            default: the first frame number of the tool; None: not known.
            is_certain: whether the file is our own, which counts from ``default``.
        """
        self._validator = validator
        self._default = default
        option = validator.target.switches.get("first_frame", "auto")
        self.decided = option != "auto" or is_certain
        self.origin = int(option) if option != "auto" else default or 0
        self._numbers: set[float] = set()

    def add(self, number: float) -> None:
        """Collect a frame number."""
        self._numbers.add(number)

    def decide(self, file: str, *, documented: bool = False) -> None:
        """Decide the origin from all numbers; report an ambiguous choice unless the layout is ``documented``."""
        frames = self._validator.target.video.frames
        self.decided = True
        if not self._numbers:
            return
        lowest, highest = min(self._numbers), max(self._numbers)
        # Two rows may name wrong frames by mistake, but not half of all frames.
        if self._default is None and (lowest, highest) == (1, frames) and 2 * len(self._numbers) >= frames:
            self.origin = 1
            self._validator.repair(f"{file}: frames were counted from 1, since the numbers are 1 to {frames}.")
        elif 1 <= lowest <= highest < frames and not documented and (self._default is None or lowest > 1):
            self._validator.repair(
                f"{file}: frames were counted from {self.origin}, but the numbers {lowest:g} to {highest:g} fit "
                f"0 and 1. Import with first_frame={1 - self.origin} if they count from {1 - self.origin}."
            )

    def frame(self, number: float | str, file: str, line: int | str) -> int:
        """Convert a frame number to an ordinal.

        Raises:
            ImportFormatError: it is not a whole number, or not a frame of the video.
        """
        try:
            return self._validator.frame(number, file, line, origin=self.origin)
        except ImportFormatError as error:
            hint = f" Import with first_frame={1 - self.origin} if the file counts from there."
            raise ImportFormatError(f"{error}{hint if 'whole number' not in str(error) else ''}", error.kind) from None
