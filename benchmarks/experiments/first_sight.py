"""Measures the width of a sign when its track starts, with the shipped models and with those of an earlier version."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.cache import Cache, file_digest
from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.reporting.markdown import table
from benchmarks.videos.approaches import EACH, judged_approaches
from benchmarks.videos.clips import clip_groups, read_clips
from benchmarks.videos.tracked_clips import Videos
from benchmarks.videos.tracked_rows import track_rows
from sample_videos import SHIPPED
from tsr_engine.evaluation.track_tables import read_clip_truth
from tsr_engine.evaluation.tracking import evaluate_video
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, load_components
from tsr_engine.track_table import TrackTable

MIN_WIDTH_DIFFERENCE: Final = 0.1
"""Difference in width, as a share, above which a sign counts as seen earlier or later."""
BOOTSTRAP_SAMPLES: Final = 10_000
"""Number of bootstrap samples for the interval of the mean."""


def first_widths(truth: TrackTable, results: TrackTable, frames: int) -> dict[int, float | None]:
    """Width of each annotated sign in the first frame in which a track lies on it at IoU 0.5, px; None: in no frame.

    Args:
        truth: annotated rows; signs whose rows are all ignored are left out, ignored rows of others count.
        results: tracked rows.
        frames: number of frames of the video.
    """
    signs = np.unique(truth.track[~truth.ignore]).tolist()
    truth = replace(truth, ignore=np.zeros(len(truth.frame), np.bool_))
    first = first_matches(truth, evaluate_video("", truth, results, frames, min_width=0.0).matched)
    return {sign: first[sign][1] if sign in first else None for sign in signs}


def first_matches(truth: TrackTable, matched: Iterable[tuple[int, int]]) -> dict[int, tuple[int, float]]:
    """Sign -> first frame in which a track lies on it, and the sign's width there, px.

    Args:
        truth: annotated rows.
        matched: pairs of frame and matched sign, as from ``evaluate_video``.
    """
    first: dict[int, int] = {}
    for frame, sign in matched:
        first[sign] = min(frame, first.get(sign, frame))
    width = truth.boxes[:, 2] - truth.boxes[:, 0]
    return {
        sign: (frame, float(width[(truth.frame == frame) & (truth.track == sign)][0])) for sign, frame in first.items()
    }


def compare_widths(rows: Sequence[JsonMapping], seed: int) -> JsonObject:
    """Compare the models on a group of signs.

    Args:
        rows: for each sign its widths ``before`` and ``now``, px, None without a track, and its least annotated width,
            ``least``.
        seed: random seed of the interval.

    Returns:
        ``signs``: number of signs; ``found``: number found by each; ``width``: median width with each. Over the signs
        that both find: ``ratio``: geometric mean of width now / before, with its 95 % ``interval``; numbers seen
        ``earlier`` and ``later``; ``at_once``: number that both see in the first annotated frame.
    """
    both = np.array([(row["before"], row["now"]) for row in rows if None not in (row["before"], row["now"])])
    logs = np.log(both[:, 1] / both[:, 0]) if len(both) else np.zeros(0)
    out: JsonObject = {"signs": len(rows), "earlier": int((logs < np.log1p(-MIN_WIDTH_DIFFERENCE)).sum())}
    out["at_once"] = sum(row["before"] == row["now"] == row["least"] for row in rows)
    out["later"] = int((logs > -np.log1p(-MIN_WIDTH_DIFFERENCE)).sum())
    out["found"] = {name: sum(row[name] is not None for row in rows) for name in ("before", "now")}
    if len(both):
        drawn = np.random.default_rng(seed).choice(logs, (BOOTSTRAP_SAMPLES, len(logs))).mean(axis=1)
        out["width"] = dict(zip(("before", "now"), np.median(both, axis=0).tolist(), strict=True))
        out["ratio"] = float(np.exp(logs.mean()))
        out["interval"] = np.exp(np.quantile(drawn, (0.025, 0.975))).tolist()
    return out


def _run(data: Data) -> Result:
    before = data.need("before") / "tsr_engine" / "models"
    if not before.is_dir():
        raise Skip(f"the checkout `{data.need('before').name}` of an earlier version has no tsr_engine/models.")
    params = Params.preset("default")
    models = {"before": load_components(params, before), "now": load_components(params)}
    videos: dict[str, Videos] = {"sample drives": _samples()}
    if data.clips is not None:
        videos |= {f"clips {group}": own for group, own in clip_groups(read_clips(data.clips)).items()}
    if data.looming is not None:
        videos["approaches"] = judged_approaches(data, EACH).videos
    cache = Cache(data.scratch / "first_sight")
    figures: JsonObject = {}
    for group, own in videos.items():
        rows = [
            row for name, (video, truth) in own.items() for row in _signs(name, video, truth, params, models, cache)
        ]
        figures[group] = compare_widths(rows, data.seed) | {"rows": rows}
    return Result(
        data="The sample drives, the clips of *Real clips* and the simulated approaches of *Under stress*. The sample "
        "drives are rendered and begin far from their signs; most approaches begin where their sign is large enough to "
        "detect. A sign's width is its annotated width in the first frame in which a track lies on it at IoU 0.5.",
        figures=figures,
        settings={name: components.models["detector"][:12] for name, components in models.items()},
    )


def _samples() -> Videos:
    return {clip.video.stem: (clip.video, read_clip_truth(clip.truth)) for clip in SHIPPED}


def _signs(
    name: str, video: Path, truth: TrackTable, params: Params, models: Mapping[str, Components], cache: Cache
) -> list[JsonObject]:
    """The signs of one video, each with its width before and now."""
    widths: dict[str, dict[str, float | None]] = {}
    for which, components in models.items():
        key = ["first sight", name, file_digest(video), params.model_dump_json(), dict(components.models)]
        widths[which] = cache.get([*key, truth.boxes.tolist()], partial(_tracked, video, truth, params, components))
    all_widths = truth.boxes[:, 2] - truth.boxes[:, 0]
    return [
        {
            "clip": name, "sign": int(sign), "before": widths["before"][sign], "now": width,
            "least": float(all_widths[truth.track == int(sign)].min()),
        }
        for sign, width in widths["now"].items()
    ]  # fmt: skip


def _tracked(video: Path, truth: TrackTable, params: Params, components: Components) -> dict[int, float | None]:
    report, rows = track_rows(video, params, components)
    return first_widths(truth.cut(report.width, report.height), rows, report.frames)


def _report(result: Result) -> str:
    head = ["", "signs", "found before, now", "at once", "median width before, now", "width now, share of before"]
    rows = [[*head, "95 % interval", f"more than {MIN_WIDTH_DIFFERENCE:.0%} earlier, later"]]
    lines = []
    for group, f in result.figures.items():
        rows.append([
            group, str(f["signs"]), f"{f['found']['before']}, {f['found']['now']}", str(f["at_once"]),
            *(
                [f"{f['width']['before']:.1f}, {f['width']['now']:.1f} px", f"{f['ratio']:.3f}",
                 "{:.3f} to {:.3f}".format(*f["interval"])] if "ratio" in f else ["-", "-", "-"]
            ),
            f"{f['earlier']}, {f['later']}",
        ])  # fmt: skip
        lines += [
            f"- {row['clip']}: sign {row['sign']}: {_px(row['before'])} before, {_px(row['now'])} now."
            for row in f["rows"]
            if group.startswith("clips") or _differs(row)
        ]
    return (
        f"*Before* is the detector {result.settings['before']}, *now* is {result.settings['now']}; the rest of the "
        "engine is the same. *Width now, share of before* is a geometric mean over the signs that both find. *At once* "
        f"counts signs that both find in the first annotated frame.\n\n{table(rows)}\n"
        f"All signs of the clips, and other signs whose width differs by more than {MIN_WIDTH_DIFFERENCE:.0%}:\n\n"
        + "\n".join(lines)
        + "\n"
    )


def _differs(row: JsonMapping) -> bool:
    if None in (row["before"], row["now"]):
        return bool(row["before"] != row["now"])
    return bool(abs(np.log(row["now"] / row["before"])) > -np.log1p(-MIN_WIDTH_DIFFERENCE))


def _px(width: float | None) -> str:
    return "not found" if width is None else f"{width:.1f} px"


EXPERIMENT = Experiment(
    "first_sight",
    "First frame of a sign",
    "How wide is a sign when its track starts, with the shipped models and with those of an earlier version?",
    _run,
    _report,
    optional=("clips", "looming", "tuning"),
)
