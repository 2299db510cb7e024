"""Figures as SVG, all of one look and the same bytes from the same numbers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

__all__ = ["COLOURS", "drawing"]

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito: told apart by people who see fewer colours."""


@contextmanager
def drawing(path: Path, across: int = 1, size: tuple[float, float] = (6.4, 3.6)) -> Iterator[Any]:
    """Axes that are saved at the end; a list of them where there is more than one."""
    with mpl.rc_context({"svg.hashsalt": "tsr", "axes.prop_cycle": mpl.cycler(color=COLOURS), "font.size": 9}):
        figure = Figure(figsize=(size[0] * across, size[1]), layout="constrained")
        axes = figure.subplots(1, across)
        yield axes
        figure.savefig(path, format="svg", metadata={"Date": None})
