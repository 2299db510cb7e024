"""The fast feature pyramid: channels computed at few scales, approximated between them.

A channel resampled from scale ``s_r`` to ``s`` keeps its statistics when it is multiplied by ``(s / s_r) ** -lambda``
(Dollar et al. 2014, section 4). ``lambda`` is about 0 for colour and measured for gradients (``measure_lambdas`` in
:mod:`tsr_engine.training.public.power_law`). Approximated levels come from the nearest computed one, on a logarithmic
axis. Two differences from the toolbox save most of the work and are part of the trained detector. Channels are smoothed
once, before the approximation. The power law's factor does not multiply millions of cells; the scan divides the trees'
thresholds by ``Level.gains`` instead.

Pictures are halved (2 x 2 means) or resampled bilinearly by less than a factor of two. Each computed level below the
first octave is half as large as the level an octave above.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.compute import CHANNELS
from tsr_engine.channels.interleaving import deinterleave, interleave
from tsr_engine.channels.quantise import plane_bytes
from tsr_engine.channels.scratch import Scratch
from tsr_engine.channels.smooth import smooth
from tsr_engine.channels.upsample import is_three_halves, upsample
from tsr_engine.records import Picture

Band = tuple[float, float]
"""First and last picture row, px."""


@dataclass(frozen=True, slots=True)
class PyramidPlan:
    """Scales of a pyramid, and which of them are computed.

    Attributes:
        shrink: cell size in px.
        per_octave: scales per octave.
        computed_per_octave: scales per octave whose channels are computed from the picture.
        lambdas: exponents of the ten channels.

    Raises:
        ValueError: ``per_octave`` is not a multiple of ``computed_per_octave``.
    """

    shrink: int = 2
    per_octave: int = 8
    computed_per_octave: int = 1
    lambdas: tuple[float, ...] = (0.0,) * CHANNELS

    def __post_init__(self) -> None:
        if self.per_octave % self.computed_per_octave:
            raise ValueError(
                f"per_octave must be a multiple of computed_per_octave. Got {self.per_octave} and "
                f"{self.computed_per_octave} instead."
            )

    def computed_groups(self, count: int) -> Iterator[tuple[int, list[int]]]:
        """Index of each computed scale, with the indices of all scales nearest to it.

        Ties go to the finer computed scale, which holds more detail.

        Args:
            count: number of scales.
        """
        step = self.per_octave // self.computed_per_octave
        last = (count - 1) // step * step
        for computed in range(0, last + 1, step):
            low = computed - (step - 1) // 2
            high = computed + step // 2 if computed < last else count - 1
            yield computed, list(range(max(0, low), min(high, count - 1) + 1))


@dataclass(frozen=True, slots=True)
class Level:
    """One scale of a pyramid: smoothed bytes of ten channels, and their place in the picture."""

    index: int
    """Scale = first scale * 2 ** (-index / per_octave)."""
    cells: NDArray[np.uint8]
    """Shape (10, rows + 2 border, columns + 2 border), borders replicated."""
    scale_x: float
    """Level px (cells times ``shrink``) per picture px, along x."""
    scale_y: float
    top: float
    """Picture row of the cells' upper edge, px; greater than 0 if the level covers only a band of the picture."""
    computed: bool
    """Whether the level is computed from the picture; otherwise it is approximated."""
    gains: NDArray[np.float64]
    """Shape (10,): factor by which the power law corrects each channel; 1 for computed levels."""

    def with_gains(self, cells: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Cells, shape (10, ...), multiplied by the gains, rounded down and clipped.

        A comparison of these with a whole threshold ``t`` equals one of ``cells`` with ``ceil(t / gain)``.
        """
        shape = (-1,) + (1,) * (cells.ndim - 1)
        return np.asarray(np.minimum(np.floor(cells * self.gains.reshape(shape) + 1e-9), 255), dtype=np.uint8)


def level_scales(top: float, bottom: float, per_octave: int) -> NDArray[np.float64]:
    """Scales ``top * 2 ** (-i / per_octave)`` down to at least ``bottom``, descending."""
    count = int(np.floor(per_octave * np.log2(top / bottom) + 1e-9)) + 1 if bottom <= top else 0
    return np.asarray(top * 2.0 ** (-np.arange(count) / per_octave))


def build_pyramid(
    picture: Picture,
    scales: Sequence[float] | NDArray[np.float64],
    plan: PyramidPlan,
    bands: Sequence[Band | None] | None = None,
    part: int = 0,
    parts: int = 1,
    border: int = 0,
    scratch: Scratch | None = None,
) -> Iterator[Level]:
    """Yield the levels of a picture's pyramid, largest first, each made on demand.

    Args:
        picture: BGR uint8.
        scales: descending scales of :func:`level_scales`; the first and every ``per_octave // computed_per_octave``-th
            after it are computed.
        plan: the pyramid's scales.
        bands: rows that each scale needs, or None to leave out the level; unset: all rows of all levels. A computed
            level covers the bands of all levels that are approximated from it.
        part: part of the work to do, in ``range(parts)``.
        parts: number of parts, for several cores. Each of the largest computed levels is one part, with the levels
            approximated from it; all others are the last part.
        border: replicated cells around each level.
        scratch: working memory; the next level then overwrites a level's cells. Unset: each level owns its cells.
    """
    lambdas = np.asarray(plan.lambdas)
    pictures = _ResizedPictures(picture, float(scales[0]) if len(scales) else 1.0, scratch or Scratch())
    rows_needed: Sequence[Band | None] = [(0.0, float(picture.shape[0]))] * len(scales) if bands is None else bands
    for number, (computed, members) in enumerate(plan.computed_groups(len(scales))):
        needed = {i: band for i in members if (band := rows_needed[i]) is not None}
        if min(number, parts - 1) != part or not needed:
            continue
        band = (min(b[0] for b in needed.values()), max(b[1] for b in needed.values()))
        source = _compute_level(pictures, computed, float(scales[computed]), plan, band, border, scratch or Scratch())
        if source is None:
            return
        height, width = source.cells.shape[1] - 2 * border, source.cells.shape[2] - 2 * border
        packed = interleave(source.cells, border, scratch) if len(needed) > 1 else []
        for index in needed:
            if index == computed:
                yield source
                continue
            ratio = float(scales[index] / scales[computed])
            rows, columns = int(height * ratio), int(width * ratio)
            if min(rows, columns) < 1:
                continue
            # Coordinates need the exact ratio of the two grids, not that of the scales.
            yield Level(
                index,
                resample(packed, rows, columns, border, scratch),
                source.scale_x * columns / width,
                source.scale_y * rows / height,
                source.top,
                False,
                ratio**-lambdas,
            )


class _ResizedPictures:
    """A picture's planes (3, h, w), resized; below the first octave each size is half of the size an octave above.

    Every part of the work does the same, even if it needs a larger size only to halve it. So all parts get the same
    pictures.
    """

    def __init__(self, picture: Picture, top: float, scratch: Scratch) -> None:
        self._scratch, self._top = scratch, top
        self.height, self.width = picture.shape[:2]
        self._planes = scratch.array("planes", (3, self.height, self.width), np.uint8)
        cv2.split(picture, list(self._planes))
        self._by_scale: dict[float, NDArray[np.uint8]] = {}

    def at(self, scale: float) -> NDArray[np.uint8]:
        """The planes at a scale; sizes are rounded down."""
        cached = next((p for s, p in self._by_scale.items() if abs(s / scale - 1.0) < 1e-6), None)
        if cached is not None:
            return cached
        if 2.0 * scale <= self._top * (1.0 + 1e-6):
            resized = self._half(self.at(2.0 * scale), scale)
        else:
            base, halved_scale = self._planes, 0.5
            while scale <= halved_scale + 1e-9:
                base, halved_scale = self._half(base, halved_scale), halved_scale / 2
            size = (int(self.width * scale), int(self.height * scale))
            resized = base
            if size != (base.shape[2], base.shape[1]):
                resized = self._buffer(scale, size)
                if is_three_halves(base, size):
                    half = self._by_scale[scale / 2] = self._buffer(scale / 2, (size[0] // 2, size[1] // 2))
                    upsample(base, resized, half)
                else:
                    for source, target in zip(base, resized, strict=True):
                        cv2.resize(source, size, dst=target)
        self._by_scale = {s: p for s, p in self._by_scale.items() if s < 4 * scale}
        self._by_scale[scale] = resized
        return resized

    def _half(self, planes: NDArray[np.uint8], scale: float) -> NDArray[np.uint8]:
        """Means of 2 x 2 px."""
        h, w = planes.shape[1] // 2, planes.shape[2] // 2
        halved = self._buffer(scale, (w, h))
        for source, target in zip(planes, halved, strict=True):
            cv2.resize(source[: 2 * h, : 2 * w], (w, h), dst=target, interpolation=cv2.INTER_AREA)
        return halved

    def _buffer(self, scale: float, size: tuple[int, int]) -> NDArray[np.uint8]:
        return self._scratch.array(f"planes at {scale:.6f}", (3, size[1], size[0]), np.uint8)


def _compute_level(
    pictures: _ResizedPictures,
    index: int,
    scale: float,
    plan: PyramidPlan,
    band: Band,
    border: int,
    scratch: Scratch,
) -> Level | None:
    """A level computed from the picture; None if it would be empty."""
    cell = plan.shrink
    if min(pictures.height * scale, pictures.width * scale) < cell:
        return None
    planes = pictures.at(scale)
    rows, columns = planes.shape[1:]
    scale_x, scale_y = columns / pictures.width, rows / pictures.height
    # Whole cells, with a margin of four for the filters.
    first = max(0, int(band[0] * scale_y) // cell * cell - 4 * cell)
    last = min(rows, int(np.ceil(band[1] * scale_y / cell)) * cell + 4 * cell)
    if last - first < cell:
        return None
    shape = (CHANNELS, (last - first) // cell, columns // cell)
    unsmoothed = plane_bytes(planes[:, first:last], cell, scratch.array("rough", shape, np.uint8))
    bordered = (CHANNELS, shape[1] + 2 * border, shape[2] + 2 * border)
    cells = smooth(unsmoothed, border, scratch.array("computed", bordered, np.uint8))
    return Level(index, cells, scale_x, scale_y, first / scale_y, True, np.ones(CHANNELS))


def resample(
    interleaved: Sequence[NDArray[np.uint8]], rows: int, columns: int, border: int = 0, scratch: Scratch | None = None
) -> NDArray[np.uint8]:
    """Resample channels bilinearly.

    Args:
        interleaved: arrays of :func:`interleaving.interleave`.
        rows: number of rows of the result.
        columns: number of columns of the result.
        border: replicated cells around the result.
        scratch: memory for the result; unset: new memory.

    Returns:
        Shape (channels, rows + 2 border, columns + 2 border), uint8, with the bits of each channel resampled alone.
    """
    scratch = scratch or Scratch()
    shape = (sum(part.shape[2] for part in interleaved), rows + 2 * border, columns + 2 * border)
    out = scratch.array("resampled", shape, np.uint8)
    buffer = scratch.array("resampled, interleaved", (shape[0] * rows * columns,), np.uint8)
    first = 0
    for part in interleaved:
        last = first + rows * columns * part.shape[2]
        target = buffer[first:last].reshape(rows, columns, part.shape[2])
        cv2.resize(part, (columns, rows), dst=target, interpolation=cv2.INTER_LINEAR)
        first = last
    deinterleave(buffer, out, border)
    return out
