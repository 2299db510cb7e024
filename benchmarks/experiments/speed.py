"""Time of the offline detector by stage at 720x576."""

from __future__ import annotations

from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.markdown import table
from benchmarks.timing.detection import TURNS, shrunk_scenes, time_stages

SCENES = 40


def _run(data: Data) -> Result:
    pictures = shrunk_scenes(data.need("gtsdb"), SCENES)
    figures = time_stages(pictures)
    return Result(
        data=f"{len(pictures)} GTSDB scenes shrunk to 720x576, signs from 16 px, one thread. CPU ms: median over the "
        f"scenes of the least of {TURNS} turns. The shipped models and settings.",
        figures=figures,
    )


def _report(result: Result) -> str:
    f = result.figures
    stages = {"channel pyramid": "pyramid", "cascade": "scan", "whole detection": "whole"}
    rows = [["stage", "ms"], *([title, f"{f[stage]:.1f}"] for title, stage in stages.items())]
    return (
        table([*rows, ["*first bar, aim*", "*35, 15*"]])
        + "\nMilliseconds depend on this machine and its load; *Time compared with a deep network of today* has "
        "ratios.\n"
    )


def _headline(result: Result) -> str:
    f = result.figures
    return f"{f['whole']:.1f} ms, of which the channel pyramid {f['pyramid']:.1f} and the cascade {f['scan']:.1f}"


EXPERIMENT = Experiment(
    "speed",
    "Detection time",
    "How long does detection in one picture take on one core?",
    _run,
    _report,
    headline=_headline,
)
