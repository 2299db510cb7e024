"""Small random ensembles and cells."""

from __future__ import annotations

import numpy as np

from tsr_engine.detection.trees import NEVER, TreeEnsemble


def random_ensemble(rng: np.random.Generator, trees: int = 20, depth: int = 3, window: int = 6) -> TreeEnsemble:
    nodes = 2**depth - 1
    rejection = rng.integers(-900, -100, trees).astype(np.int32)
    rejection[:3] = NEVER
    return TreeEnsemble(
        rng.integers(0, 10 * window * window, (trees, nodes)).astype(np.int32),
        rng.integers(0, 241, (trees, nodes)).astype(np.uint8),
        rng.integers(-300, 300, (trees, nodes + 1)).astype(np.int16),
        rejection,
        window,
    )


def random_cells(rng: np.random.Generator, rows: int = 23, columns: int = 31) -> np.ndarray:
    return rng.integers(0, 256, (10, rows, columns), dtype=np.uint8)


INVALID_PICTURES = {
    "empty": np.zeros((0, 0, 3), np.uint8),
    "no columns": np.zeros((40, 0, 3), np.uint8),
    "grey": np.zeros((20, 20), np.uint8),
    "grey, large": np.zeros((540, 960), np.uint8),
    "one channel": np.zeros((40, 40, 1), np.uint8),
    "BGRA": np.zeros((20, 20, 4), np.uint8),
    "float": np.zeros((40, 40, 3), np.float32),
    "16 bits": np.zeros((40, 40, 3), np.uint16),
}
"""Arrays that a caller may mistake for a picture, by their fault."""
