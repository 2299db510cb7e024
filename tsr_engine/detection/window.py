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
        shrink: side of a cell, px.
        sign: side of the sign in the window, px.
        pad: border of each level in cells, so that signs at the picture's edge fit into a window. This is the border of
            training; a detector scans with a wider one, see :meth:`reaching`.
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
        """Distance between the window's edge and the sign, px."""
        return (self.side - self.sign) / 2

    def reaching(self, share: float) -> Window:
        """The window with a border so wide that signs cut off by the picture's edge are found, too.

        Args:
            share: share of the sign's side that may lie beyond the edge, >= 0.
        """
        return replace(self, pad=ceil((self.margin + share * self.sign) / self.shrink))

    def to_boxes(self, rows: ArrayLike, columns: ArrayLike, level: Level) -> FloatArray:
        """Boxes (n, 4), px of the picture, of the signs in windows whose first cells lie at (row, column)."""
        x = ((np.asarray(columns, np.float64) - self.pad) * self.shrink + self.margin) / level.scale_x
        y = ((np.asarray(rows, np.float64) - self.pad) * self.shrink + self.margin) / level.scale_y + level.top
        boxes = np.empty((len(x), 4))
        boxes[:, 0], boxes[:, 1] = x, y
        boxes[:, 2], boxes[:, 3] = x + self.sign / level.scale_x, y + self.sign / level.scale_y
        return boxes

    def gather(self, rows: ArrayLike, columns: ArrayLike, level: Level) -> NDArray[np.uint8]:
        """Features of windows, shape (n, channels * cells * cells), with the level's gains applied."""
        view = np.lib.stride_tricks.sliding_window_view(level.cells, (self.cells, self.cells), axis=(1, 2))
        picked = level.with_gains(view[:, np.asarray(rows, np.intp), np.asarray(columns, np.intp)])
        return np.ascontiguousarray(picked.transpose(1, 0, 2, 3)).reshape(len(picked[0]), -1)
