"""Checks a box in a file: four finite numbers with an area, clipped at the edge of the picture."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar, cast

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import Skipped
from tsr_engine.exchange.formats import BAD_BOXES, ImportTarget
from tsr_engine.exchange.reading import location_of, rule_error
from tsr_engine.plural import plural

Edges = tuple[float, float, float, float]
Numbers = TypeVar("Numbers", bound=tuple[float, ...])

NO_BOX: Edges = (math.nan, math.nan, math.nan, math.nan)
"""Returned by ``BoxRules.edges`` for a box that is left out; compare by identity."""
_ROUNDING_PX = 0.011
"""Tolerance in px: rounded numbers may exceed the picture by half of their last digit."""


def scaled(edges: Edges, scale: tuple[float, float]) -> Edges:
    """Edges times the factors of x and y."""
    return edges[0] * scale[0], edges[1] * scale[1], edges[2] * scale[0], edges[3] * scale[1]


def check_pixels(edges: Edges, file: str, line: int | str) -> Edges:
    """Return a box of another tool; a box within the first pixel has relative coordinates.

    Raises:
        ImportFormatError: the box lies within the first pixel.
    """
    if all(0 <= edge <= 1 for edge in edges):
        rule = "the box lies within one pixel, so its edges are relative. Write px (Ultralytics: normalize=False)."
        raise rule_error(file, line, rule)
    return edges


class BoxRules:
    """Refuses boxes that break the rules, or leaves them out and counts them.

    Args:
        target: has the picture's size, and the switch that leaves bad boxes out.
    """

    def __init__(self, target: ImportTarget) -> None:
        self._target = target
        self._outside, self._first_outside = 0, ""
        self._bad, self._first_bad = 0, ""

    def edges(self, read: Callable[[], Numbers]) -> Numbers:
        """The numbers of a box that ``read`` returns; ``NO_BOX`` if the box is left out.

        Raises:
            ImportFormatError: the error of ``read``, with a hint at the switch.
        """
        try:
            return read()
        except ImportFormatError as error:
            self._leave_out(error)
            return cast(Numbers, NO_BOX)

    def check(self, edges: Edges, file: str, line: int | str | None = None) -> bool:
        """Whether edges form a box; False: the box is left out.

        Raises:
            ImportFormatError: they do not, and the switch ``bad_boxes`` is not ``skip``.
        """
        if edges is NO_BOX:
            return False
        x1, y1, x2, y2 = edges
        # NaN fails every comparison.
        if -math.inf < x1 < x2 < math.inf and -math.inf < y1 < y2 < math.inf:
            return True
        if not all(map(math.isfinite, edges)):
            rule = f"box {_text(edges)} must have four finite numbers. Correct it."
        else:
            rule = f"box {_text(edges)} must have a positive width and height. Correct it, or delete the row."
        self._leave_out(rule_error(file, line, rule))
        return False

    def _leave_out(self, error: ImportFormatError) -> None:
        if self._target.switches.get(BAD_BOXES.name) != "skip":
            hint = f"Or import with {BAD_BOXES.name}=skip, which leaves such boxes out."
            raise ImportFormatError(f"{error} {hint}", error.kind) from None
        self._bad += 1
        self._first_bad = self._first_bad or str(error)

    def clip(self, uid: str, edges: Edges, file: str, line: int | str | None) -> tuple[Edges, bool] | None:
        """A box clipped at the picture, and whether that is to be reported; None: it lies wholly outside."""
        video = self._target.video
        x1, y1, x2, y2 = edges
        if x1 >= 0 and y1 >= 0 and x2 <= video.width and y2 <= video.height:
            return edges, False
        clipped = (max(x1, 0.0), max(y1, 0.0), min(x2, float(video.width)), min(y2, float(video.height)))
        if clipped[0] >= clipped[2] or clipped[1] >= clipped[3]:
            self._outside += 1
            self._first_outside = self._first_outside or f"{location_of(file, line)}, track {uid}: {_text(edges)}"
            return None
        return clipped, max(clipped[0] - x1, clipped[1] - y1, x2 - clipped[2], y2 - clipped[3]) > _ROUNDING_PX

    def skipped(self) -> list[Skipped]:
        """What was left out; each kind with its first box."""
        found: list[Skipped] = []
        if self._outside:
            reason = f"They lie outside the picture; the first: {self._first_outside}."
            found.append(Skipped(plural(self._outside, "box", "boxes"), reason))
        if self._bad:
            reason = (
                "They have no area, or a coordinate is missing or not a number "
                f"({BAD_BOXES.name}=skip); the first: {self._first_bad}"
            )
            found.append(Skipped(plural(self._bad, "box", "boxes"), reason))
        return found


def _text(edges: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{edge:g}" for edge in edges) + ")"
