"""Rerun recordings of 300 frames at 720p: size and time, with copied packets and with encoded pictures."""

from __future__ import annotations

from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.markdown import table
from benchmarks.timing.recordings import FRAMES, HEIGHT, KINDS, MOST_MB, MOST_SECONDS, WIDTH, measure

TIMES = 6
"""Number of recordings in one process."""


def _run(data: Data) -> Result:
    clips, work = data.need("clips"), data.scratch / "recordings"
    work.mkdir(parents=True, exist_ok=True)
    found = [measure(kind, work, clips, TIMES) for kind in KINDS]
    return Result(
        data=f"{FRAMES} frames of {WIDTH}x{HEIGHT}: the clips with the fewest and with the most bytes a frame, each "
        "repeated and tracked with the `default` preset. A recording has every layer, the series, the events and the "
        "picture.",
        figures={"drives": found},
    )


def _report(result: Result) -> str:
    rows = [["drive", "picture", "recording", "first in a process", "later ones", "`tsr record`, whole command"]]
    over = []
    for one in result.figures["drives"]:
        first, later = one["seconds"][0], one["seconds"][1:]
        size = f"{one['megabytes']:.2f} MB, {one['boxes']:,} boxes"
        times = _with_cpu(first, one["cpu_seconds"][0]), f"{min(later):.2f} to {max(later):.2f} s"
        command = _with_cpu(one["command_seconds"], one["command_cpu_seconds"])
        rows.append([one["source"].split(",")[0], one["picture"], size, *times, command])
        if one["megabytes"] > MOST_MB or first > MOST_SECONDS:
            over.append(one["source"].split(",")[0])
    verdict = f"exceeded by {', '.join(over)}" if over else "met"
    return (
        f"{table(rows)}\nBar: {MOST_MB:g} MB and {MOST_SECONDS:g} s, also for the first recording of a process: "
        f"{verdict}. The first one also loads the Rerun SDK; the review tool keeps a worker that has loaded it.\n"
    )


def _headline(result: Result) -> str:
    clauses = (
        f"{one['source'].split(',')[0]} {one['megabytes']:.2f} MB in {one['seconds'][0]:.2f} s the first time"
        for one in result.figures["drives"]
    )
    return "; ".join(clauses)


def _with_cpu(seconds: float, cpu: float) -> str:
    return f"{seconds:.2f} s (CPU {cpu:.2f} s)"


EXPERIMENT = Experiment(
    "recordings",
    "Recordings for Rerun",
    "How large is a recording of ten seconds of a drive, and how long does it take?",
    _run,
    _report,
    headline=_headline,
)
