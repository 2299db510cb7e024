"""Fig. 5: where in a picture signs appear."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.plotting import saved_figure
from tsr_engine.detection.prior import GRID, parzen
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.io.pictures import read_picture
from tsr_engine.records import FloatArray
from tsr_engine.training.public.detector_components import BANDWIDTH, split_scenes


def _run(data: Data) -> Result:
    scenes = read_gtsdb(data.need("gtsdb"))
    train, calibrate, report = split_scenes(scenes, data.seed)
    height, width = read_picture(scenes[0].path).shape[:2]

    def centres(chosen: Sequence[Scene]) -> FloatArray:
        boxes = np.concatenate([s.boxes for s in chosen])
        return np.stack([(boxes[:, 0] + boxes[:, 2]) / (2 * width), (boxes[:, 1] + boxes[:, 3]) / (2 * height)], axis=1)

    prior = parzen(centres([*train, *calibrate]), BANDWIDTH)
    held = centres(report)
    cells = np.minimum((held * GRID).astype(int), GRID - 1)
    at = prior[cells[:, 1], cells[:, 0]]
    area = {str(share): float((prior >= np.quantile(at, 1 - share)).mean()) for share in (0.5, 0.9, 0.99)}
    return Result(
        data=f"GTSDB: the density is estimated from {len(train) + len(calibrate)} scenes and tested on the "
        f"{len(held)} signs of the other {len(report)}.",
        figures={
            "table": np.round(prior[::4, ::4].astype(float), 4).tolist(),
            "held_out": np.round(held, 4).tolist(),
            "area_that_holds": area,
        },
        settings={"seed": data.seed, "bandwidth": BANDWIDTH},
    )


def _report(result: Result) -> str:
    area = result.figures["area_that_holds"]
    return (
        f"Half of the held-out signs lie on {area['0.5']:.1%} of the picture's area, 90 % on {area['0.9']:.1%}, "
        f"99 % on {area['0.99']:.1%}.\n"
    )


def _plot(result: Result, path: Path) -> None:
    with saved_figure(path, size=(6.4, 3.8)) as axes:
        picture = axes.imshow(result.figures["table"], extent=(0, 1, 1, 0), cmap="viridis", aspect=0.6)
        points = np.array(result.figures["held_out"])
        axes.scatter(points[:, 0], points[:, 1], s=5, c="white", edgecolors="black", linewidths=0.4)
        axes.set(xlabel="across the picture", ylabel="down the picture")
        axes.figure.colorbar(picture, ax=axes, label="prior")


EXPERIMENT = Experiment(
    "prior",
    "Where signs appear (Fig. 5)",
    "Does the position of a sign in the picture follow a density that also holds for unseen scenes? Dots in the figure "
    "are signs of scenes that the density was not estimated from.",
    _run,
    _report,
    _plot,
)
