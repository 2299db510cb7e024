"""Compares times of detection and of the whole engine with a network of YOLO11n's size, alternating in one process."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.reporting.markdown import table
from benchmarks.reporting.plotting import COLOURS, saved_figure
from benchmarks.timing.alternating import Turns, pipeline_beside, scenes_in_turn
from benchmarks.timing.contenders import ENLARGED, EQUAL, deep_networks, runtime, yolo_networks
from benchmarks.timing.detection import shrunk_scenes
from benchmarks.timing.looped_video import base_clip
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components, load_detector, one_opencv_thread

SCENES = 15
ROUNDS = 5
"""Runs of each contender on a scene."""
FRAMES = 132
"""Number of frames of the drive for the whole engine."""
EVERY = {EQUAL: 8, ENLARGED: 24}
"""Number of frames of the drive between two runs of each network."""
REFERENCE = {"at shrink 4": 26.0, "at shrink 2": 87.0, "at shrink 2 with signs from 14 px": 145.0}
"""Times of the toolbox's C++ ACF core, model of 28x28 px, 720x576: ms per picture, one thread, on another machine."""
REFERENCE_NETWORK = 70.0
"""Time of the network in onnxruntime on that machine, ms."""
BARS = {"detection": (1 / 2, 1 / 4), "whole engine": (1 / 1.5, 1 / 2.5)}
"""Limit and aim, as shares of the network's time."""


def _run(data: Data) -> Result:
    scenes = data.need("gtsdb")
    onnxruntime = runtime()
    yolo = yolo_networks(onnxruntime, data.scratch / "yolo")
    pictures = shrunk_scenes(scenes, SCENES)
    params = Params().with_settings([("second_core", False)])
    with one_opencv_thread():
        detector = load_detector(params)
        contenders = {"detection": detector.detect, **yolo.run}
        left_out = {}
        try:
            contenders |= deep_networks(onnxruntime)
        except Skip as reason:
            left_out["the small deep detector"] = str(reason)
        in_turn = scenes_in_turn(contenders, pictures, ROUNDS)
        video = base_clip(data.scratch / "looped", FRAMES)
        whole = pipeline_beside(video, params, load_components(params), {n: (yolo.run[n], EVERY[n]) for n in EVERY})
    figures = {
        "scenes": {name: in_turn.summary(name) for name in in_turn.names},
        "drive": {name: whole.summary(name) for name in whole.names},
        "signs_in_view": whole.signs_in_view,
        "left_out": left_out,
        "ratios": {"detection": _ratios(in_turn, "detection"), "whole engine": _ratios(whole, "whole engine")},
        "paired": {name: in_turn.paired("detection", name) for name in EVERY},
    }
    return Result(
        data=f"{len(pictures)} GTSDB scenes shrunk to 720x576, and the first {FRAMES} frames of the sample drive "
        f"`country_road` cropped to 720x576 ({whole.signs_in_view:.2f} signs in view on average). Signs from 16 px, "
        "the shipped models and settings. CPU time of one thread; all detectors take turns within one process, in a "
        f"rotating order. For a scene, the least of {ROUNDS} turns counts.",
        figures=figures,
        settings={"onnxruntime": onnxruntime.__version__, **yolo.about},
    )


def _ratios(turns: Turns, mine: str) -> dict[str, float]:
    return {name: turns.median(mine) / turns.median(name) for name in EVERY}


def _report(result: Result) -> str:
    f = result.figures
    rows = [["one picture of 720x576", "median ms", "quartiles"]]
    titles = {"detection": "**our detection**, everything from picture to boxes"} | _NETWORKS
    for name, s in f["scenes"].items():
        rows.append([titles.get(name, name), f"{s['median']:.1f}", f"{s['low']:.1f} - {s['high']:.1f}"])
    s = f["drive"]["whole engine"]
    rows.append([
        "**our whole engine** on the drive: decoding, detection, tracking, learning, recognition",
        f"{s['median']:.1f}", f"{s['low']:.1f} - {s['high']:.1f}",
    ])  # fmt: skip
    for name in EVERY:
        s = f["drive"][name]
        rows.append(
            [
                f"{_NETWORKS[name]}, between frames of the drive",
                f"{s['median']:.1f}",
                f"{s['low']:.1f} - {s['high']:.1f}",
            ]
        )
    ratios = [
        ["share of the network's time (ratio of medians)", "at equal input", "enlarged input", "first bar", "aim"]
    ]
    for what, (bar, aim) in BARS.items():
        ratios.append(
            [what, *(verdict(f["ratios"][what][name], bar, aim) for name in EVERY), f"{bar:.2f}", f"{aim:.2f}"]
        )
    return (
        table(rows)
        + "".join(f"\n*Skipped:* {name}: {why}\n" for name, why in f["left_out"].items())
        + "\n"
        + table(ratios)
        + f"\nFor single pictures, detection takes {_range(f['paired'][EQUAL])} of the network's time at equal "
        "input.\n\n"
        "*Equal input* is 736x576, the smallest multiples of 32 px that hold 720x576. *Enlarged input* is 1440x1152, "
        "twice the picture: the network's finest grid has cells of 8 px, so a sign of 16 px is two cells wide, and a "
        "double input is the usual remedy for small objects.\n\n"
        "The networks' times are `session.run` alone, without resizing the picture and reading the boxes from the "
        "output; ours includes everything. YOLO11n has its real architecture but random weights, because trained ones "
        "need a download. The time of its convolutions does not depend on the weights. *Detection on unseen scenes* "
        "has the accuracy of our detection, *YOLO11n trained on the same scenes* that of this network.\n\n"
        "The toolbox's C++ core is not run here. It was timed once beside the same network at equal input and took "
        f"{_shares(REFERENCE)} of the network's time. Ours takes {f['ratios']['detection'][EQUAL]:.2f}, at shrink 2 "
        "and with signs from 16 px.\n"
    )


def _shares(times: Mapping[str, float]) -> str:
    """Times of a core as shares of the network's time in the same run."""
    return ", ".join(f"{ms / REFERENCE_NETWORK:.2f} {what}" for what, ms in times.items())


def _headline(result: Result) -> str:
    f = result.figures
    mine, whole = f["scenes"]["detection"]["median"], f["drive"]["whole engine"]["median"]
    share = {name: ratios[EQUAL] for name, ratios in f["ratios"].items()}
    return (
        f"detection {mine:.1f} ms, {share['detection']:.3f} of the network's time at equal input; whole engine "
        f"{whole:.1f} ms, {share['whole engine']:.3f}"
    )


_NETWORKS = {EQUAL: "YOLO11n in onnxruntime, 736x576", ENLARGED: "YOLO11n in onnxruntime, 1440x1152"}


def _range(values: Mapping[str, float]) -> str:
    return f"{values['median']:.2f} (quartiles {values['low']:.2f} to {values['high']:.2f})"


def verdict(ratio: float, bar: float, aim: float) -> str:
    """A ratio, and whether it meets limit and aim."""
    verdict = "aim met" if ratio <= aim else "bar met, aim not" if ratio <= bar else "**bar missed**"
    return f"{ratio:.3f} ({verdict})"


def _plot(result: Result, path: Path) -> None:
    times: JsonMapping = result.figures["scenes"]
    names = [*times, "whole engine"]
    values = [times[name] if name in times else result.figures["drive"][name] for name in names]
    with saved_figure(path, size=(6.4, 0.5 + 0.42 * len(names))) as axes:
        medians = np.array([v["median"] for v in values])
        spread = np.abs(np.array([[v["low"], v["high"]] for v in values]).T - medians)
        ours = [name in ("detection", "whole engine") for name in names]
        colours = [COLOURS[0] if mine else COLOURS[4] for mine in ours]
        axes.barh(names[::-1], medians[::-1], xerr=spread[:, ::-1], color=colours[::-1])
        axes.set(xlim=(0, None), xlabel="ms a picture of 720x576, one thread (median, quartiles)")


EXPERIMENT = Experiment(
    "yolo_time",
    "Time compared with a deep network of today",
    "Which share of the time of a YOLO11n-size network in onnxruntime do our detection and our whole engine take, on "
    "one thread, in the same run?",
    _run,
    _report,
    _plot,
    _headline,
)
