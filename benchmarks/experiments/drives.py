"""False tracks on other people's drives, as recorded and under other weather."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from scipy.stats import chi2

from benchmarks.cache import Cache, file_digest
from benchmarks.corruptions.video import write_changed
from benchmarks.corruptions.weather import WEATHERS
from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.reporting.markdown import class_name, table
from benchmarks.videos.tracked_rows import track_rows
from tsr_engine.io.video_kinds import VIDEO_SUFFIXES
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, load_components

AS_RECORDED: Final = "as recorded"
CHANGED: Final = 200
"""Number of first frames of each drive that get other weather."""


def rate(tracks: int, frames: int) -> tuple[float, float, float]:
    """Tracks per 1,000 frames, with the ends of the exact 95 % interval of a Poisson rate.

    Args:
        tracks: number of tracks.
        frames: number of frames, >= 1.
    """
    low = 0.0 if tracks == 0 else float(chi2.ppf(0.025, 2 * tracks)) / 2
    high = float(chi2.ppf(0.975, 2 * tracks + 2)) / 2
    return 1e3 * tracks / frames, 1e3 * low / frames, 1e3 * high / frames


def _run(data: Data) -> Result:
    folder = data.need("drives")
    drives = {
        path.stem: path for path in sorted(folder.iterdir(), reverse=True) if path.suffix.lower() in VIDEO_SUFFIXES
    }
    if not drives:
        raise Skip("the folder `drives` holds no video.")
    params = Params.preset("default")
    components = load_components(params)
    cache = Cache(data.scratch / "drives")
    figures: JsonObject = {}
    for weather in (AS_RECORDED, *WEATHERS):
        rows, frames = [], 0
        for name, path in sorted(drives.items()):
            key = ["drives", weather, CHANGED, file_digest(path), params.model_dump_json(), dict(components.models)]
            seen = cache.get(key, partial(_tracked, path, weather, params, components))
            frames += seen["frames"]
            rows += [{"drive": name} | row for row in seen["tracks"]]
        figures[weather] = {"frames": frames, "drives": len(drives), "tracks": rows}
    return Result(
        data=f"{len(drives)} drives of other people, cameras and countries, without annotation. The rows below the "
        f"first are the first {CHANGED} frames of each, changed by `benchmarks/corruptions/weather.py` and re-encoded. "
        "No value was chosen on them.",
        figures=figures,
        settings={"preset": "default", "detector": components.models["detector"][:12]},
    )


def _tracked(path: Path, weather: str, params: Params, components: Components) -> JsonObject:
    with tempfile.TemporaryDirectory(prefix="tsr-drives-") as folder:
        video = path
        if weather != AS_RECORDED:
            video = write_changed(WEATHERS[weather], path, Path(folder) / "drive.mp4", CHANGED)
        report, rows = track_rows(video, params, components)
    tracks = []
    for track in np.unique(rows.track).tolist():
        own = rows.rows(rows.track == track)
        tracks.append({
            "first": int(own.frame.min()), "last": int(own.frame.max()), "class": int(own.class_id[-1]),
            "width": float(np.diff(own.boxes[:, [0, 2]]).max()),
        })  # fmt: skip
    return {"frames": report.frames, "tracks": tracks}


def _report(result: Result) -> str:
    rows = [["drives", "frames", "tracks", "per 1,000 frames", "95 % interval"]]
    lines = []
    for weather, f in result.figures.items():
        value, low, high = rate(len(f["tracks"]), f["frames"])
        count = [f"{f['frames']:,}", str(len(f["tracks"])), f"{value:.2f}", f"{low:.2f} to {high:.2f}"]
        rows.append([weather, *count])
        lines += [f"- {weather}, {_track(row)}" for row in f["tracks"]]
    return (
        "Nobody has annotated these drives, so every track counts, also those on real foreign signs.\n\n"
        f"{table(rows)}\n" + ("Every track:\n\n" + "\n".join(lines) + "\n" if lines else "")
    )


def _track(row: JsonMapping) -> str:
    return (
        f"{row['drive']}: frames {row['first']} to {row['last']}, up to {row['width']:.0f} px wide, read as "
        f"{class_name(row['class'])}."
    )


EXPERIMENT = Experiment(
    "drives",
    "Drives under other weather",
    "How many tracks does the engine make on drives in which it should find nothing, also at night and in rain?",
    _run,
    _report,
)
