"""The soft cascade over every window of one pyramid level.

The first trees are evaluated for a whole row of windows at once. A node of neighbouring windows reads neighbouring
bytes, so one vector instruction compares dozens of windows without a branch. The surviving windows continue tree by
tree, and window by window once few are left. All parts add the same whole numbers, so the result equals that of a
plain loop to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.detection.trees import TreeEnsemble
from tsr_engine.kernels import kernel

BAND_ROWS: Final = 32
"""Rows that are processed together: enough to keep the processor busy, few enough to stay in its cache."""
BLOCK_WINDOWS: Final = 64
"""Neighbouring windows that are skipped together if none survives, as in most of road and sky."""

MAX_SINGLE_WINDOWS: Final = 64
"""Number of surviving windows of a band up to which the remaining trees run window by window."""


@dataclass(frozen=True, slots=True)
class ScanNodes:
    """An ensemble's nodes prepared for levels of one size and gain.

    Attributes:
        offsets: shape (trees, 7), uint32: offset of each node's byte from a window's first byte.
        thresholds: shape (trees, 7), uint8: thresholds for cells without the gains.
    """

    offsets: NDArray[np.uint32]
    thresholds: NDArray[np.uint8]


def prepare(ensemble: TreeEnsemble, rows: int, columns: int, gains: NDArray[np.float64] | None = None) -> ScanNodes:
    """Nodes for levels of (channels, rows, columns) cells.

    ``floor(cell * gain) >= t`` is ``cell >= ceil(t / gain)``: the gains go into the thresholds.

    Args:
        ensemble: trees of depth 3.
        rows: rows of the level, with its border.
        columns: columns of the level, with its border.
        gains: shape (channels,), the level's correction factors; unset: none.

    Raises:
        ValueError: the trees have another depth.
    """
    if ensemble.depth != 3:
        raise ValueError(f"The scan needs trees of depth 3. Got {ensemble.depth} instead.")
    window = ensemble.window
    channel, rest = np.divmod(ensemble.features, window * window)
    dy, dx = np.divmod(rest, window)
    offsets = np.asarray((channel * rows + dy) * columns + dx, dtype=np.uint32)
    if gains is None:
        return ScanNodes(offsets, ensemble.thresholds)
    wanted = np.ceil((ensemble.thresholds - 1e-9) / gains[channel])
    return ScanNodes(offsets, np.asarray(np.clip(wanted, 0, 255), dtype=np.uint8))


def scan_level(
    cells: NDArray[np.uint8], ensemble: TreeEnsemble, dense_trees: int, nodes: ScanNodes | None = None
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Find all windows of one level that pass the cascade.

    Args:
        cells: shape (channels, rows, columns), uint8, contiguous.
        ensemble: trees of depth 3 with their rejection thresholds; the first ``dense_trees - 1`` thresholds are unused.
        dense_trees: number of first trees that are evaluated for every window.
        nodes: result of :func:`prepare` for a level of this size; unset: prepared here, without gains.

    Returns:
        Row and column of the first cell, and score in 1/UNIT, of each survivor, in scan order; shape (n,), int32 each.

    Raises:
        ValueError: the trees have another depth.
    """
    nodes = nodes or prepare(ensemble, cells.shape[1], cells.shape[2])
    window = ensemble.window
    ny, nx = cells.shape[1] - window + 1, cells.shape[2] - window + 1
    if ny < 1 or nx < 1:
        none = np.zeros(0, np.int32)
        return none, none, none
    found, y, x, score = _scan(
        cells.reshape(-1), cells.shape[2], ny, nx, nodes.offsets, nodes.thresholds, ensemble.leaves,
        ensemble.rejection, min(dense_trees, len(ensemble)),
    )  # fmt: skip
    return y[:found], x[:found], score[:found]


@kernel()
def _add_tree(f0, f1, f2, f3, f4, f5, f6, t, v, acc):  # type: ignore[no-untyped-def]
    """Adds one tree of depth 3, with thresholds ``t`` and leaves ``v``, to the sums of a row of windows."""
    t0, t1, t2, t3, t4, t5, t6 = t[0], t[1], t[2], t[3], t[4], t[5], t[6]
    v0, v1, v2, v3, v4, v5, v6, v7 = v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7]
    for x in range(acc.shape[0]):
        a = v1 if f3[x] >= t3 else v0
        b = v3 if f4[x] >= t4 else v2
        c = v5 if f5[x] >= t5 else v4
        d = v7 if f6[x] >= t6 else v6
        a = b if f1[x] >= t1 else a
        c = d if f2[x] >= t2 else c
        acc[x] += c if f0[x] >= t0 else a


@kernel()
def _max_of(totals):  # type: ignore[no-untyped-def]
    best = totals[0]
    for x in range(totals.shape[0]):
        best = max(best, totals[x])
    return best


@kernel()
def _leaf(flat, position, o, v):  # type: ignore[no-untyped-def]
    """Number of the leaf that the window at ``at`` reaches in a tree with offsets ``o`` and thresholds ``v``."""
    k = np.uint32(2) if flat[position + o[0]] >= v[0] else np.uint32(1)
    k = k + k + (np.uint32(2) if flat[position + o[k]] >= v[k] else np.uint32(1))
    k = k + k + (np.uint32(2) if flat[position + o[k]] >= v[k] else np.uint32(1))
    return k - np.uint32(7)


@kernel()
def _next_tree(flat, o, v, leaf, threshold, positions, totals, count):  # type: ignore[no-untyped-def]
    """Adds one tree to the sums of the surviving windows, moves the survivors to the front, and returns their number.

    This order suits many windows: their look-ups overlap in the processor, and the tree stays in registers.
    """
    survivors = 0
    for i in range(count):
        position = positions[i]
        total = totals[i] + leaf[_leaf(flat, position, o, v)]
        positions[survivors] = position
        totals[survivors] = total
        survivors += 1 if total >= threshold else 0
    return survivors


@kernel()
def _other_trees(flat, offsets, thresholds, leaves, rejection, positions, totals, count):  # type: ignore[no-untyped-def]
    """Adds all given trees to the sums, window by window, moves the survivors to the front, and returns their number.

    This order suits few windows: the look-ups of a window's trees overlap in the processor.
    """
    survivors = 0
    for i in range(count):
        position, total, alive = positions[i], totals[i], True
        for t in range(offsets.shape[0]):
            total += leaves[t, _leaf(flat, position, offsets[t], thresholds[t])]
            if total < rejection[t]:
                alive = False
                break
        if alive:
            positions[survivors], totals[survivors] = position, total
            survivors += 1
    return survivors


@kernel()
def _scan_band(  # type: ignore[no-untyped-def]
    flat, columns, nx, top, rows, offsets, thresholds, leaves, rejection, dense, acc, positions, totals
):
    """Fills positions and totals with the windows of some rows that pass the cascade, and returns their number."""
    # Rows lie one after another in memory, so a band is one long row; its last columns of each row are not windows.
    base = top * columns
    end = base + (rows - 1) * columns + nx
    sums = acc[: end - base]
    sums[:] = 0
    for t in range(dense):
        o = offsets[t]
        _add_tree(
            flat[base + o[0] : end + o[0]], flat[base + o[1] : end + o[1]], flat[base + o[2] : end + o[2]],
            flat[base + o[3] : end + o[3]], flat[base + o[4] : end + o[4]], flat[base + o[5] : end + o[5]],
            flat[base + o[6] : end + o[6]], thresholds[t], leaves[t], sums,
        )  # fmt: skip
    count, limit = 0, rejection[dense - 1]
    for row in range(rows):
        for start in range(row * columns, row * columns + nx, BLOCK_WINDOWS):
            block = sums[start : min(start + BLOCK_WINDOWS, row * columns + nx)]
            if _max_of(block) < limit:
                continue
            for x in range(block.shape[0]):
                positions[count] = np.uint32(base + start + x)
                totals[count] = block[x]
                count += 1 if block[x] >= limit else 0
    t = dense
    while t < offsets.shape[0] and count > MAX_SINGLE_WINDOWS:
        count = _next_tree(flat, offsets[t], thresholds[t], leaves[t], rejection[t], positions, totals, count)
        t += 1
    return _other_trees(flat, offsets[t:], thresholds[t:], leaves[t:], rejection[t:], positions, totals, count)


@njit(cache=True, nogil=True, error_model="numpy")
def _scan(flat, columns, ny, nx, offsets, thresholds, leaves, rejection, dense):  # type: ignore[no-untyped-def]
    acc = np.empty(BAND_ROWS * columns, np.int16)
    positions = np.empty(BAND_ROWS * nx, np.uint32)
    totals = np.empty(BAND_ROWS * nx, np.int32)
    size = 1024
    out_y, out_x, out_s = np.empty(size, np.int32), np.empty(size, np.int32), np.empty(size, np.int32)
    found = 0
    for top in range(0, ny, BAND_ROWS):
        rows = min(BAND_ROWS, ny - top)
        count = _scan_band(
            flat, columns, nx, top, rows, offsets, thresholds, leaves, rejection, dense, acc, positions, totals
        )
        while found + count > size:
            size *= 2
            out_y, out_x, out_s = _extended(out_y, size), _extended(out_x, size), _extended(out_s, size)
        for i in range(count):
            out_y[found] = positions[i] // columns
            out_x[found] = positions[i] % columns
            out_s[found] = totals[i]
            found += 1
    return found, out_y, out_x, out_s


@njit(cache=True, nogil=True)
def _extended(array, size):  # type: ignore[no-untyped-def]
    out = np.empty(size, array.dtype)
    out[: array.shape[0]] = array
    return out
