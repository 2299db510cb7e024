"""Real AdaBoost over decision trees on byte features.

Schapire & Singer 1999, grown as in the toolbox: every tree sees a random share of the features, a node's
split minimises ``Z = sum over children of sqrt(w+ w-)`` over all 256 thresholds, a leaf answers half the log-odds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.detection.trees import NEVER, UNIT, TreeEnsemble

HIGHEST: Final = 240
"""Largest threshold: leaves room for a level's correction by up to 6 % in a byte."""


@dataclass(frozen=True, slots=True)
class BoostingPlan:
    """How trees are grown.

    Attributes:
        trees: number of trees.
        depth: depth of every tree, at most 5.
        feature_share: share of the features that one tree may look at.
        shrinkage: factor on every leaf.
        leaf_limit: leaves are clipped to +-leaf_limit before shrinkage.
    """

    trees: int
    depth: int = 3
    feature_share: float = 1 / 8
    shrinkage: float = 1.0
    leaf_limit: float = 3.0

    def __post_init__(self) -> None:
        if not 1 <= self.depth <= 5:
            raise ValueError(f"depth must be in 1..5. Got {self.depth} instead.")


def boost(
    positives: NDArray[np.uint8],
    negatives: NDArray[np.uint8],
    plan: BoostingPlan,
    rng: np.random.Generator,
    window: int,
    positive_weights: NDArray[np.float64] | None = None,
) -> TreeEnsemble:
    """Train an ensemble.

    Args:
        positives: shape (n, features), uint8.
        negatives: shape (m, features), uint8.
        plan: see :class:`BoostingPlan`.
        rng: source of the random feature shares.
        window: side of the window in cells.
        positive_weights: shape (n,), relative weights; unset: all alike. Both classes weigh the same in all.

    Returns:
        An ensemble without rejection.
    """
    n, m = len(positives), len(negatives)
    columns = np.ascontiguousarray(np.concatenate([positives, negatives]).T)
    is_positive = np.zeros(n + m, np.bool_)
    is_positive[:n] = True
    weights = np.full(n + m, 0.5 / m)
    share = np.ones(n) if positive_weights is None else positive_weights
    weights[:n] = 0.5 * share / share.sum()
    nodes = 2**plan.depth - 1
    features = np.zeros((plan.trees, nodes), np.int32)
    thresholds = np.zeros((plan.trees, nodes), np.uint8)
    leaves = np.zeros((plan.trees, nodes + 1), np.int16)
    total = len(columns)
    picked = max(1, int(total * plan.feature_share))
    floor = 0.2 / (n + m)
    for t in range(plan.trees):
        candidates = rng.choice(total, picked, replace=False).astype(np.int32)
        # samples that no longer matter are left out of the search for splits, not out of the leaves
        order = np.argsort(weights)
        cut = np.searchsorted(np.cumsum(weights[order]), 0.002 * weights.sum())
        kept = np.sort(order[cut:]).astype(np.int32)
        _grow(columns, kept, is_positive, weights, candidates, features[t], thresholds[t])
        place = _leaves(columns, features[t], thresholds[t])
        good = np.bincount(place[is_positive], weights[is_positive], nodes + 1) + floor
        bad = np.bincount(place[~is_positive], weights[~is_positive], nodes + 1) + floor
        answer = np.clip(0.5 * np.log(good / bad), -plan.leaf_limit, plan.leaf_limit) * plan.shrinkage
        leaves[t] = np.round(answer * UNIT)
        step = leaves[t][place] / UNIT
        weights *= np.exp(np.where(is_positive, -step, step))
        weights /= weights.sum()
    rejection = np.full(plan.trees, NEVER, np.int32)
    return TreeEnsemble(features, thresholds, leaves, rejection, window)


@njit(cache=True, nogil=True)
def _grow(columns, kept, is_positive, weights, candidates, features, thresholds):  # type: ignore[no-untyped-def]
    """Fills one tree's nodes level by level."""
    nodes = features.shape[0]
    node = np.zeros(kept.shape[0], np.int32)
    signed = np.empty(kept.shape[0], np.float32)
    for i in range(kept.shape[0]):
        signed[i] = weights[kept[i]] if is_positive[kept[i]] else -weights[kept[i]]
    first = 0
    while first < nodes:
        width = first + 1
        best = np.full(width, np.inf)
        hist = np.zeros((width, 2, 256), np.float32)
        for f in candidates:
            hist[:] = 0
            column = columns[f]
            for i in range(kept.shape[0]):
                s = signed[i]
                hist[node[i], 1 if s > 0 else 0, column[kept[i]]] += abs(s)
            for k in range(width):
                all_bad, all_good = 0.0, 0.0
                for v in range(256):
                    all_bad += hist[k, 0, v]
                    all_good += hist[k, 1, v]
                bad, good = 0.0, 0.0
                for v in range(HIGHEST):
                    bad += hist[k, 0, v]
                    good += hist[k, 1, v]
                    z = np.sqrt(bad * good) + np.sqrt(max(0.0, all_bad - bad) * max(0.0, all_good - good))
                    if z < best[k] - 1e-12:
                        best[k] = z
                        features[first + k] = f
                        thresholds[first + k] = v + 1
        for i in range(kept.shape[0]):
            k = first + node[i]
            right = columns[features[k], kept[i]] >= thresholds[k]
            node[i] = 2 * node[i] + (1 if right else 0)
        first = 2 * first + 1


@njit(cache=True, nogil=True)
def _leaves(columns, features, thresholds):  # type: ignore[no-untyped-def]
    nodes = features.shape[0]
    out = np.empty(columns.shape[1], np.int32)
    for i in range(columns.shape[1]):
        k = 0
        while k < nodes:
            k = 2 * k + (2 if columns[features[k], i] >= thresholds[k] else 1)
        out[i] = k - nodes
    return out
