"""Precision against recall of one or more detectors as a picture (Fig. 9)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tsr_engine.evaluation.detection import DetectionScore

__all__ = ["plot_curves"]


def plot_curves(curves: Mapping[str, DetectionScore], path: Path) -> None:
    """Write precision-recall curves by name as a PNG.

    Raises:
        OSError: the file cannot be written.
    """
    figure = Figure(figsize=(6.4, 4.8), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for name, curve in curves.items():
        axes.plot(curve.recall, curve.precision, label=f"{name}: AP {curve.average_precision:.4f}")
    some = next(iter(curves.values()), None)
    if some is not None:
        axes.set_title(f"{some.signs} signs in {some.pictures} pictures, IoU 0.5")
    axes.set(xlabel="recall", ylabel="precision", xlim=(0.5, 1.0), ylim=(0.5, 1.005))
    axes.grid(alpha=0.3)
    axes.legend(loc="lower left")
    figure.savefig(path, format="png", dpi=120)
