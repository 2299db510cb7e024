"""Measures the memory of page and server during an hour of playing in the review screen."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.markdown import table
from benchmarks.reporting.plotting import saved_figure
from benchmarks.review.browser_session import open_browser_session
from benchmarks.review.long_drive import measure_long_play

SETTLED = 5.0
"""Minutes after which the page's cache of pictures is full; later growth is a leak."""


def _run(data: Data) -> Result:
    from tests.app.long_run import make_long_run

    minutes = float(os.environ.get("TSR_BENCH_MINUTES", "5"))
    with tempfile.TemporaryDirectory() as scratch:
        home = Path(scratch)
        made = make_long_run(home)
        with open_browser_session(home, (home,), sample=False) as session:
            playing = measure_long_play(session, made.video_id, made.run_id, minutes)
    return Result(
        data=f"A synthetic drive of 132,400 frames with 5,000 tracks, played for {minutes:g} minutes as fast as "
        "pictures arrive, in a browser without a network debugger (one would keep some kB a request).",
        figures={"playing": playing},
        settings={"minutes": minutes},
    )


def _report(result: Result) -> str:
    played = result.figures["playing"]
    settled = next((row for row in played if row["minutes"] >= SETTLED), played[-1])
    middle = played[len(played) // 2]
    rows = [["minutes", "frames shown", "script heap, MB", "page processes, MB", "server, MB"]]
    for row in (settled, middle, played[-1]):
        counts = [f"{row['minutes']:.0f}", f"{row['frames']:,}", f"{row['heap']:.1f}"]
        rows.append([*counts, str(row["renderers"]), str(row["server"])])
    tail = [row for row in played if row["minutes"] >= settled["minutes"]]
    low, high = min(row["renderers"] for row in tail), max(row["renderers"] for row in tail)
    return table(rows) + (
        f"\nFrom minute {settled['minutes']:.0f} on the page's processes hold {low} to {high} MB (bar: constant). By "
        "design, up to 384 MB of that are decoded pictures. The server's memory grows with encoded pictures up to the "
        "limit of its cache.\n"
    )


def _plot(result: Result, path: Path) -> None:
    played = result.figures["playing"]
    minutes = [row["minutes"] for row in played]
    with saved_figure(path) as axes:
        for name, label in (("renderers", "page processes"), ("server", "server"), ("heap", "script heap")):
            axes.plot(minutes, [row[name] for row in played], label=label)
        axes.set(xlabel="minutes of playing", ylabel="resident memory, MB", ylim=(0, None))
        axes.legend()


EXPERIMENT = Experiment(
    "review_hour",
    "An hour of playing",
    "Does the review tool's memory stay constant during a day's work?",
    _run,
    _report,
    _plot,
)
