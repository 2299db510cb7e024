"""HOTA, IDF1 and MOTA, computed by TrackEval, with our rules for ignored boxes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from benchmarks.boxes import share_inside
from benchmarks.peers.multi_object_trackers import load
from tsr_engine.geometry.boxes import iou
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import FloatArray
from tsr_engine.track_table import BoolArray, IntArray, TrackTable

NAMES = ("HOTA", "IDF1", "MOTA")

MIN_WIDTH = 20.0
"""Least width of a counted sign, px; narrower signs are neither missed nor false, as in our own coverage."""
MATCH = 0.5
"""Least IoU of a match, and least share of a box inside an ignored box for the box to be excused."""


def sequence(truth: TrackTable, results: TrackTable, frames: int) -> JsonObject:
    """One video in the input form of TrackEval's metrics.

    As in the preparation of the MOTChallenge, rows that match an ignored box better than a counted one are left out,
    and so are those that lie within an ignored box.

    Args:
        truth: annotated rows.
        results: tracked rows.
        frames: number of frames.
    """
    wanted = ~truth.ignore & (truth.boxes[:, 2] - truth.boxes[:, 0] >= MIN_WIDTH)
    signs = {int(s): i for i, s in enumerate(np.unique(truth.track[wanted]))}
    gt_ids, tracker_ids, similarity = [], [], []
    for frame in range(frames):
        here = np.flatnonzero(truth.frame == frame)
        rows = np.flatnonzero(results.frame == frame)
        counted = here[wanted[here]]
        rows = rows[~_excused(truth, here, wanted, results.boxes[rows])]
        gt_ids.append(np.array([signs[int(s)] for s in truth.track[counted]], dtype=int))
        tracker_ids.append(results.track[rows])
        similarity.append(iou(truth.boxes[counted], results.boxes[rows]))
    tracks = {int(t): i for i, t in enumerate(np.unique(np.concatenate([*tracker_ids, np.zeros(0, int)])))}
    tracker_ids = [np.array([tracks[int(t)] for t in ids], dtype=int) for ids in tracker_ids]
    return {
        "num_timesteps": frames,
        "num_gt_ids": len(signs),
        "num_tracker_ids": len(tracks),
        "num_gt_dets": sum(len(ids) for ids in gt_ids),
        "num_tracker_dets": sum(len(ids) for ids in tracker_ids),
        "gt_ids": gt_ids,
        "tracker_ids": tracker_ids,
        "similarity_scores": similarity,
    }


def trackeval_figures(sequences: Iterable[JsonObject], names: Sequence[str] = NAMES) -> dict[str, float]:
    """Figures over all videos together; each at most 1.

    Args:
        sequences: results of :func:`sequence`.
        names: some of ``HOTA`` (mean over all thresholds), ``IDF1`` and ``MOTA``.

    Raises:
        Missing: TrackEval is not installed.
    """
    metrics = load("trackeval").metrics
    videos = list(sequences)
    quiet = {"PRINT_CONFIG": False}
    made = {"HOTA": metrics.HOTA, "IDF1": lambda: metrics.Identity(quiet), "MOTA": lambda: metrics.CLEAR(quiet)}
    figures = {}
    for name in names:
        metric = made[name]()
        each = {str(i): metric.eval_sequence(video) for i, video in enumerate(videos)}
        figures[name] = float(np.mean(metric.combine_sequences(each)[name]))
    return figures


def _excused(truth: TrackTable, here: IntArray, wanted: BoolArray, boxes: FloatArray) -> BoolArray:
    """Whether each box of a frame is excused by an ignored box."""
    out = np.zeros(len(boxes), dtype=bool)
    if not len(boxes) or not len(here):
        return out
    overlap = iou(truth.boxes[here], boxes)
    gain = np.where(overlap >= MATCH, overlap, 0.0)
    taken = np.zeros(len(boxes), dtype=bool)
    for i, j in zip(*linear_sum_assignment(-gain), strict=True):
        if gain[i, j] > 0:
            taken[j] = True
            out[j] = not wanted[here[i]]
    ignored = here[truth.ignore[here]]
    if len(ignored):
        out |= ~taken & (share_inside(boxes, truth.boxes[ignored]) >= MATCH).any(axis=1)
    return out
