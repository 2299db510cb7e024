"""The detector's window: the place of the sign in it, and conversion between cells and picture coordinates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tsr_engine.channels.pyramid import Level
from tsr_engine.records import FloatArray


@dataclass(frozen=True, slots=True)
class Window:
    """A square window with the sign in its middle.

    Attributes:
        cells: side in cells.
        shrink: px a cell.
        sign: side of the sign inside, px.
        pad: border of each level in cells, so that signs at the picture's edge fit into a window. It is the border of
            training; a detector scans with one of its own, see :meth:`reaching`.
    """

    cells: int = 14
    shrink: int = 2
    sign: float = 24.0
    pad: int = 2

    @property
    def side(self) -> int:
        """Side of the window in px."""
        return self.cells * self.shrink

    @property
    def margin(self) -> float:
        """Px between the window's edge and the sign."""
        return (self.side - self.sign) / 2

    def reaching(self, share: float) -> Window:
        """The same window over levels with a border so wide that it also finds signs which the picture's edge cuts.

        Args:
            share: of the sign's side that may lie beyond the edge, >= 0.
        """
        return replace(self, pad=ceil((self.margin + share * self.sign) / self.shrink))

    def to_boxes(self, rows: ArrayLike, columns: ArrayLike, level: Level) -> FloatArray:
        """Sign boxes in picture px, shape (n, 4), of windows with their first cell at (row, column)."""
        x = ((np.asarray(columns, np.float64) - self.pad) * self.shrink + self.margin) / level.scale_x
        y = ((np.asarray(rows, np.float64) - self.pad) * self.shrink + self.margin) / level.scale_y + level.top
        boxes = np.empty((len(x), 4))
        boxes[:, 0], boxes[:, 1] = x, y
        boxes[:, 2], boxes[:, 3] = x + self.sign / level.scale_x, y + self.sign / level.scale_y
        return boxes

    def gather(self, rows: ArrayLike, columns: ArrayLike, level: Level) -> NDArray[np.uint8]:
        """Features of windows with the level's gains applied, shape (n, channels * cells * cells)."""
        view = np.lib.stride_tricks.sliding_window_view(level.cells, (self.cells, self.cells), axis=(1, 2))
        picked = level.corrected(view[:, np.asarray(rows, np.intp), np.asarray(columns, np.intp)])
        return np.ascontiguousarray(picked.transpose(1, 0, 2, 3)).reshape(len(picked[0]), -1)
