"""Limits for videos; a separate module, so that settings use it without loading a decoder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

MAX_PIXELS: Final = 50_000_000
"""Default limit on decoded pictures in px: a little more than 8K (7680x4320)."""


@dataclass(frozen=True, slots=True)
class VideoLimits:
    """Limits on the resources that a video may need.

    Attributes:
        max_pixels: largest picture, width times height.
        max_side: largest width or height in px.
    """

    max_pixels: int = MAX_PIXELS
    max_side: int = 16_384
