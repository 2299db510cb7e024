"""Plots the figures of an evaluation with matplotlib. This is the only module here that needs the extra ``train``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tsr_engine.evaluation.classification import ClassificationReport
from tsr_engine.evaluation.detection import DetectionScore
from tsr_engine.evaluation.fusion import FusionReport
from tsr_engine.evaluation.tracking import BINS, TrackingSummary
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT, SIGN_CLASSES


def plot_curves(curves: Mapping[str, DetectionScore], path: Path) -> None:
    """Write named precision-recall curves as PNG.

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


def plot_confusion(report: ClassificationReport, path: Path) -> None:
    """Write the confusion matrix as PNG, rows normalised to shares.

    Raises:
        OSError: the file cannot be written.
    """
    shares = report.matrix / np.maximum(report.matrix.sum(1, keepdims=True), 1)
    figure = Figure(figsize=(13, 12), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    picture = axes.imshow(np.sqrt(shares), cmap="magma_r", vmin=0, vmax=1)
    ticks = range(CLASS_COUNT)
    axes.set_xticks(ticks, [c.short for c in SIGN_CLASSES], rotation=90, fontsize=7)
    axes.set_yticks(ticks, [f"{c.short}  {c.id}" for c in SIGN_CLASSES], fontsize=7)
    for row, column in zip(*np.nonzero(report.matrix - np.diag(np.diag(report.matrix))), strict=True):
        axes.text(column, row, str(report.matrix[row, column]), ha="center", va="center", fontsize=5)
    axes.set(xlabel="predicted", ylabel="true")
    axes.set_title(f"{report.accuracy:.4f} of {report.pictures} pictures right; numbers: pictures confused")
    bar = figure.colorbar(picture, ax=axes, shrink=0.7, ticks=[0, 0.5, 1], label="share of the true class")
    bar.ax.set_yticklabels(["0", "0.25", "1"])
    figure.savefig(path, format="png", dpi=110)


def plot_fusion(report: FusionReport, path: Path) -> None:
    """Write the rates over the number of frames as PNG (compare Fig. 13).

    Raises:
        OSError: the file cannot be written.
    """
    figure = Figure(figsize=(7, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    marks = {"scale": "o", "equal": "s", "clamped": "^"}
    for mode, rates in report.rates.items():
        axes.plot(report.frames, rates, marker=marks.get(mode, "."), markersize=4, label=mode)
    axes.set(
        xlabel="fused frames, far to near",
        ylabel="correctly classified signs",
        title=f"{report.tracks} tracks, delta {report.delta:g} px, s_c {report.scale:g} px",
    )
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(path, format="png", dpi=120)


def plot_errors(summaries: dict[str, TrackingSummary], path: Path) -> None:
    """Write the distribution of Eq. 7 (Fig. 11) of one or more named runs as PNG.

    Raises:
        OSError: the file cannot be written.
    """
    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    axes = figure.subplots()
    edges = np.linspace(0.0, 1.0, BINS + 1)
    for name, summary in summaries.items():
        counts = np.array(summary.histogram, dtype=np.float64)
        label = f"{name} (mean {summary.mean_error:.3f})" if summary.mean_error is not None else f"{name} (no match)"
        axes.stairs(counts / max(counts.sum(), 1.0), edges, label=label, fill=len(summaries) == 1)
    axes.set_xlabel("normalised non-overlapping area (Eq. 7)")
    axes.set_ylabel("share of matched frames")
    axes.set_xlim(0.0, 1.0)
    axes.legend()
    figure.savefig(path, format="png", dpi=120)
