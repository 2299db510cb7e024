"""Boxes of signs that the edge of the picture cuts off."""

from __future__ import annotations

import numpy as np

from tsr_engine.protocols import WHOLE, Edges
from tsr_engine.records import FloatArray

__all__ = ["completed"]


def completed(box: FloatArray, expected: FloatArray, cut: Edges) -> tuple[FloatArray, Edges]:
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
    lacking = [axis for axis in (0, 1) if cut[axis] or cut[axis + 2]]
    if len(lacking) != 1 or (cut[lacking[0]] and cut[lacking[0] + 2]):
        return np.where(cut, expected, box), cut
    axis = lacking[0]
    seen, usual = box[2:] - box[:2], expected[2:] - expected[:2]
    side = max(float(seen[1 - axis] * usual[axis] / usual[1 - axis]), float(seen[axis]))
    whole = np.array(box, dtype=np.float64)
    if cut[axis]:
        whole[axis] = box[axis + 2] - side
    else:
        whole[axis + 2] = box[axis] + side
    return whole, WHOLE
