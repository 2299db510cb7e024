"""False tracks on other people's drives, as recorded and under other weather."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from scipy.stats import chi2

from benchmarks.cache import Cache, file_digest
from benchmarks.corruptions.video import write_changed
from benchmarks.corruptions.weather import WEATHERS
from benchmarks.experiment import ROOT, Data, Experiment, Result, Skip
from benchmarks.reporting.markdown import class_name, table
from benchmarks.videos.tracked_rows import track_rows
from tsr_engine.evaluation.tracking import evaluate_video
from tsr_engine.io.video_kinds import VIDEO_SUFFIXES
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, load_components
from tsr_engine.track_table import TrackTable

AS_RECORDED: Final = "as recorded"
CHANGED: Final = 200
"""Number of first frames of each drive that get other weather."""
SIGNS: Final = ROOT / "data" / "drive_signs.json"
"""Real signs on which tracks were seen: boxes of some frames, linear between them."""


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
    signs = json.loads(SIGNS.read_text(encoding="utf-8"))
    cache = Cache(data.scratch / "drives")
    figures: JsonObject = {}
    for weather in (AS_RECORDED, *WEATHERS):
        rows, frames = [], 0
        for name, path in sorted(drives.items()):
            own = [sign["boxes"] for sign in signs if sign["drive"] == name]
            key = [
                "drives",
                weather,
                CHANGED,
                file_digest(path),
                params.model_dump_json(),
                dict(components.models),
                own,
            ]
            seen = cache.get(key, partial(_tracked, path, weather, params, components, boxes_between(own)))
            frames += seen["frames"]
            rows += [{"drive": name} | row for row in seen["tracks"]]
        figures[weather] = {"frames": frames, "drives": len(drives), "tracks": rows}
    return Result(
        data=f"{len(drives)} drives of other people, cameras and countries, without annotation. The rows below the "
        f"first are the first {CHANGED} frames of each, changed by `benchmarks/corruptions/weather.py` and re-encoded. "
        "No value was chosen on them; a drifting track in one of them led to the rule that a tentative track ends "
        "after 20 frames without a detection.",
        figures=figures,
        settings={"preset": "default", "detector": components.models["detector"][:12]},
    )


def boxes_between(signs: Sequence[JsonMapping]) -> TrackTable:
    """Boxes of signs in all frames from their first box to their last, linear between boxes.

    Args:
        signs: frame (a text) -> box of each sign, in order of frames.
    """
    tables = [TrackTable.empty()]
    for number, boxes in enumerate(signs):
        known = [int(frame) for frame in boxes]
        frames = np.arange(known[0], known[-1] + 1)
        sides = [np.interp(frames, known, side) for side in zip(*boxes.values(), strict=True)]
        tables.append(TrackTable(frames, np.full(len(frames), number), np.stack(sides, axis=1)))
    return TrackTable.joined(tables)


def _tracked(path: Path, weather: str, params: Params, components: Components, signs: TrackTable) -> JsonObject:
    with tempfile.TemporaryDirectory(prefix="tsr-drives-") as folder:
        video = path
        if weather != AS_RECORDED:
            video = write_changed(WEATHERS[weather], path, Path(folder) / "drive.mp4", CHANGED)
        report, rows = track_rows(video, params, components)
    false = evaluate_video(path.stem, signs, rows, report.frames).false_tracks
    tracks = []
    for track in np.unique(rows.track).tolist():
        own = rows.rows(rows.track == track)
        tracks.append({
            "first": int(own.frame.min()), "last": int(own.frame.max()), "class": int(own.class_id[-1]),
            "width": float(np.diff(own.boxes[:, [0, 2]]).max()), "on_sign": track not in false,
        })  # fmt: skip
    return {"frames": report.frames, "tracks": tracks}


def _report(result: Result) -> str:
    rows = [["drives", "frames", "tracks", "on no sign at all", "of these per 1,000 frames", "95 % interval"]]
    lines = []
    for weather, f in result.figures.items():
        false = sum(not row["on_sign"] for row in f["tracks"])
        value, low, high = rate(false, f["frames"])
        count = [f"{f['frames']:,}", str(len(f["tracks"])), str(false), f"{value:.2f}", f"{low:.2f} to {high:.2f}"]
        rows.append([weather, *count])
        lines += [f"- {weather}, {_track(row)}" for row in f["tracks"]]
    return (
        "Nobody has annotated these drives. The place of each track was looked at: a track is *on no sign at all* if "
        "it matches none of the real signs seen there (`benchmarks/data/drive_signs.json`) in any frame. Most of these "
        "signs are of none of the 43 classes, such as yellow diamonds.\n\n"
        f"{table(rows)}\n" + ("Every track:\n\n" + "\n".join(lines) + "\n" if lines else "")
    )


def _track(row: JsonMapping) -> str:
    where = "" if row["on_sign"] else ", on no sign"
    return (
        f"{row['drive']}: frames {row['first']} to {row['last']}, up to {row['width']:.0f} px wide, read as "
        f"{class_name(row['class'])}{where}."
    )


EXPERIMENT = Experiment(
    "drives",
    "Drives under other weather",
    "How many tracks does the engine make on drives in which it should find nothing, also at night and in rain?",
    _run,
    _report,
)
