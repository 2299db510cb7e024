"""Reduces dense tracks to key frames, and restores them by linear interpolation.

Labelling tools interpolate linearly between key frames. ``key_frames`` finds the fewest frames of a track between
which straight lines stay close to every edge of every box; ``interpolate`` draws those lines.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tsr_engine.exchange.dataset import Track

MAX_KEY_DISTANCE = 1000
"""Largest distance between key frames, in frames; keeps the search linear in the length of the track."""


def run_bounds(frames: NDArray[np.int64]) -> NDArray[np.int64]:
    """Bounds of the runs of consecutive frames: indices ``[0, ..., n]``, shape (runs + 1,)."""
    if not len(frames):
        return np.zeros(1, dtype=np.int64)
    breaks = np.flatnonzero(np.diff(frames) != 1) + 1
    return np.concatenate(([0], breaks, [len(frames)])).astype(np.int64)


def key_frames(track: Track, thin_px: float, *, rounding: float = 0.0) -> NDArray[np.bool_]:
    """Choose the frames of a track to write, so that interpolation restores the others.

    Always kept are key frames of the track, the first and last frame of each run, and frames in which label,
    attributes, occlusion or ignoring change, since tools hold these until the next key frame. Between them it keeps the
    fewest frames such that each edge of each box is within ``thin_px`` of the line, at most ``MAX_KEY_DISTANCE`` frames
    apart.

    Args:
        track: may have gaps.
        thin_px: largest distance of an interpolated edge from the true one, px; 0 or less: keep every frame.
        rounding: largest rounding error of the writer, px; subtracted from ``thin_px``.

    Returns:
        Shape (n,), True for frames to write as key frames.
    """
    count = len(track.frames)
    tolerance_px = thin_px - rounding
    if thin_px <= 0 or tolerance_px <= 0 or count <= 1:
        return np.ones(count, dtype=np.bool_)
    forced = track.key.copy()
    bounds = run_bounds(track.frames)
    forced[bounds[:-1]] = True
    forced[bounds[1:] - 1] = True
    for values in (track.occluded, track.labels, track.ignore, *track.changing.values()):
        if values is not None:
            forced[1:] |= values[1:] != values[:-1]
    if forced.all():
        return forced
    # This import takes a second and 54 MB for the compiler, so it waits until a track is thinned.
    from tsr_engine.exchange.fewest_key_frames import fewest_key_frames

    chosen: NDArray[np.bool_] = fewest_key_frames(
        np.ascontiguousarray(track.frames), np.ascontiguousarray(track.boxes), forced, tolerance_px, MAX_KEY_DISTANCE
    )
    return chosen


def interpolate(
    frames: NDArray[np.int64], boxes: NDArray[np.float64], wanted: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Boxes on the straight lines between key frames; before the first and after the last, the box stands still.

    Args:
        frames: key frames, strictly ascending, shape (k,), k >= 1.
        boxes: shape (k, 4), px.
        wanted: shape (m,).

    Returns:
        Shape (m, 4), px.
    """
    out = np.empty((len(wanted), 4))
    for edge in range(4):
        out[:, edge] = np.interp(wanted, frames, boxes[:, edge])
    return out
