"""Drawings of the signs of the Vienna Convention on Road Signs and Signals by key, in the order of its annex 1."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

from tsr_engine.pictograms.canvas import Canvas
from tsr_engine.pictograms.vienna.danger import DANGER
from tsr_engine.pictograms.vienna.direction import DIRECTION
from tsr_engine.pictograms.vienna.mandatory import MANDATORY
from tsr_engine.pictograms.vienna.panels import PANELS
from tsr_engine.pictograms.vienna.priority import PRIORITY
from tsr_engine.pictograms.vienna.prohibitory import PROHIBITORY
from tsr_engine.pictograms.vienna.service import SERVICE
from tsr_engine.pictograms.vienna.special import SPECIAL
from tsr_engine.pictograms.vienna.zones import ZONES

__all__ = ["DRAWINGS"]

DRAWINGS: Final[Mapping[str, Callable[[], Canvas]]] = MappingProxyType(
    DANGER | PRIORITY | PROHIBITORY | MANDATORY | SPECIAL | ZONES | SERVICE | DIRECTION | PANELS
)
"""Makes the drawing of each key."""
