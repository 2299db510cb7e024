"""Boxes of signs that the edge of the picture cuts."""

from __future__ import annotations

import numpy as np

from tsr_engine.protocols import WHOLE, Edges
from tsr_engine.records import FloatArray

__all__ = ["completed"]


def completed(box: FloatArray, expected: FloatArray, cut: Edges) -> tuple[FloatArray, Edges]:
    """A measured box, shape (4,), as far as what was seen of it tells the rest, and the edges that stay unknown.

    A side that one edge is missing of follows from the other side and the expected ratio of both, never shorter than
    seen. The missing edge itself is not put where it is expected: that would say that the sign grows as expected,
    whatever it does. Where both sides lack an edge nothing tells their lengths.
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
