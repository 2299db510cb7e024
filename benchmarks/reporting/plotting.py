"""Draws figures as SVG in one style; equal numbers give equal bytes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tsr_engine.json_shapes import JsonMapping

__all__ = ["COLOURS", "draw_precision_recall", "legend_below", "saved_figure"]

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Palette of Okabe and Ito, which people with colour blindness can distinguish."""


@contextmanager
# Any: one Axes, or an array of them
def saved_figure(path: Path, across: int = 1, size: tuple[float, float] = (6.4, 3.6)) -> Iterator[Any]:
    """Axes, or a list of them if ``across`` is above 1; the figure is saved at the end of the block."""
    with mpl.rc_context({"svg.hashsalt": "tsr", "axes.prop_cycle": cycler(color=COLOURS), "font.size": 9}):
        figure = Figure(figsize=(size[0] * across, size[1]), layout="constrained")
        axes = figure.subplots(1, across)
        yield axes
        figure.savefig(path, format="svg", metadata={"Date": None})


def legend_below(axes: Axes, columns: int = 4) -> None:
    """One legend for a whole figure, below its axes.

    Args:
        axes: axes whose lines and bars the legend names; neighbouring axes have the same styles.
        columns: number of columns of the legend.
    """
    axes.figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=columns, fontsize=7)


def draw_precision_recall(path: Path, curves: Mapping[str, JsonMapping], styles: Mapping[str, str]) -> None:
    """Curves with their average precision, in the order of ``styles``.

    Args:
        path: the SVG file.
        curves: name -> ``recall``, ``precision`` and ``ap``.
        styles: name -> Matplotlib's line style.
    """
    with saved_figure(path) as axes:
        for name, style in styles.items():
            f = curves[name]
            axes.plot(f["recall"], f["precision"], style, label=f"{name} (AP {f['ap']:.3f})")
        axes.set(xlabel="recall", ylabel="precision", xlim=(0, 1.005), ylim=(0, 1.02))
        axes.legend(loc="lower left")
