"""Draws figures as SVG in one style; equal numbers give equal bytes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.reporting.markdown import number
from tsr_engine.json_shapes import JsonMapping

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Palette of Okabe and Ito, which people with colour blindness can distinguish."""


@contextmanager
def saved_figures(path: Path, across: int, size: tuple[float, float]) -> Iterator[list[Axes]]:
    """Axes of ``size`` inches beside each other; the figure is saved at the end of the block."""
    with mpl.rc_context({"svg.hashsalt": "tsr", "axes.prop_cycle": cycler(color=COLOURS), "font.size": 9}):
        figure = Figure(figsize=(size[0] * across, size[1]), layout="constrained")
        yield figure.subplots(1, across, squeeze=False)[0].tolist()
        figure.savefig(path, format="svg", metadata={"Date": None})


@contextmanager
def saved_figure(path: Path, size: tuple[float, float] = (6.4, 3.6)) -> Iterator[Axes]:
    """Axes of a figure, which is saved at the end of the block."""
    with saved_figures(path, 1, size) as (axes,):
        yield axes


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


def draw_errors(axes: Axes, kf_alone: JsonMapping, with_online: JsonMapping) -> None:
    """Distributions of Eq. 7 without and with the online detector (Fig. 11), from figures of ``TrackingSummary``."""
    for figures, label in ((kf_alone, "KF"), (with_online, "KF and online detector")):
        counts = np.array(figures["histogram"], float)
        edges = np.linspace(0, 1, len(counts) + 1)
        mean = number(figures["mean_error"], 4)
        axes.stairs(counts / max(counts.sum(), 1), edges, label=f"{label}, mean {mean}", linewidth=1.6)
    axes.set(xlabel="Eq. 7, share of the box that does not overlap", ylabel="share of matched frames", xlim=(0, 0.5))
    axes.legend()
