"""Reverts each departure of the preset ``default`` from ``paper`` alone, on every stress and on the real clips."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.experiments.ablation_rows import DEPARTURES, IN_QUESTION, ON_CLIPS, configurations
from benchmarks.reporting.markdown import change_text, number, table
from benchmarks.videos.approaches import EACH_OF_A_ROW, EACH_TUNED, Approaches, judged_approaches, read_approaches
from benchmarks.videos.clips import clip_groups, read_clips
from benchmarks.videos.tracked_clips import Scored, score
from tsr_engine.evaluation.tracking import VideoReport, summarise
from tsr_engine.json_shapes import JsonMapping, JsonObject

ROUNDS = 2000
"""Number of bootstrap rounds of an interval."""


MEASURES = (
    ("mean_error", "Mean of Eq. 7", 4, -1),
    ("coverage", "Coverage of sign frames of at least 20 px", 4, 1),
    ("ids_per_sign", "Ids per sign", 3, -1),
    ("false_tracks", "False tracks", 0, -1),
    ("signs_classified", "Signs with the right class", 0, 1),
)
"""Figure, title of its table, decimals, and whether more is better (1) or worse (-1)."""


def paired(default: Sequence[VideoReport], other: Sequence[VideoReport], seed: int) -> dict[str, float] | None:
    """Change of the mean of Eq. 7, with a 95 % interval over videos.

    Both rows are resampled together, video by video, so that the difficulty of a video cancels out.

    Returns:
        ``change``, ``low`` and ``high``; None if a row has no match.
    """
    sums = np.array([[sum(e for e, _ in report.errors) for report in row] for row in (default, other)])
    counts = np.array([[len(report.errors) for report in row] for row in (default, other)], float)
    if not counts.sum(axis=1).all():
        return None
    drawn = np.random.default_rng(seed).integers(0, len(default), (ROUNDS, len(default)))
    totals = counts[:, drawn].sum(axis=2)
    means = sums[:, drawn].sum(axis=2) / np.maximum(totals, 1)
    low, high = np.percentile(means[1] - means[0], (2.5, 97.5))
    before, after = sums.sum(axis=1) / counts.sum(axis=1)
    return {"change": float(after - before), "low": float(low), "high": float(high)}


def _run(data: Data) -> Result:
    judged, tuned = _sets(data)
    rows = configurations()
    figures: JsonObject = {"judged": {}, "tuned": {}}
    about = []
    for name, parts in (("judged", judged), ("tuned", tuned)):
        for part, source in parts.items():
            simulated = isinstance(source, Approaches)
            mine = rows if simulated else {title: rows[title] for title in ON_CLIPS}
            scored = score(source.videos if simulated else source, mine, data.scratch)
            figures[name] |= _figures(part, scored, source, data.seed)
            about.append(f"{name} {part} ({len(next(iter(scored.values())).reports)} videos)")
    return Result(
        data="Each frame is detected once; every row tracks the same detections. "
        + f"Data: {', '.join(about)}. Parameters were chosen on the tuned data, whose scenes no judged approach shows. "
        "Only these rows were run on the real clips: " + "; ".join(ON_CLIPS) + "." + _not_given(data),
        figures=figures,
        settings={"rows": len(rows), "seed": data.seed},
    )


def _sets(data: Data) -> tuple[JsonObject, JsonObject]:
    """Videos for judging and for tuning, by part; missing folders are left out."""
    judged: JsonObject = {}
    tuned: JsonObject = {}
    if data.tuning is not None:
        tuned["approaches"] = read_approaches(data.tuning, each=EACH_TUNED)
    if data.looming is not None:
        judged["approaches"] = judged_approaches(data, EACH_OF_A_ROW)
    if data.clips is not None:
        groups = clip_groups(read_clips(data.clips))
        for group, parts in (("held out", judged), ("chosen on", tuned)):
            if group in groups:
                parts["real clips"] = groups[group]
    if not judged:
        raise Skip("no data: neither the folder `clips` nor `looming` was given.")
    return judged, tuned


def _not_given(data: Data) -> str:
    """A sentence about the folders that were not given; empty if all were."""
    missing = [name for name in ("clips", "looming", "tuning") if getattr(data, name) is None]
    return f" *Skipped, as not given:* {', '.join(missing)}." if missing else ""


def _figures(part: str, scored: Mapping[str, Scored], source: object, seed: int) -> JsonObject:
    """Stress -> row -> figures; approaches by stress and in total, real clips in total."""
    stresses: dict[str, list[str]] = {}
    if isinstance(source, Approaches):
        for clip, stress in source.stress.items():
            stresses.setdefault(stress, []).append(clip)
        stresses = dict(sorted(stresses.items()))
    stresses[part] = [report.name for report in scored["default"].reports]
    out: JsonObject = {}
    for stress, clips in stresses.items():
        members = set(clips)
        own = {name: [r for r in s.reports if r.name in members] for name, s in scored.items()}
        out[stress] = {}
        for name, reports in own.items():
            summary = summarise(reports).as_dict()
            out[stress][name] = {key: summary[key] for key, *_ in MEASURES} | {
                "signs": summary["signs"],
                "signs_detected": summary["signs_detected"],
                "eq7_change": None if name == "default" else paired(own["default"], reports, seed),
            }
    return out


def _report(result: Result) -> str:
    judged, tuned = result.figures["judged"], result.figures["tuned"]
    columns = sorted(judged, key=lambda c: (c == "real clips", c == "approaches", c))
    same = [d.title for d in DEPARTURES if _changes_nothing(judged, d.title)]
    ablated = ["default", *(d.title for d in DEPARTURES if d.title not in same), "paper"]
    parts = [
        "Each row is `default` with one departure replaced by the paper's way. **Bold**: the row is better than "
        "`default` there.\n"
    ]
    if same:
        parts.append(
            f"These rows change no figure in any column and are left out of the tables: {'; '.join(same)}. They matter "
            "only where a detection is missing and the gate rejects the prediction, or for close votes; these videos "
            "have too few such frames for a verdict.\n"
        )
    for figure, title, digits, sign in MEASURES:
        rows = [[title, *columns]]
        rows += [[name, *(_cell(judged[c], name, figure, digits, sign) for c in columns)] for name in ablated]
        parts.append(table(rows))
    parts.append(
        "Change of the mean Eq. 7 compared with `default`, with a 95 % interval over videos. Above 0, `default` is "
        "better. The table also has values that neither preset uses.\n"
    )
    parts.append(_changes(judged, tuned))
    parts.append(_worse_than_paper(judged, columns))
    parts.append(_verdict(judged, tuned))
    parts.append(
        "The approaches keep the annotation of their photographs, which leaves a margin around some signs; the real "
        "clips are annotated at the sign's edge. The inset of `default` lies between the two: of the insets that were "
        "tried, it is the best on its worst video among the tuned ones.\n"
    )
    return "\n".join(parts)


def _changes_nothing(judged: JsonMapping, name: str) -> bool:
    return all(
        by_row[name][figure] == by_row["default"][figure]
        for by_row in judged.values()
        if name in by_row
        for figure, *_ in MEASURES
    )


def _cell(by_row: JsonMapping, name: str, figure: str, digits: int, sign: int) -> str:
    if name not in by_row:
        return "not run"
    value, own = by_row[name][figure], by_row["default"][figure]
    text = number(value, digits)
    better = name != "default" and None not in (value, own) and round(sign * (value - own), 6) > 0
    return f"**{text}**" if better else text


def _changes(judged: JsonMapping, tuned: JsonMapping) -> str:
    columns = [
        (f"{part}, {name}", parts[part])
        for part in ("approaches", "real clips")
        for name, parts in (("judged", judged), ("tuned", tuned))
        if part in parts
    ]
    names = [*(d.title for d in DEPARTURES), *IN_QUESTION, "paper"]
    rows = [["", *(title for title, _ in columns)]]
    for name in names:
        cells = (change_text(by_row[name]["eq7_change"]) if name in by_row else "not run" for _, by_row in columns)
        rows.append([name, *cells])
    return table(rows)


def _worse_than_paper(judged: JsonMapping, columns: Sequence[str]) -> str:
    worse, better, same = [], 0, 0
    for column in columns:
        for figure, title, digits, sign in MEASURES:
            mine, theirs = judged[column]["default"][figure], judged[column]["paper"][figure]
            if mine is None or theirs is None:
                continue
            gain = round(sign * (mine - theirs), 6)
            better, same = better + (gain > 0), same + (gain == 0)
            if gain < 0:
                worse.append(f"{column}, {title.lower()}: {number(mine, digits)} against {number(theirs, digits)}")
    return (
        f"`default` compared with `paper` on these videos, over all figures and columns: better in {better}, equal "
        f"in {same}, worse in {len(worse)}{': ' + '; '.join(worse) if worse else ''}. *Under stress* has more "
        "approaches.\n"
    )


def _verdict(judged: JsonMapping, tuned: JsonMapping) -> str:
    """Rows whose mean of Eq. 7 is below that of ``default`` on all tuned data, and no worse on judged data."""
    found = []
    for name in (*(d.title for d in DEPARTURES), *IN_QUESTION):
        changes = _parts(tuned, name)
        own = _parts(judged, name)
        if not changes or not own or None in (*changes, *own):
            continue
        clearly = all(c["high"] <= 0 and c["change"] < 0 for c in changes)
        harmless = all(c["change"] <= 0 for c in own) and not _costs(judged, name)
        if clearly and harmless:
            found.append(name)
    if not found:
        return "No row is better than `default` on all tuned data and no worse on the judged, so `default` stays.\n"
    return f"Better than `default` on all tuned data and no worse on the judged: {', '.join(found)}.\n"


def _parts(side: JsonMapping, name: str) -> list[Any]:  # Any: objects of JSON; None where nothing was paired
    """The changes of a row on approaches and on real clips, if it ran on them."""
    return [
        side[part][name]["eq7_change"] for part in ("approaches", "real clips") if part in side and name in side[part]
    ]


def _costs(judged: JsonMapping, name: str) -> bool:
    return any(
        None not in (by_row[name][figure], by_row["default"][figure])
        and sign * (by_row[name][figure] - by_row["default"][figure]) < 0
        for by_row in judged.values()
        if name in by_row
        for figure, _, _, sign in MEASURES
        if figure != "mean_error"
    )


EXPERIMENT = Experiment(
    "ablations",
    "Ablation of the departures from the paper",
    "Which departures of the preset `default` from `paper` help, and under which stress?",
    _run,
    _report,
    optional=("clips", "looming", "tuning"),
)
