"""The gate: symmetry, perceptual hash, distance (Eq. 3)."""
