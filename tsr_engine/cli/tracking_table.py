"""The table of `tsr eval tracking`."""

from __future__ import annotations

from tsr_engine.cli.common import out_console
from tsr_engine.json_shapes import JsonObject


def print_summaries(summaries: JsonObject, details: JsonObject) -> None:
    """Print figures side by side, and which signs were found in which video.

    Args:
        summaries: name of a run -> its ``TrackingSummary``.
        details: name of a run -> ``video``, ``found`` and ``signs`` of each video.
    """
    from rich.table import Table

    rows = (
        ("physical signs", "signs", "d"),
        ("signs detected", "signs_detected", "d"),
        ("detection rate", "detection_rate", "%"),
        ("false tracks", "false_tracks", "d"),
        ("false boxes per frame", "false_positives_per_frame", "f"),
        ("correctly classified", "signs_classified", "d"),
        ("... of detected", "classified_of_detected", "%"),
        ("... of all", "classified_of_all", "%"),
        ("coverage", "coverage", "%"),
        ("ids per sign", "ids_per_sign", "f"),
        ("mean of Eq. 7", "mean_error", "f"),
        ("... frames without a box as 1", "mean_error_overall", "f"),
        ("... signs of any width", "mean_error_any_width", "f"),
        ("median of Eq. 7", "median_error", "f"),
        ("mean of Eq. 7 over followed frames", "mean_error_followed", "f"),
    )
    table = Table("", *summaries, box=None, pad_edge=False, header_style="bold")
    for title, field, kind in rows:
        table.add_row(title, *(_format(getattr(summary, field), kind) for summary in summaries.values()))
    console = out_console()
    console.print(table)
    for name, videos in details.items():
        listed = ", ".join(f"{v['video']} {v['found']}/{v['signs']}" for v in videos)
        console.print(f"{name}, signs found by video: {listed}", soft_wrap=True)


def _format(value: float | None, kind: str) -> str:
    if value is None:
        return "-"
    if kind == "%":
        return f"{100 * value:.2f} %"
    return f"{value:.4f}" if kind == "f" else str(value)
