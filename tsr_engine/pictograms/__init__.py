"""Draws traffic signs as vectors at any size, with their silhouettes."""

from tsr_engine.pictograms.drawn import draw, names, svg

__all__ = ["draw", "names", "svg"]
