"""Replaces some offline samples of the online detector by corrected signs (III-D.1)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tsr_engine.io.models import Component
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene
from tsr_engine.training.public.online_samples import train_online

__all__ = ["refine_online"]

SHARE = 0.4
"""Largest share of the offline samples that corrected signs replace."""
PER_SIGN = 3
"""Largest number of samples per sign: every track starts from them, so few signs must not dominate."""


def refine_online(parent: Component, scenes: Sequence[CorrectedScene], seed: int) -> Component:
    """Replace positive samples and as many negative ones; the number of samples, and so the speed, stays.

    Args:
        parent: component ``online``.
        scenes: corrected frames.
        seed: seed of all draws.

    Raises:
        InputError: there are no corrected signs, or a picture cannot be decoded.
    """
    rng = np.random.default_rng([seed, 41])
    vectors, labels = parent.arrays["X"], parent.arrays["y"].astype(np.int8, copy=False)
    signs = len({sign for scene in scenes for sign in scene.signs})
    positives = int((labels > 0).sum())
    count = min(int(SHARE * positives), PER_SIGN * signs)
    drawn = train_online([scene.scene for scene in scenes], seed, max(1, count))
    fresh = int((drawn.arrays["y"].astype(np.int8, copy=False) > 0).sum())
    kept = np.sort(np.concatenate([_kept(labels, sign, fresh, rng) for sign in (1, -1)]))
    arrays = {
        "X": np.concatenate([vectors[kept], drawn.arrays["X"]]),
        "y": np.concatenate([labels[kept], drawn.arrays["y"]]),
    }
    data = {"samples": len(arrays["y"]), "of_corrections": len(drawn.arrays["y"]), "signs": signs}
    return Component("online", arrays, dict(parent.params), data, {}, seed)


def _kept(labels: NDArray[np.int8], sign: int, gone: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Indices of one sign's samples that stay when ``gone`` are removed."""
    mine = np.flatnonzero(labels == sign)
    return np.asarray(np.sort(rng.permutation(mine)[min(gone, len(mine) - 1) :]))
