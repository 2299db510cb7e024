"""Exports of a drive of an hour and a half: time and memory of every format, written and read back."""

from __future__ import annotations

from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.markdown import table
from benchmarks.timing.exports import FRAMES, MOST_MB, MOST_SECONDS, TRACKS, WITHOUT_PICTURES, measure_in_new_process
from tsr_engine.json_shapes import JsonObject


def _run(_: Data) -> Result:
    return Result(
        data=f"A synthetic drive of {FRAMES:,} frames with {TRACKS:,} tracks of 25 to 50 boxes that grow with the "
        "jitter of a tracker. Each format is written in its own process, without pictures, as one ZIP file.",
        figures={"formats": [measure_in_new_process(name) for name in WITHOUT_PICTURES]},
        settings={"seed": 1},
    )


def _report(result: Result) -> str:
    rows = [["format", "writing", "CPU", "peak memory", "files", "unpacked", "reading", "CPU", "peak memory"]]
    over = []
    for one in result.figures["formats"]:
        rows.append([one["format"], *_written(one), *_read(one)])
        if one["seconds"] > MOST_SECONDS or one["peak_mb"] > MOST_MB:
            over.append(one["format"])
    boxes = sorted({one["boxes"] for one in result.figures["formats"]})
    verdict = f"exceeded by {', '.join(over)}" if over else "met by every format"
    return (
        f"{table(rows)}\nBar for writing: {MOST_SECONDS:g} s and {MOST_MB} MB, {verdict}. Boxes: "
        f"{', '.join(f'{n:,}' for n in boxes)}. The same process writes and then reads, so its peak memory of reading "
        "includes that of writing; about 50 MB of each is the drive itself.\n"
    )


def _written(one: JsonObject) -> list[str]:
    return [
        f"{one['seconds']:.1f} s",
        f"{one['cpu_seconds']:.1f} s",
        f"{one['peak_mb']} MB",
        f"{one['files']:,}",
        f"{one['mb']:.0f} MB",
    ]


def _read(one: JsonObject) -> list[str]:
    if "read_seconds" not in one:
        return ["-", "-", "-"]
    return [f"{one['read_seconds']:.1f} s", f"{one['read_cpu_seconds']:.1f} s", f"{one['read_peak_mb']} MB"]


EXPERIMENT = Experiment(
    "exports",
    "Exports of a long drive",
    "How much time and memory does an export of a drive of 90 minutes take, and how much does reading it back take?",
    _run,
    _report,
)
