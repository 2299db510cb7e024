"""Compares trackers on every second, third or fourth frame of videos, as from a slower camera or a faster car."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.cache import Cache
from benchmarks.experiment import Data, Experiment, Result, version
from benchmarks.experiments.trackers import CHOSEN_ON, annotated_videos, perfect_identities, tuning_approaches
from benchmarks.peers.multi_object_trackers import PEERS, Missing, track_with_peer
from benchmarks.peers.tuning import tune
from benchmarks.reporting.markdown import table
from benchmarks.reporting.plotting import legend_below, saved_figures
from benchmarks.videos.engine_tracker import filter_alone
from benchmarks.videos.stored_detections import DetectedVideo, detect_videos, every_nth_frame_of
from tsr_engine.evaluation.tracking import evaluate_video, summarise
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params import Params
from tsr_engine.track_table import TrackTable

STEPS = (1, 2, 3, 4)
"""Steps between the frames that are cache."""
HEADINGS = {"1": "every frame", "2": "every 2nd", "3": "every 3rd", "4": "every 4th"}
FULL_RATE: Mapping[str, float | None] = {
    "noise_centre": 0.03,
    "noise_size": 0.2,
    "growth_process": 0.0005,
    "growth_spread": 0.03,
    "centre_process": 0.01,
    "drift_process": 0.2,
    "foe_spread": 0.05,
    "level_frames": 0,
    "result_noise": 0.35,
    "sure_score": None,
}
"""Values of tracking that were best when only videos at their full rate were used."""
OURS, BEFORE, BOUND = "default", "values chosen at the full rate alone", "detections, perfect identities"
GROUPS = ("held out", "chosen on", "approaches")


def _run(data: Data) -> Result:
    videos, without = annotated_videos(data)
    seen = list(detect_videos([*videos, *tuning_approaches(data)], data.scratch / "detections"))
    cache = Cache(data.scratch / "peers")
    default = Params.preset("default")
    ours = {OURS: default, BEFORE: default.with_settings(list(FULL_RATE.items()))}
    figures: JsonObject = {}
    missing: dict[str, str] = {}
    for step in STEPS:
        left = [every_nth_frame_of(s, step) for s in seen]
        rows: dict[str, list[TrackTable]] = {name: [filter_alone(s, p) for s in left] for name, p in ours.items()}
        for peer in PEERS:
            try:
                tuned_on = [s for s in left if s.video.group in CHOSEN_ON]
                if not tuned_on:
                    raise Missing("no video was given to choose its settings on.")
                best = tune(peer, tuned_on, cache)
                rows[peer.name] = [track_with_peer(peer, s, best.settings)[0] for s in left]
            except Missing as why:
                missing[peer.name] = str(why)
        rows[BOUND] = [perfect_identities(s) for s in left]
        for group in GROUPS:
            mine = [i for i, s in enumerate(left) if _group(s) == group]
            if mine:
                found = {name: _figures([left[i] for i in mine], [r[i] for i in mine]) for name, r in rows.items()}
                figures.setdefault(group, {})[str(step)] = found
    approaches = sum(_group(s) == "approaches" for s in seen)
    also = f"no simulated approach: {without.rstrip('.')}" if without else f"{approaches} simulated approaches"
    return Result(
        data="The videos of *Trackers on identical detections* (clips held out, clips chosen on, and "
        f"{also}), with every frame, every second, every third and every fourth frame. Our tracker is the Kalman "
        "filter alone.",
        figures={"groups": figures, "missing": missing},
        settings={name: version(name) for name in ("trackers", "trackeval") if version(name)},
    )


def _group(seen: DetectedVideo) -> str:
    return seen.video.group if seen.video.group in (*GROUPS, *CHOSEN_ON) else "approaches"


def _figures(seen: Sequence[DetectedVideo], rows: Sequence[TrackTable]) -> JsonObject:
    reports = []
    for s, returned in zip(seen, rows, strict=True):
        size = (s.width, s.height)
        reports.append(evaluate_video(s.video.name, s.video.truth, returned, len(s.frames), size=size))
    summary = summarise(reports).as_dict()
    return {name: summary[name] for name in ("mean_error", "coverage", "ids_per_sign", "false_tracks")}


def _report(result: Result) -> str:
    f = result.figures
    parts = [f"*Skipped:* {name}: {why}\n" for name, why in f["missing"].items()]
    parts.append(
        "Each cell has the mean Eq. 7, the coverage and the ids per sign. The peers' settings were chosen by HOTA on "
        "the videos of *Trackers on identical detections*, for each rate separately. The values of "
        f"`{OURS}` were chosen on such videos for all four rates together.\n"
    )
    for group, steps in _in_order(f["groups"]):
        head = [group, *(HEADINGS[step] for step in steps)]
        names = _names(steps)
        parts.append(table([head, *([name, *(_cell(steps[step][name]) for step in steps)] for name in names)]))
    return "\n".join([*parts, _verdict(f["groups"]), ""])


def _in_order(groups: JsonMapping) -> list[tuple[str, JsonMapping]]:
    return [(group, groups[group]) for group in GROUPS if group in groups]


def _names(steps: JsonMapping) -> list[str]:
    """Ours first, then the peers, then the upper bound."""
    known = next(iter(steps.values()))
    peers = [name for name in known if name not in (OURS, BEFORE, BOUND)]
    return [name for name in (OURS, BEFORE, *peers, BOUND) if name in known]


def _cell(figures: JsonMapping) -> str:
    if figures["mean_error"] is None:
        return "-"
    return f"{_error(figures)}, {100 * figures['coverage']:.1f} %, {figures['ids_per_sign']:.2f}"


def _error(figures: JsonMapping) -> str:
    return "none" if figures["mean_error"] is None else f"{figures['mean_error']:.4f}"


def _verdict(groups: JsonMapping) -> str:
    """Cases in which the current values are worse than the earlier ones or than peers."""
    worse = [
        f"{group}, {HEADINGS[step]}: {_loss(found[OURS], found[name])} of {name}"
        for group, steps in _in_order(groups)
        for step, found in steps.items()
        for name in found
        if name not in (OURS, BOUND) and (found[name]["mean_error"] or 1.0) < (found[OURS]["mean_error"] or 1.0)
    ]
    if not worse:
        return f"`{OURS}` has the lowest mean Eq. 7 at every rate."
    return (
        f"Lower mean Eq. 7 than `{OURS}`, each over the frames that it covers (a tracker that omits hard frames has a "
        "lower mean):\n\n" + "\n".join(f"- {line}" for line in worse)
    )


def _loss(ours: JsonMapping, theirs: JsonMapping) -> str:
    """Both means, with enough digits to differ, and the coverage of each."""
    a, b = ours["mean_error"], theirs["mean_error"]
    digits = next((n for n in range(4, 8) if round(a, n) != round(b, n)), 8)
    return " against ".join(
        f"{f['mean_error']:.{digits}f} ({100 * f['coverage']:.1f} % covered)" for f in (ours, theirs)
    )


def _plot(result: Result, path: Path) -> None:
    groups = result.figures["groups"]
    with saved_figures(path, len(groups), (4.0, 3.4)) as all_axes:
        for axes, (group, steps) in zip(all_axes, _in_order(groups), strict=True):
            for name in _names(steps):
                style = "-" if name in (OURS, BEFORE) else "--"
                axes.plot(
                    [int(s) for s in steps], [found[name]["mean_error"] for found in steps.values()], style, label=name
                )
            axes.set_xticks([int(s) for s in steps])
            axes.set_title(group)
            axes.set_xlabel("one frame of")
        all_axes[0].set_ylabel("mean Eq. 7")
        legend_below(all_axes[0])


EXPERIMENT = Experiment(
    "frame_rates",
    "Lower frame rates",
    "At a lower frame rate a sign grows more from frame to frame. Which trackers still follow it?",
    _run,
    _report,
    _plot,
    optional=("looming", "tuning"),
)
