"""One picture as a source of pixels."""

from __future__ import annotations

from tsr_engine.recognition.crops import cut
from tsr_engine.records import Picture


class PicturePixels:
    """Crops of one picture; implements :class:`tsr_engine.protocols.PixelSource`."""

    def __init__(self, picture: Picture) -> None:
        self._picture = picture
        self.height, self.width = picture.shape[:2]

    def crop(self, x1: int, y1: int, x2: int, y2: int) -> Picture:
        """The pixels of a rectangle that overlaps the picture; the border is replicated beyond the edges."""
        return cut(self._picture, (x1, y1, x2, y2), 0.0)
