"""The gate: symmetry, perceptual hash, distance, and their product (Eq. 3)."""

from tsr_engine.gating.gate import Gate
from tsr_engine.gating.perceptual_hash import HashMemory, hamming, perceptual_hash
from tsr_engine.gating.symmetry import Symmetry, SymmetryDetector

__all__ = ["Gate", "HashMemory", "Symmetry", "SymmetryDetector", "hamming", "perceptual_hash"]
