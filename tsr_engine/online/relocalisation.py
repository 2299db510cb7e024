"""Searches for the sign around a prediction with the online detector (Algorithm 2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsr_engine.geometry.boxes import to_cxcywh
from tsr_engine.online.features import (
    CELLS,
    PAD,
    WindowGrid,
    cell_maps,
    check_box,
    make_grid,
    pixel_extent,
    score_windows,
)
from tsr_engine.online.incremental_svm import IncrementalSVC
from tsr_engine.params.online import OnlineParams
from tsr_engine.protocols import PixelSource
from tsr_engine.records import FloatArray, Relocalisation

_NEIGHBOUR_WINDOWS = 3
"""Number of windows on each side of the peak to score at the other sizes."""
_MIN_RUNNER_UP_DISTANCE = 0.5
"""Least distance of the runner-up's centre from the peak, in sides of the box."""


def search_extent(box: FloatArray, params: OnlineParams) -> tuple[int, int, int, int]:
    """The bounds ``x1, y1, x2, y2`` of the pixels that :func:`relocalise` reads; they may reach beyond the frame.

    They grow with ``search_radius`` and ``search_scales``, so the largest values of a replay cover all others.

    Raises:
        ValueError: the box is not finite or smaller than 1x1 px.
    """
    check_box(box)
    extents = np.array([grid.extent for grid in _grids(box, params)])
    return pixel_extent(np.concatenate([extents[:, :2].min(axis=0), extents[:, 2:].max(axis=0)]))


def relocalise(pixels: PixelSource, box: FloatArray, svm: IncrementalSVC, params: OnlineParams) -> Relocalisation:
    """Search the windows within ``search_radius`` of a predicted box (Algorithm 2).

    ``P(y = 1)`` is the logistic of the decision value, so the result is the window with the highest decision value,
    minus ``search_penalty`` for its displacement. All windows of the size nearest to the predicted one are scored. At
    the other ``search_scales``, only windows near the first peak are scored.

    Args:
        pixels: the frame; only the crop of :func:`search_extent` is read.
        box: the prediction, shape (4,), px.
        svm: linear model of descriptors.
        params: radius, sizes and penalty of the search.

    Raises:
        ValueError: the box is not finite or smaller than 1x1 px.
    """
    x1, y1, x2, y2 = search_extent(box, params)
    picture = pixels.crop(x1, y1, x2, y2)
    weights = np.ascontiguousarray(svm.coef_.reshape(-1, CELLS, CELLS), dtype=np.float32)
    centre = to_cxcywh(box)[:2]
    first_grid, *others = _grids(box, params)
    responses: list[_Response] = []
    for full_grid in (first_grid, *others):
        grid = full_grid if not responses else _grid_near_peak(full_grid, centre, responses[0].peak_centre(), params)
        values = np.empty((2 * grid.reach[1] + 1, 2 * grid.reach[0] + 1), dtype=np.float32)
        score_windows(cell_maps(picture, (x1, y1), grid), weights, svm.intercept_, PAD, values)
        responses.append(_Response(grid, values, values - _penalty(grid, centre, params)))
    best = max(responses, key=lambda response: float(response.score.max()))
    row, column = best.peak()
    peak = _refine_peak(best.score, row, column) if params.search_subpixel else (float(column), float(row))
    found_box = best.grid.box(*peak)
    decision = float(best.values[row, column])
    runner_up_box, runner_up = _runner_up(responses, found_box)
    return Relocalisation(
        search_box=_enclosing_box([response.grid for response in responses]),
        box=found_box,
        decision=decision,
        probability=_logistic(decision),
        runner_up_box=runner_up_box,
        runner_up_decision=runner_up,
        windows=sum(response.values.size for response in responses),
    )


@dataclass(frozen=True, slots=True)
class _Response:
    """Decision values of one window size, without and with the penalty."""

    grid: WindowGrid
    values: NDArray[np.float32]
    score: NDArray[np.float32]

    def peak(self) -> tuple[int, int]:
        row, column = np.unravel_index(int(self.score.argmax()), self.score.shape)
        return int(row), int(column)

    def peak_centre(self) -> FloatArray:
        row, column = self.peak()
        return to_cxcywh(self.grid.box(float(column), float(row)))[:2]


def _grids(box: FloatArray, params: OnlineParams) -> list[WindowGrid]:
    """The windows of each size, the size nearest to the predicted one first."""
    scales = sorted(params.search_scales, key=lambda scale: abs(math.log(scale)))
    return [make_grid(box, params.search_radius, scale) for scale in scales]


def _grid_near_peak(grid: WindowGrid, centre: FloatArray, peak: FloatArray, params: OnlineParams) -> WindowGrid:
    """The windows of another size near the first peak, all within the search radius."""
    across, down = (min(_NEIGHBOUR_WINDOWS, reach) for reach in grid.reach)
    limit = params.search_radius - np.array([across, down]) * grid.pitch
    return WindowGrid(centre + np.clip(peak - centre, -limit, limit), grid.pitch, (across, down))


def _axes(grid: WindowGrid) -> tuple[FloatArray, FloatArray]:
    """Displacement of the window centres in frame px, across and down."""
    across = (np.arange(2 * grid.reach[0] + 1) - grid.reach[0]) * grid.pitch[0]
    down = (np.arange(2 * grid.reach[1] + 1) - grid.reach[1]) * grid.pitch[1]
    return across, down


def _penalty(grid: WindowGrid, centre: FloatArray, params: OnlineParams) -> NDArray[np.float32]:
    across, down = _axes(grid)
    across, down = across + (grid.centre[0] - centre[0]), down + (grid.centre[1] - centre[1])
    squares = (across**2)[None, :] + (down**2)[:, None]
    return np.asarray(params.search_penalty / params.search_radius**2 * squares, dtype=np.float32)


def _refine_peak(score: NDArray[np.float32], row: int, column: int) -> tuple[float, float]:
    """Column and row of the peak, refined by parabolas through its neighbours."""
    return column + parabola_peak(score[row], column), row + parabola_peak(score[:, column], row)


def parabola_peak(values: NDArray[np.float32], index: int) -> float:
    """Peak of the parabola through ``values[index]`` and its neighbours, relative to ``index``, in [-0.5, 0.5]."""
    if not 0 < index < len(values) - 1:
        return 0.0
    before, centre, after = (float(v) for v in values[index - 1 : index + 2])
    curvature = before - 2.0 * centre + after
    return 0.0 if curvature >= 0.0 else min(0.5, max(-0.5, 0.5 * (before - after) / curvature))


def _runner_up(responses: list[_Response], peak: FloatArray) -> tuple[FloatArray, float]:
    """The best window outside the peak's neighbourhood; the peak's box if all windows are near it."""
    cx, cy, w, h = to_cxcywh(peak)
    best, result = -math.inf, (peak, -math.inf)
    for response in responses:
        grid = response.grid
        across, down = _axes(grid)
        near_x = np.abs(across + grid.centre[0] - cx) <= _MIN_RUNNER_UP_DISTANCE * w
        near_y = np.abs(down + grid.centre[1] - cy) <= _MIN_RUNNER_UP_DISTANCE * h
        outside = np.where(near_y[:, None] & near_x[None, :], -np.inf, response.score)
        row, column = np.unravel_index(int(outside.argmax()), outside.shape)
        if outside[row, column] > best:
            best = float(outside[row, column])
            result = (grid.box(float(column), float(row)), float(response.values[row, column]))
    if math.isinf(result[1]):
        return peak, float(min(response.values.min() for response in responses))
    return result


def _enclosing_box(grids: list[WindowGrid]) -> FloatArray:
    """The smallest box around all scored windows."""
    boxes = np.array(
        [b for grid in grids for b in (grid.box(0.0, 0.0), grid.box(2.0 * grid.reach[0], 2.0 * grid.reach[1]))]
    )
    return np.concatenate([boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)])


def _logistic(value: float) -> float:
    return 1.0 / (1.0 + math.exp(-value)) if value >= 0 else 1.0 - 1.0 / (1.0 + math.exp(value))
