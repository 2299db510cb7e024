"""Real AdaBoost over decision trees on byte features.

Schapire & Singer 1999, grown as in the toolbox. Every tree uses a random share of the features. A node's split
minimises ``Z = sum over children of sqrt(w+ w-)`` over all 256 thresholds. A leaf's value is half the log-odds.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import numba
import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.detection.trees import NEVER, UNIT, TreeEnsemble

MAX_THRESHOLD: Final = 240
"""Largest threshold: a level can correct it by up to 6 % within a byte."""
FEATURE_PARTS: Final = 16
"""Number of parts of the features; the parts are searched for splits in parallel."""


@dataclass(frozen=True, slots=True)
class BoostingPlan:
    """Settings of boosting.

    Attributes:
        trees: number of trees.
        depth: depth of every tree, 1 to 5.
        feature_share: share of the features that one tree may use, in (0, 1].
        shrinkage: factor on every leaf.
        leaf_limit: leaves are clipped to +-leaf_limit before shrinkage.

    Raises:
        ValueError: the depth is out of range.
    """

    trees: int
    depth: int = 3
    feature_share: float = 1 / 8
    shrinkage: float = 1.0
    leaf_limit: float = 3.0

    def __post_init__(self) -> None:
        if not 1 <= self.depth <= 5:
            raise ValueError(f"depth must be in 1..5. Got {self.depth} instead.")


def training_threads() -> int:
    """Number of threads of a training: that of Numba, so that ``NUMBA_NUM_THREADS`` limits both."""
    return int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


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
        plan: settings of boosting.
        rng: random generator; chooses the features of each tree.
        window: side of the window in cells.
        positive_weights: shape (n,), relative weights; unset: equal weights. Each class has half of the total weight.

    Returns:
        An ensemble without rejection thresholds.
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
    per_tree = max(1, int(total * plan.feature_share))
    floor = 0.2 / (n + m)
    with ThreadPoolExecutor(training_threads(), "tsr-boost") as pool:
        for t in range(plan.trees):
            candidates = rng.choice(total, per_tree, replace=False).astype(np.int32)
            # Samples of negligible weight are left out of the search for splits, but count in the leaves.
            order = np.argsort(weights)
            cut = np.searchsorted(np.cumsum(weights[order]), 0.002 * weights.sum())
            kept = np.sort(order[cut:]).astype(np.int32)
            _grow(columns, kept, is_positive, weights, candidates, features[t], thresholds[t], pool)
            leaf = _leaf_indices(columns, features[t], thresholds[t])
            positive_sums = np.bincount(leaf[is_positive], weights[is_positive], nodes + 1) + floor
            negative_sums = np.bincount(leaf[~is_positive], weights[~is_positive], nodes + 1) + floor
            leaf_values = (
                np.clip(0.5 * np.log(positive_sums / negative_sums), -plan.leaf_limit, plan.leaf_limit) * plan.shrinkage
            )
            leaves[t] = np.round(leaf_values * UNIT)
            step = leaves[t][leaf] / UNIT
            weights *= np.exp(np.where(is_positive, -step, step))
            weights /= weights.sum()
    rejection = np.full(plan.trees, NEVER, np.int32)
    return TreeEnsemble(features, thresholds, leaves, rejection, window)


def boost_further(
    samples: NDArray[np.uint8],
    target: NDArray[np.float64],
    weights: NDArray[np.float64],
    start: NDArray[np.float64],
    plan: BoostingPlan,
    rng: np.random.Generator,
    window: int,
    inertia: float,
) -> TreeEnsemble:
    """Train more trees that add to existing scores (LogitBoost, Friedman, Hastie & Tibshirani 2000).

    A leaf's value is a Newton step of the logistic loss, ``1/2 sum w (y - p) / (sum w p (1 - p) + inertia)``. Samples
    whose scores are right have almost no effect, and a few wrong ones a small effect. A sample whose target equals its
    current probability holds its score in place.

    Args:
        samples: shape (n, features), uint8.
        target: shape (n,), target probability of being a sign, in [0, 1].
        weights: shape (n,), absolute weights, in the unit of ``inertia``.
        start: shape (n,), current scores, in half log-odds.
        plan: settings of boosting.
        rng: random generator; chooses the features of each tree.
        window: side of the window in cells.
        inertia: added to a leaf's denominator; larger values give smaller steps.

    Returns:
        An ensemble of the new trees alone, without rejection thresholds.
    """
    columns = np.ascontiguousarray(samples.T)
    score = start.astype(np.float64).copy()
    nodes = 2**plan.depth - 1
    features = np.zeros((plan.trees, nodes), np.int32)
    thresholds = np.zeros((plan.trees, nodes), np.uint8)
    leaves = np.zeros((plan.trees, nodes + 1), np.int16)
    per_tree = max(1, int(len(columns) * plan.feature_share))
    all_samples = np.arange(len(samples), dtype=np.int32)
    with ThreadPoolExecutor(training_threads(), "tsr-boost") as pool:
        for t in range(plan.trees):
            candidates = rng.choice(len(columns), per_tree, replace=False).astype(np.int32)
            p = 1.0 / (1.0 + np.exp(np.clip(-2.0 * score, -60.0, 60.0)))
            slope = weights * (target - p)
            _grow(columns, all_samples, slope > 0, np.abs(slope), candidates, features[t], thresholds[t], pool)
            leaf = _leaf_indices(columns, features[t], thresholds[t])
            gradients = np.bincount(leaf, slope, nodes + 1)
            curvatures = np.bincount(leaf, weights * p * (1.0 - p), nodes + 1)
            leaf_values = (
                np.clip(0.5 * gradients / (curvatures + inertia), -plan.leaf_limit, plan.leaf_limit) * plan.shrinkage
            )
            leaves[t] = np.round(leaf_values * UNIT)
            score += leaves[t][leaf] / UNIT
    return TreeEnsemble(features, thresholds, leaves, np.full(plan.trees, NEVER, np.int32), window)


def _grow(
    columns: NDArray[np.uint8],
    kept: NDArray[np.int32],
    is_positive: NDArray[np.bool_],
    weights: NDArray[np.float64],
    candidates: NDArray[np.int32],
    features: NDArray[np.int32],
    thresholds: NDArray[np.uint8],
    pool: ThreadPoolExecutor,
) -> None:
    """Fills one tree's nodes level by level. The splits do not depend on how the features are divided into parts."""
    node = np.zeros(len(kept), np.int32)
    signed = np.where(is_positive, weights, -weights)[kept].astype(np.float32)
    first = 0
    while first < len(features):
        width = first + 1
        parts = [
            pool.submit(_best_splits, columns, kept, signed, node, part, width)
            for part in np.array_split(candidates, FEATURE_PARTS)
        ]
        best = np.full(width, np.inf)
        for part in parts:
            scores, chosen, levels = part.result()
            better = scores < best
            best[better] = scores[better]
            features[first : first + width][better] = chosen[better]
            thresholds[first : first + width][better] = levels[better]
        _assign_children(columns, kept, node, features[first : first + width], thresholds[first : first + width])
        first = 2 * first + 1


@njit(cache=True, nogil=True)
def _best_splits(columns, kept, signed, node, candidates, width):  # type: ignore[no-untyped-def]
    """The smallest ``Z`` of each node, with its feature and threshold."""
    best = np.full(width, np.inf)
    features = np.zeros(width, np.int32)
    thresholds = np.zeros(width, np.uint8)
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
            for v in range(MAX_THRESHOLD):
                bad += hist[k, 0, v]
                good += hist[k, 1, v]
                z = np.sqrt(bad * good) + np.sqrt(max(0.0, all_bad - bad) * max(0.0, all_good - good))
                if z < best[k] - 1e-12:
                    best[k] = z
                    features[k] = f
                    thresholds[k] = v + 1
    return best, features, thresholds


@njit(cache=True, nogil=True)
def _assign_children(columns, kept, node, features, thresholds):  # type: ignore[no-untyped-def]
    for i in range(kept.shape[0]):
        k = node[i]
        right = columns[features[k], kept[i]] >= thresholds[k]
        node[i] = 2 * k + (1 if right else 0)


@njit(cache=True, nogil=True)
def _leaf_indices(columns, features, thresholds):  # type: ignore[no-untyped-def]
    nodes = features.shape[0]
    out = np.empty(columns.shape[1], np.int32)
    for i in range(columns.shape[1]):
        k = 0
        while k < nodes:
            k = 2 * k + (2 if columns[features[k], i] >= thresholds[k] else 1)
        out[i] = k - nodes
    return out
