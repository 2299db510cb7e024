"""Colours of the drawings, sRGB (r, g, b)."""

from __future__ import annotations

from tsr_engine.pictograms.canvas import Colour

BLACK: Colour = (22, 22, 24)
RED: Colour = (190, 22, 32)
WHITE: Colour = (238, 240, 238)
BLUE: Colour = (12, 72, 150)
YELLOW: Colour = (246, 190, 16)
GREY: Colour = (120, 122, 124)
PALE: Colour = (184, 186, 188)
GREEN: Colour = (0, 112, 74)
ORANGE: Colour = (240, 122, 20)
BROWN: Colour = (112, 66, 36)
AMBER: Colour = (232, 172, 18)
SIGNAL_GREEN: Colour = (16, 132, 92)
