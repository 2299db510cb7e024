"""Drawings of the signs of the Vienna Convention on Road Signs and Signals, annex 1, by key."""

from tsr_engine.pictograms.vienna.table import DRAWINGS

__all__ = ["DRAWINGS"]
