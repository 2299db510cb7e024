"""Peers on identical detections: SORT, ByteTrack, OC-SORT and C-BIoU beside our presets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from benchmarks.cache import Cache
from benchmarks.experiment import Data, Experiment, Result, Skip, version
from benchmarks.peers.figures import sequence, trackeval_figures
from benchmarks.peers.multi_object_trackers import PEERS, Missing, load, track_with_peer
from benchmarks.peers.tuning import tune
from benchmarks.reporting.markdown import number, table
from benchmarks.reporting.plotting import legend_below, saved_figures
from benchmarks.videos.approaches import EACH, EACH_OF_A_ROW, judged_approaches, read_approaches
from benchmarks.videos.clips import clip_groups, read_clips
from benchmarks.videos.engine_tracker import track_with_engine
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedVideo, detect_videos
from benchmarks.videos.tracked_clips import CONFIGURATIONS
from tsr_engine.evaluation.tracking import VideoReport, evaluate_video, shared_errors, summarise
from tsr_engine.geometry.boxes import iou
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.pipeline import load_components, one_opencv_thread
from tsr_engine.track_table import TrackTable

CHOSEN_ON = ("chosen on", "approaches chosen on")
"""Groups of videos on which settings are chosen, ours and those of the peers."""

LIVE = "default, while driving"
BOUND = "detections, perfect identities"
PRESETS = ("default", "paper")

BETTER = {
    "HOTA": (1, "HOTA"),
    "IDF1": (1, "IDF1"),
    "MOTA": (1, "MOTA"),
    "coverage": (1, "coverage"),
    "ids_per_sign": (-1, "ids per sign"),
    "signs_detected": (1, "signs found"),
    "false_tracks": (-1, "false tracks"),
    "mean_error": (-1, "mean Eq. 7"),
    "mean_error_overall": (-1, "uncovered as 1"),
}
"""Figure -> which way is better, and its heading."""


def annotated_videos(data: Data) -> tuple[list[AnnotatedVideo], str]:
    """The clips by group and the simulated approaches by stress; and the reason if there are no approaches.

    Approaches to scenes that parameters were chosen on are left out.

    Raises:
        Skip: there are no clips.
    """
    groups = clip_groups(read_clips(data.need("clips")))
    videos = [AnnotatedVideo(name, group, *clip) for group, clips in groups.items() for name, clip in clips.items()]
    try:
        approaches = judged_approaches(data, EACH)
    except Skip as why:
        return videos, str(why)
    return videos + [
        AnnotatedVideo(name, approaches.stress[name], *clip) for name, clip in approaches.videos.items()
    ], ""


def tuning_approaches(data: Data) -> list[AnnotatedVideo]:
    """Simulated approaches on which settings are chosen, ``EACH_OF_A_ROW`` for each stress; none without a folder."""
    if data.tuning is None:
        return []
    found = read_approaches(data.tuning, each=EACH_OF_A_ROW)
    return [AnnotatedVideo(f"tuning {name}", CHOSEN_ON[1], *clip) for name, clip in found.videos.items()]


def _run(data: Data) -> Result:
    videos, without = annotated_videos(data)
    seen = list(detect_videos([*videos, *tuning_approaches(data)], data.scratch / "detections"))
    tuned_on = [s for s in seen if s.video.group in CHOSEN_ON]
    judged = [s for s in seen if s.video.group not in CHOSEN_ON]
    if not judged:
        raise Skip("the folder `clips` has only clips that parameters were chosen on, and no approach was given.")
    rows: dict[str, list[tuple[TrackTable, float]]] = {name: [] for name in (*PRESETS, LIVE)}
    cache = Cache(data.scratch / "peers")
    configurations = {name: (CONFIGURATIONS[name], load_components(CONFIGURATIONS[name])) for name in PRESETS}
    with one_opencv_thread():  # so that the CPU time of a frame is meaningful
        for video in judged:
            for name, found in track_with_engine(video, configurations, cache).items():
                rows[name].append((found.rows, found.seconds))
                if name == "default":
                    rows[LIVE].append((found.live, found.seconds))
    chosen, missing = run_peers(tuned_on, judged, rows, cache)
    rows[BOUND] = [(perfect_identities(s), 0.0) for s in judged]
    clips = [s.video.name for s in judged if s.video.group == "held out"]
    chosen_on = [s.video.name for s in tuned_on if s.video.group == "chosen on"]
    approaches = len(judged) - len(clips)
    also = f"no simulated approach: {without}" if without else f"{approaches} simulated approaches with exact truth"
    other = len(tuned_on) - len(chosen_on)
    unseen = "none of a photograph used for tuning" if data.tuning else "no folder `tuning` was given to keep apart"
    return Result(
        data="Our detector runs once over each video; every tracker starts from the same boxes. The peers' settings "
        f"were chosen by HOTA (ties by MOTA and IDF1) on {', '.join(chosen_on) or 'no clip'} and {other} simulated "
        "approaches, which are some of the videos that our parameters were chosen on (docs/tracking.md). Reported are "
        f"{', '.join(clips) or 'no clip'} and {also.rstrip('.')}, {unseen}.",
        figures={"groups": figures_by_group(judged, rows), "chosen": chosen, "missing": missing},
        settings={name: version(name) for name in ("trackers", "supervision", "trackeval") if version(name)},
    )


def run_peers(
    tuned_on: Sequence[DetectedVideo],
    judged: Sequence[DetectedVideo],
    rows: dict[str, list[tuple[TrackTable, float]]],
    cache: Cache,
) -> tuple[JsonObject, dict[str, str]]:
    """Tune and run each peer; returns the chosen settings, and the peers that cannot run, with the reason."""
    chosen: JsonObject = {}
    missing: dict[str, str] = {}
    try:
        load("trackeval")
    except Missing as why:
        missing["TrackEval"] = str(why)
    for peer in PEERS:
        if "TrackEval" in missing:
            missing[peer.name] = f"it is tuned by HOTA, and {missing['TrackEval']}"
            continue
        try:
            if not tuned_on:
                raise Missing("no video was given to choose its settings on.")
            best = tune(peer, tuned_on, cache)
            rows[peer.name] = [track_with_peer(peer, video, best.settings) for video in judged]
        except Missing as why:
            missing[peer.name] = str(why)
            continue
        chosen[peer.name] = asdict(best)
    return chosen, missing


def figures_by_group(judged: Sequence[DetectedVideo], rows: Mapping[str, list[tuple[TrackTable, float]]]) -> JsonObject:
    """Group -> tracker -> figures. Groups: held-out clips, each stress, all stresses.

    Args:
        judged: the videos.
        rows: for each tracker its rows and CPU seconds on each video; the first tracker is ours.
    """
    stresses = sorted({s.video.group for s in judged} - {"held out"})
    clips = ["held out"] if any(s.video.group == "held out" for s in judged) else []
    groups = [*clips, *stresses, *(["all approaches"] if len(stresses) > 1 else [])]
    figures: JsonObject = {}
    ours: list[VideoReport] = []
    for name, found in rows.items():
        reports, sequences = [], []
        for s, (returned, _) in zip(judged, found, strict=True):
            truth, shown = (table.cut(s.width, s.height) for table in (s.video.truth, returned))
            reports.append(evaluate_video(s.video.name, truth, shown, len(s.frames)))
            sequences.append(sequence(truth, shown, len(s.frames)))
        ours = ours or reports
        for group in groups:
            mine = [i for i, s in enumerate(judged) if _belongs(s.video.group, group)]
            if mine:
                seconds = sum(found[i][1] for i in mine)
                figures.setdefault(group, {})[name] = _tracking_figures(
                    [reports[i] for i in mine], [sequences[i] for i in mine]
                ) | {
                    "ms_a_frame": 1e3 * seconds / sum(len(judged[i].frames) for i in mine),
                    "shared": shared_errors([ours[i] for i in mine], [reports[i] for i in mine]),
                }
    return figures


def _belongs(own: str, group: str) -> bool:
    return own == group or (group == "all approaches" and own != "held out")


def _tracking_figures(reports: list[VideoReport], sequences: list[JsonObject]) -> JsonObject:
    s = summarise(reports).as_dict()
    errors = ("mean_error", "mean_error_overall", "mean_error_any_width")
    kept = ("signs", "signs_detected", "false_tracks", "coverage", "ids_per_sign", *errors, "switches")
    figures: JsonObject = {name: s[name] for name in kept}
    try:
        return figures | trackeval_figures(sequences)
    except Missing:
        return figures | dict.fromkeys(("HOTA", "IDF1", "MOTA"))


def perfect_identities(seen: DetectedVideo) -> TrackTable:
    """Every detection on a counted sign, with the sign's id: the upper bound of a tracker that returns detections."""
    truth, rows = seen.video.truth, []
    for frame in seen.frames:
        here = np.flatnonzero((truth.frame == frame.ordinal) & ~truth.ignore)
        found = frame.detections
        if not len(here) or not len(found):
            continue
        overlap = iou(found.boxes, truth.boxes[here])
        for column, row in enumerate(here):
            best = int(overlap[:, column].argmax())
            if overlap[best, column] >= 0.5 and overlap[best].argmax() == column:
                sign = int(truth.track[row])
                rows.append((frame.ordinal, sign, found.boxes[best], 0, float(found.scores[best]), "detected"))
    return TrackTable.of_rows(rows)


def _report(result: Result) -> str:
    f = result.figures
    parts = [f"*Skipped:* {name}: {why}\n" for name, why in f["missing"].items()]
    parts += [
        f"`{LIVE}` omits the frames before a track is confirmed; the product adds them afterwards, the peers never do. "
        "Its focus of expansion also comes from the whole clip, as a drive yields it after a minute.\n\n"
        "The peers are those of the package `trackers`; norfair is missing because it needs NumPy below 2. Our tracker "
        "continues without a detection, while the peers return only detections: "
        f"`{BOUND}` is the most that any of them can cover. `paper` starts from the same boxes too, not from those of "
        "its own detector. Times are CPU ms of everything after detection; ours includes reading the pictures and "
        "classifying the signs, which the peers do not do.\n\n"
        "*Mean Eq. 7* is taken over the frames that coverage counts, for signs of at least 20 px. *Uncovered as 1* "
        "takes all frames of these signs and counts 1 where there is no box. *Any width* takes all boxes on a sign.\n"
    ]
    for group, by_name in f["groups"].items():
        head = [group, *(title for _, title in BETTER.values()), "Eq. 7, any width", "ms a frame"]
        order = [n for n in (*PRESETS, LIVE, *f["chosen"], BOUND) if n in by_name]
        rows = [head] + [[name, *_cells(by_name[name])] for name in order]
        parts.append(table(rows))
    parts.append(_shared(f["groups"], list(f["chosen"])))
    parts.append(_verdict(f["groups"], list(f["chosen"])))
    if f["chosen"]:
        parts.append(_settings(f["chosen"]))
    return "\n".join(parts)


def _cells(s: JsonMapping) -> list[str]:
    return [
        *(number(s[name], 3) for name in ("HOTA", "IDF1", "MOTA", "coverage")),
        number(s["ids_per_sign"], 2),
        f"{s['signs_detected']}/{s['signs']}",
        str(s["false_tracks"]),
        number(s["mean_error"], 4),
        number(s["mean_error_overall"], 4),
        number(s["mean_error_any_width"], 4),
        number(s["ms_a_frame"] or None, 2),
    ]


def _shared(groups: JsonMapping, peers: Sequence[str]) -> str:
    """Eq. 7 over the boxes of both trackers, by group."""
    if not peers:
        return ""
    rows = [["Eq. 7 where both have a box: `default` / peer (signs and frames)", *peers]]
    for group, by_name in groups.items():
        cells = []
        for name in peers:
            s = by_name[name]["shared"]
            worse = s["n"] > 0 and s["ours"] > s["theirs"]
            text = f"{number(s['ours'], 4)} / {number(s['theirs'], 4)} ({s['n']})"
            cells.append(f"**{text}**" if worse else text)
        rows.append([group, *cells])
    return (
        "A tracker that omits hard frames has a lower mean, and ours covers more frames. The next table compares the "
        f"same signs in the same frames (bold: the peer is better):\n\n{table(rows)}"
    )


def _verdict(groups: JsonMapping, peers: Sequence[str]) -> str:
    """Cases in which peers are better than ``default``, in result rows or live, or ``paper`` is, without rounding."""
    if not peers:
        return "No peer could be run, so there is no comparison.\n"
    lines = []
    every = tuple(peers)
    for ours, others, title in (
        ("default", every, "a tuned peer"),
        ("default", ("paper",), "`paper`"),
        (LIVE, every, "a tuned peer"),
    ):
        if not all(ours in by_name for by_name in groups.values()):
            continue
        beaten = [line for group, by_name in groups.items() for line in _losses(group, by_name, ours, others)]
        if beaten:
            lines.append(f"**`{ours}` is beaten by {title}** at:\n\n" + "\n".join(f"- {b}" for b in beaten) + "\n")
        else:
            lines.append(f"`{ours}` is never beaten by {title}.\n")
    return "\n".join(lines)


def _losses(group: str, by_name: JsonMapping, ours: str, others: Sequence[str]) -> list[str]:
    """Figures of a group in which others are better than ``ours``, the best one first."""
    lines = []
    for figure, (sign, heading) in BETTER.items():
        mine = by_name[ours][figure]
        found = {n: by_name[n][figure] for n in others if n in by_name and by_name[n][figure] is not None}
        if mine is None:
            continue
        above = sorted((n for n in found if sign * found[n] > sign * mine), key=lambda n: -sign * found[n])
        if above:
            theirs = ", ".join(_short(found[n]) + (f" by {n}" if tuple(others) != ("paper",) else "") for n in above)
            lines.append(f"{group}, {heading}: {theirs} against our {_short(mine)}")
    return lines


def _settings(chosen: JsonMapping) -> str:
    rows = [["peer", "combinations tried", "HOTA where chosen", "that reach it", "settings"]]
    for name, best in chosen.items():
        text = ", ".join(f"{k} {v:g}" for k, v in best["settings"].items())
        rows.append([name, str(best["tried"]), f"{best['hota']:.3f}", str(best["equal"]), text])
    note = "Settings ending in `_score` are scores of our detector; the peers get them as logistic confidences."
    return f"{table(rows)}\n{note}\n"


def _short(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.4g}"


def _plot(result: Result, path: Path) -> None:
    groups = result.figures["groups"]
    names = [n for n in ("default", "paper", *result.figures["chosen"]) if n in next(iter(groups.values()))]
    with saved_figures(path, 2, (5.2, 3.6)) as both:
        for axes, figure, title in ((both[0], "coverage", "coverage"), (both[1], "mean_error", "mean Eq. 7")):
            for k, name in enumerate(names):
                values = [by_name[name][figure] or 0.0 for by_name in groups.values()]
                places = np.arange(len(groups)) + (k - (len(names) - 1) / 2) * 0.8 / len(names)
                axes.bar(places, values, 0.8 / len(names), label=name)
            axes.set_xticks(np.arange(len(groups)), list(groups), rotation=30, ha="right")
            axes.set_ylabel(title)
        legend_below(both[0], 6)


EXPERIMENT = Experiment(
    "trackers",
    "Trackers on identical detections",
    "How does our tracking compare with tuned trackers of today that get the same detections?",
    _run,
    _report,
    _plot,
    optional=("looming", "tuning"),
)
