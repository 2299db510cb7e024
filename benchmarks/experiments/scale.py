"""Measures rate and memory over the length of a drive, and time over the number of signs and the picture size."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from benchmarks.experiment import ROOT, Data, Experiment, Result
from benchmarks.reporting.markdown import table
from benchmarks.reporting.plotting import saved_figures
from benchmarks.timing.growth import exponent, picture_cost, sign_cost, sign_faces
from benchmarks.timing.long_run import DETECTION_PERIOD, NOTES
from benchmarks.timing.looped_video import RATE, SIZE, base_clip, cut_out, repeat_clip
from benchmarks.timing.run_notes import read_sections
from sample_videos import SHIPPED
from tsr_engine.io.video import open_video
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components, one_opencv_thread

BASE, TURNS = 331, 400
LONGEST = BASE * TURNS
"""132,400 frames, as in the paper's drives."""
ENDS = (60 * RATE, 180 * RATE, 600 * RATE, 30 * 60 * RATE, LONGEST)
SECONDS = {"real": 200, "repeated": 300}
"""Default time of one call of the experiment, s; another call continues."""
COUNTS = (1, 2, 4, 8, 16)
FACTORS = (0.5, 0.71, 1.0, 1.41, 2.0)


def _run(data: Data) -> Result:
    folder = data.scratch / "looped"
    base = base_clip(folder, BASE, drives=2)
    long = folder / f"drive_{LONGEST}.mp4"
    if not long.is_file():
        part = long.with_suffix(".part.mp4")
        repeat_clip(base, part, LONGEST)
        part.rename(long)
    runs = {"real": (long, data.scratch / "long_real"), "repeated": (base, data.scratch / "long_repeated")}
    figures: JsonObject = {}
    for kind, (video, evidence) in runs.items():
        sections = read_sections(evidence / NOTES, ENDS)
        if not sections or sections[-1].frames < LONGEST:
            _long_run(kind, video, evidence, data.seconds or SECONDS[kind])
            sections = read_sections(evidence / NOTES, ENDS)
        figures[kind] = [asdict(section) for section in sections]
        size = sum(path.stat().st_size for path in evidence.rglob("*") if path.is_file())
        figures[f"{kind}_evidence_mb"] = round(size / 1e6, 1)
    with one_opencv_thread():
        drive = SHIPPED[0]
        with open_video(drive.video) as opened:
            stills = [cut_out(frame.picture) for frame in opened.frames(0, 150)][::30]
        signs = sign_cost(stills[0], sign_faces(drive.video, drive.truth), COUNTS, load_components(Params()))
        sizes = picture_cost(stills, FACTORS)
    figures["signs"] = {str(count): round(ms, 3) for count, ms in signs.items()}
    figures["signs_exponent"] = round(exponent(list(signs), list(signs.values())), 3)
    figures["sizes"] = {f"{w}x{h}": round(ms, 3) for (w, h), ms in sizes.items()}
    figures["sizes_exponent"] = round(exponent([w * h for w, h in sizes], list(sizes.values())), 3)
    return Result(
        data=f"A drive of {LONGEST:,} frames of {SIZE[0]}x{SIZE[1]}: {BASE} frames of the two sample drives, "
        f"{TURNS} times in one file. *Everything* is `tsr track` with evidence on that file, as far as the given time "
        "allows. *After detection*: decoding, detection and camera shift are computed once for the "
        f"{BASE} frames and reused; tracking, gate, online detector, recognition, result rows and evidence store, with "
        f"pixels, run for every frame. Signs are shown in one of {DETECTION_PERIOD} repetitions, because they are "
        "rare on real drives.",
        figures=figures,
        settings={f"seconds a call, {kind}": data.seconds or seconds for kind, seconds in SECONDS.items()},
    )


def _long_run(kind: str, video: Path, folder: Path, seconds: float) -> None:
    command = [sys.executable, "-m", "benchmarks.timing.long_run", kind, str(video.resolve()), str(folder.resolve())]
    limits = ["--stop", str(LONGEST), "--seconds", str(seconds)]
    subprocess.run([*command, *limits], cwd=ROOT.parent, check=True, stdout=subprocess.DEVNULL)  # noqa: S603


def _report(result: Result) -> str:
    f = result.figures
    rows = [["", "up to frame", "of drive", "frames/s in this part", "CPU ms a frame", "peak memory, MB", "processes"]]
    for kind, title in (("real", "everything"), ("repeated", "after detection")):
        for number, s in enumerate(f[kind]):
            rows.append([
                "" if number else title, f"{s['frames']:,}", f"{s['frames'] / RATE / 60:.1f} min",
                f"{s['per_second']:.1f}", f"{s['cpu_ms']:.1f}", f"{s['peak_mb']:.0f}", str(s["sittings"]),
            ])  # fmt: skip
    signs = _across("signs in view", "ms a frame after detection", f["signs"])
    sizes = _across("picture", "ms a detection", f["sizes"])
    return (
        table(rows) + f"\n{_verdict(f)} The evidence of both runs takes {f['real_evidence_mb']:.0f} and "
        f"{f['repeated_evidence_mb']:.0f} MB.\n\n"
        + table(signs)
        + f"\nTime grows with the number of signs to the power of {f['signs_exponent']:.2f} (median CPU ms of a frame "
        "in which every sign is detected; sign faces of the sample drive, pasted without overlap).\n\n"
        + table(sizes)
        + f"\nDetection time grows with the number of pixels to the power of {f['sizes_exponent']:.2f} (signs from 16 "
        "px at every size, one thread, frames of the sample drive; larger pictures have more scales to search).\n"
    )


def _across(name: str, what: str, values: Mapping[str, float]) -> list[list[str]]:
    """A table of two rows, smallest first; stored results have no order."""
    ordered = sorted(values.items(), key=lambda item: int(item[0].split("x")[0]))
    return [[name, *(key for key, _ in ordered)], [what, *(f"{value:.1f}" for _, value in ordered)]]


def _verdict(figures: JsonMapping) -> str:
    """Sentences that compare memory and rate at the end with those at the beginning."""
    words = []
    for kind, title in (("real", "Everything"), ("repeated", "After detection")):
        sections = figures[kind]
        if not sections:
            words.append(f"{title}: **not measured yet**; another call measures it.")
            continue
        last, first = sections[-1], sections[0]
        reached = (
            "" if last["frames"] >= LONGEST else f" (time ran out at frame {last['frames']:,}; another call continues)"
        )
        if len(sections) == 1:
            words.append(f"{title}: one part only{reached}.")
            continue
        words.append(
            f"{title}: from frame {first['frames']:,} to {last['frames']:,} the peak memory rises by "
            f"{last['peak_mb'] - first['peak_mb']:.0f} MB and the CPU time a frame changes by a factor of "
            f"{last['cpu_ms'] / first['cpu_ms']:.2f}{reached}."
        )
    return " ".join(words)


def _plot(result: Result, path: Path) -> None:
    f = result.figures
    with saved_figures(path, 3, (3.6, 3.2)) as (length, signs, sizes):
        for kind, title in (("real", "everything"), ("repeated", "after detection")):
            if not f[kind]:
                continue
            ends = [0, *(s["frames"] for s in f[kind])]
            middles = [(a + b) / 2 for a, b in pairwise(ends)]
            length.plot(middles, [s["cpu_ms"] for s in f[kind]], "o-", label=f"{title}, ms a frame")
            length.plot(ends[1:], [s["peak_mb"] for s in f[kind]], "s--", label=f"{title}, peak MB")
        length.set(xlabel="frames of drive")
        if f["real"] or f["repeated"]:  # a logarithmic axis needs numbers
            length.set(xscale="log", yscale="log")
            length.legend(fontsize=7)
        _power(signs, [float(n) for n in f["signs"]], list(f["signs"].values()), "signs in view", f["signs_exponent"])
        pixels = [float(np.prod([int(v) for v in size.split("x")])) for size in f["sizes"]]
        _power(sizes, pixels, list(f["sizes"].values()), "pixels of the picture", f["sizes_exponent"])


def _power(axes: Axes, x: list[float], y: list[float], label: str, power: float) -> None:
    axes.plot(x, y, "o")
    along = np.geomspace(min(x), max(x), 20)
    middle = np.exp(np.mean(np.log(y)) - power * np.mean(np.log(x)))
    axes.plot(along, middle * along**power, "-", label=f"power {power:.2f}")
    axes.set(xscale="log", yscale="log", xlabel=label, ylabel="CPU ms")
    axes.legend()


EXPERIMENT = Experiment(
    "scale",
    "Scale",
    "Do rate and memory stay constant from a minute to 132,400 frames, and how does time grow with signs in view and "
    "picture size?",
    _run,
    _report,
    _plot,
)
