"""Boxes of signs that the edge of the picture cuts off."""

from __future__ import annotations

import numpy as np

from tsr_engine.protocols import NO_CUT_EDGES, Edges
from tsr_engine.records import FloatArray


def complete_box(box: FloatArray, expected: FloatArray, cut: Edges) -> tuple[FloatArray, Edges]:
    """Complete a measured box whose edges are partly cut off.

    If only width or only height lacks one edge, its length follows from the other side and the expected aspect ratio;
    it is never shorter than the visible part. The expected position of the edge is not used, since it would always
    confirm the expected growth. Other missing edges stay unknown and get their expected positions.

    Args:
        box: the visible part, shape (4,), px.
        expected: the expected box, shape (4,), px.
        cut: edges that are cut off.

    Returns:
        The completed box, shape (4,), and the edges that stay unknown.
    """
    truncated_axes = [axis for axis in (0, 1) if cut[axis] or cut[axis + 2]]
    if len(truncated_axes) != 1 or (cut[truncated_axes[0]] and cut[truncated_axes[0] + 2]):
        return np.where(cut, expected, box), cut
    axis = truncated_axes[0]
    visible_size, expected_size = box[2:] - box[:2], expected[2:] - expected[:2]
    side = max(float(visible_size[1 - axis] * expected_size[axis] / expected_size[1 - axis]), float(visible_size[axis]))
    complete = np.array(box, dtype=np.float64)
    if cut[axis]:
        complete[axis] = box[axis + 2] - side
    else:
        complete[axis + 2] = box[axis] + side
    return complete, NO_CUT_EDGES
