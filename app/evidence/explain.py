"""Explains one verdict of the gate: the matched mirror features, and both hashes bit by bit."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from app.body_model import Model
from app.evidence.overlays import MAX_NUMBER, json_number
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.protocols import PixelSource
from tsr_engine.records import FloatArray

Line = tuple[float, float, float, float]


class SymmetryView(Model):
    """The mirror axis and the pairs of features behind it, in px of the crop of the prediction."""

    axis: Line | None
    """Ends of the axis within the sign; None: no axis was found."""
    matches: list[tuple[float, float, float, float, float]]
    """``x1, y1, x2, y2, weight``; a feature on the axis matches itself."""
    magnitude: float
    size: tuple[int, int]
    """Width and height of the crop."""


class HashView(Model):
    """64 bits each, as 16 hexadecimal digits, first bit highest, row by row."""

    crop: str
    mean: str
    distance: int


class Explanation(Model):
    """The gate's data for one prediction."""

    symmetry: SymmetryView
    hash: HashView
    l_positive: float
    tau: float


def explain(
    reader: EvidenceReader, track_id: int, frame: int, pixels: Callable[[int], PixelSource]
) -> Explanation | None:
    """Compute the verdict on a stored prediction again; None: the gate did not judge it."""
    from tsr_engine.pipeline.gate_inspection import inspect_gate  # the engine is large: only this function loads it
    from tsr_engine.runs.replay import run_params

    params = run_params(reader)
    inspection = inspect_gate(reader, params, track_id, frame, pixels)
    if inspection is None:
        return None
    height, width = inspection.crop.shape[:2]
    left, top = inspection.border
    sign_size = (width - 2 * left, height - 2 * top)
    symmetry = inspection.symmetry
    pairs = symmetry.pairs + np.array([left, top, left, top])
    axis = _axis(symmetry.angle, symmetry.offset, *sign_size) if symmetry.magnitude > 0 else None
    return Explanation(
        symmetry=SymmetryView(
            axis=None if axis is None else (axis[0] + left, axis[1] + top, axis[2] + left, axis[3] + top),
            matches=_matches(pairs, symmetry.weights),
            magnitude=json_number(symmetry.magnitude),
            size=(width, height),
        ),
        hash=HashView(
            crop=f"{inspection.crop_hash:016x}",
            mean=f"{inspection.mean_hash:016x}",
            distance=int(inspection.verdict.hash_distance),
        ),
        l_positive=json_number(inspection.verdict.l_positive, MAX_NUMBER),
        tau=params.gate.tau,
    )


def _matches(pairs: FloatArray, weights: FloatArray) -> list[tuple[float, float, float, float, float]]:
    """Each pair once, although each of its features lists the other; the best last, so that it is drawn on top."""
    found: dict[frozenset[tuple[float, float]], tuple[float, float, float, float, float]] = {}
    for i in np.argsort(weights, kind="stable").tolist():
        a, b, c, d = (round(v, 2) for v in pairs[i].tolist())
        found.pop(frozenset(((a, b), (c, d))), None)
        found[frozenset(((a, b), (c, d)))] = (a, b, c, d, round(float(weights[i]), 4))
    return list(found.values())


def _axis(angle: float, offset: float, width: int, height: int) -> Line | None:
    """The part of the line ``(p - centre) . normal = offset`` within ``width`` x ``height``."""
    nx, ny = math.cos(angle), math.sin(angle)
    x0, y0 = (width - 1) / 2 + offset * nx, (height - 1) / 2 + offset * ny
    low, high = -math.inf, math.inf
    for start, step, end in ((x0, -ny, width), (y0, nx, height)):
        if abs(step) < 1e-9:
            if not 0 <= start <= end:
                return None
            continue
        a, b = sorted((-start / step, (end - start) / step))
        low, high = max(low, a), min(high, b)
    if low >= high:
        return None
    return (round(x0 - ny * low, 2), round(y0 + nx * low, 2), round(x0 - ny * high, 2), round(y0 + nx * high, 2))
