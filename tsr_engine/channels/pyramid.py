"""The fast feature pyramid: channels computed at few scales, approximated between them.

A channel resampled from scale ``s_r`` to ``s`` keeps its statistics when it is multiplied by
``(s / s_r) ** -lambda`` (Dollar et al. 2014, section 4). ``lambda`` is about 0 for colour and measured for gradients
(:func:`tsr_engine.training.lambdas.measure_lambdas`). Approximated levels come from the nearest computed one, on a
logarithmic axis. Two departures from the toolbox save most of the work and are part of the trained detector: channels
are smoothed once, before the approximation; and the power law's factor is not multiplied into millions of cells but
handed on as ``Level.gains``, by which the scan divides the trees' thresholds.

Pictures are only ever halved (2 x 2 means) or resampled bilinearly by less than a factor of two: each computed level
below the first octave is the half of the one an octave above.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.compute import CHANNELS
from tsr_engine.channels.quantise import channel_bytes
from tsr_engine.records import Picture


@dataclass(frozen=True, slots=True)
class PyramidPlan:
    """Which scales are searched and which of them are computed.

    Attributes:
        shrink: cell size in px.
        per_octave: scales per octave.
        computed_per_octave: scales per octave whose channels are computed from the picture.
        lambdas: exponents of the ten channels.
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


@dataclass(frozen=True, slots=True)
class Level:
    """One scale of a pyramid: smoothed bytes of ten channels and how to get back to picture coordinates."""

    index: int
    """Scale = first scale * 2 ** (-index / per_octave)."""
    cells: NDArray[np.uint8]
    """Shape (10, rows + 2 border, columns + 2 border), the border replicated."""
    scale_x: float
    """Cells times shrink per picture px, along x."""
    scale_y: float
    top: float
    """Picture row, px, of the cells' upper edge: greater than 0 when only a band of the picture was asked for."""
    computed: bool
    """Computed from the picture; otherwise approximated."""
    gains: NDArray[np.float64]
    """Shape (10,): factor by which the power law corrects each channel; 1 for computed levels."""

    def corrected(self, cells: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Cells, shape (10, ...), with the gains applied, rounded down and clipped.

        Comparing these with a whole threshold ``t`` equals comparing the cells with ``ceil(t / gain)``.
        """
        shape = (-1,) + (1,) * (cells.ndim - 1)
        return np.asarray(np.minimum(np.floor(cells * self.gains.reshape(shape) + 1e-9), 255), dtype=np.uint8)


def level_scales(top: float, bottom: float, per_octave: int) -> NDArray[np.float64]:
    """Scales ``top * 2 ** (-i / per_octave)`` down to at least ``bottom``, descending."""
    count = int(np.floor(per_octave * np.log2(top / bottom) + 1e-9)) + 1 if bottom <= top else 0
    return np.asarray(top * 2.0 ** (-np.arange(count) / per_octave))


def smooth(cells: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """[1 2 1]/4 along both axes of every channel, borders replicated; same shape."""
    out = np.empty_like(cells)
    for c in range(len(cells)):
        cv2.GaussianBlur(cells[c], (3, 3), 0, dst=out[c], borderType=cv2.BORDER_REPLICATE)
    return out


def build_pyramid(
    picture: Picture,
    scales: Sequence[float] | NDArray[np.float64],
    plan: PyramidPlan,
    bands: Sequence[tuple[float, float]] | None = None,
    chain: int = 0,
    chains: int = 1,
    border: int = 0,
) -> Iterator[Level]:
    """The levels of a picture's pyramid, largest first; each is made when it is asked for.

    Args:
        picture: BGR uint8.
        scales: descending scales as of :func:`level_scales`; every ``per_octave // computed_per_octave``-th is
            computed, from the first on.
        plan: see :class:`PyramidPlan`.
        bands: per scale the first and last picture row, px, that is needed; unset: all rows. A computed level covers
            the bands of all levels that are approximated from it.
        chain: which part of the work is wanted when several cores share it.
        border: replicated cells around each level.
        chains: number of parts: computed levels are dealt out in turn, each with the levels approximated from it.
    """
    ones = np.ones(CHANNELS)
    lambdas = np.asarray(plan.lambdas)
    step = plan.per_octave // plan.computed_per_octave
    pictures = _Halves(picture)
    source: tuple[int, NDArray[np.uint8], float, float, float] | None = None
    for number, (near, members) in enumerate(_families(len(scales), step)):
        if number % chains != chain:
            continue
        band = (0.0, float(picture.shape[0]))
        if bands is not None:
            band = (min(bands[i][0] for i in members), max(bands[i][1] for i in members))
        source = _computed(pictures, near, float(scales[near]), plan, band)
        if source is None:
            return
        _, cells, scale_x, scale_y, top = source
        for index in members:
            if index == near:
                yield Level(index, bordered(cells, border), scale_x, scale_y, top, True, ones)
                continue
            ratio = float(scales[index] / scales[near])
            rows, columns = int(cells.shape[1] * ratio), int(cells.shape[2] * ratio)
            if min(rows, columns) < 1:
                continue
            # the exact ratio of the two grids, not the wanted one, leads back to the picture
            yield Level(
                index,
                resample(cells, rows, columns, border),
                scale_x * columns / cells.shape[2],
                scale_y * rows / cells.shape[1],
                top,
                False,
                ratio**-lambdas,
            )


def _families(count: int, step: int) -> Iterator[tuple[int, list[int]]]:
    """Computed levels with all levels that are nearest to them; ties go to the finer one, which holds more detail."""
    last = (count - 1) // step * step
    for near in range(0, last + 1, step):
        low = near - (step - 1) // 2
        high = near + step // 2 if near < last else count - 1
        yield near, list(range(max(0, low), min(high, count - 1) + 1))


class _Halves:
    """Resized pictures; a size an octave below one that was made is the half of it."""

    def __init__(self, picture: Picture) -> None:
        self._picture = picture
        self._made: dict[float, Picture] = {}

    @property
    def original(self) -> Picture:
        """The picture at scale 1."""
        return self._picture

    def at(self, scale: float) -> Picture:
        """The picture at a scale; sizes are rounded down."""
        if scale in self._made:
            return self._made[scale]
        double = next((p for s, p in self._made.items() if abs(s / scale - 2.0) < 1e-6), None)
        if double is not None:
            h, w = double.shape[0] // 2, double.shape[1] // 2
            made = cv2.resize(double[: 2 * h, : 2 * w], (w, h), interpolation=cv2.INTER_AREA)
        else:
            base = self._picture
            while scale <= 0.5 * base.shape[1] / self._picture.shape[1] + 1e-9:
                h, w = base.shape[0] // 2, base.shape[1] // 2
                base = np.asarray(
                    cv2.resize(base[: 2 * h, : 2 * w], (w, h), interpolation=cv2.INTER_AREA), dtype=np.uint8
                )
            size = (int(self._picture.shape[1] * scale), int(self._picture.shape[0] * scale))
            made = base if size == (base.shape[1], base.shape[0]) else cv2.resize(base, size)
        self._made = {s: p for s, p in self._made.items() if s < 4 * scale}
        self._made[scale] = np.asarray(made, dtype=np.uint8)
        return self._made[scale]


def _computed(
    pictures: _Halves, index: int, scale: float, plan: PyramidPlan, band: tuple[float, float]
) -> tuple[int, NDArray[np.uint8], float, float, float] | None:
    """Index, smoothed bytes, true scales and upper edge of a computed level; None if it would be empty."""
    original = pictures.original
    cell = plan.shrink
    if min(original.shape[0] * scale, original.shape[1] * scale) < cell:
        return None
    resized = pictures.at(scale)
    scale_x, scale_y = resized.shape[1] / original.shape[1], resized.shape[0] / original.shape[0]
    # whole cells, with room for the filters' support
    first = max(0, int(band[0] * scale_y) // cell * cell - 4 * cell)
    last = min(resized.shape[0], int(np.ceil(band[1] * scale_y / cell)) * cell + 4 * cell)
    if last - first < cell:
        return None
    cells = smooth(channel_bytes(np.ascontiguousarray(resized[first:last]), cell))
    return index, cells, scale_x, scale_y, first / scale_y


def resample(cells: NDArray[np.uint8], rows: int, columns: int, border: int = 0) -> NDArray[np.uint8]:
    """Channels (10, h, w) resampled bilinearly to (10, rows, columns), with a replicated border around."""
    out = np.empty((len(cells), rows + 2 * border, columns + 2 * border), np.uint8)
    for c in range(len(cells)):
        inner = out[c, border : border + rows, border : border + columns]
        cv2.resize(cells[c], (columns, rows), dst=inner, interpolation=cv2.INTER_LINEAR)
    _replicate(out, border)
    return out


def bordered(cells: NDArray[np.uint8], border: int) -> NDArray[np.uint8]:
    """Channels (10, h, w) with ``border`` replicated cells on every side."""
    if not border:
        return cells
    channels, rows, columns = cells.shape
    out = np.empty((channels, rows + 2 * border, columns + 2 * border), np.uint8)
    out[:, border:-border, border:-border] = cells
    _replicate(out, border)
    return out


def _replicate(cells: NDArray[np.uint8], border: int) -> None:
    """Fills the border from the inner cells, in place."""
    if border:
        cells[:, :border] = cells[:, border : border + 1]
        cells[:, -border:] = cells[:, -border - 1 : -border]
        cells[:, :, :border] = cells[:, :, border : border + 1]
        cells[:, :, -border:] = cells[:, :, -border - 1 : -border]
