"""Tables I and II of the paper with our columns beside its own, and the figures in which ours are worse."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from scipy.stats import beta

from benchmarks.reporting import paper_figures as paper
from benchmarks.reporting.markdown import table
from tsr_engine.evaluation.tracking import VideoReport
from tsr_engine.json_shapes import JsonMapping, JsonObject


def tables(columns: Mapping[str, JsonMapping]) -> str:
    """Tables I and II as one table.

    Args:
        columns: heading -> figures of ``TrackingSummary`` with ``detection_ms`` and ``classification_ms``, CPU time.
    """
    ours, theirs = list(columns.values()), paper.SYSTEMS
    rows = [
        ["", *(f"{s.name}, TS2010" for s in theirs), *columns],
        ["physical signs", *(str(paper.SIGNS) for _ in theirs), *(str(c["signs"]) for c in ours)],
        ["frames", *(f"{paper.FRAMES:,}" for _ in theirs), *(f"{c['frames']:,}" for c in ours)],
        ["signs detected", *(str(s.detected) for s in theirs), *(str(c["signs_detected"]) for c in ours)],
        ["false detections (tracks)", *(str(s.false) for s in theirs), *(str(c["false_tracks"]) for c in ours)],
        [
            "detection rate",
            *(paper.truncated_percent(s.detected, paper.SIGNS) for s in theirs),
            *(_percent(c["signs_detected"], c["signs"]) for c in ours),
        ],
        [
            "false detections in 1000 frames (the paper's rate a frame disagrees with its own counts)",
            *(f"{1e3 * s.false / paper.FRAMES:.3f}" for s in theirs),
            *(f"{1e3 * c['false_tracks'] / max(1, c['frames']):.3f}" for c in ours),
        ],
        [
            "ms a frame, detection and tracking (ours: CPU time)",
            *(f"{1e3 * s.detection_s:.0f} ({s.platform})" for s in theirs),
            *(_ms(c, "detection_ms") for c in ours),
        ],
        ["signs classified", *(str(s.classified) for s in theirs), *(str(c["signs_classified"]) for c in ours)],
        [
            "rate with fusion, of the detected signs",
            *(paper.truncated_percent(s.classified, s.detected) for s in theirs),
            *(_percent(c["signs_classified"], c["signs_detected"]) for c in ours),
        ],
        [
            "overall rate, of all signs",
            *(paper.truncated_percent(s.classified, paper.SIGNS) for s in theirs),
            *(_percent(c["signs_classified"], c["signs"]) for c in ours),
        ],
        [
            "ms a frame, classification (ours: CPU time)",
            *(f"{1e3 * s.classification_s:.0f} ({s.platform})" for s in theirs),
            *(_ms(c, "classification_ms") for c in ours),
        ],
    ]
    return table(rows)


def shortfalls(figures: JsonMapping, data: str) -> str:
    """Sentences on each of the paper's three rates and on Eq. 7: whether they are reached, and the uncertainty.

    Args:
        figures: figures of ``TrackingSummary`` for the shipped preset.
        data: name of the data in the sentences.
    """
    own = paper.SYSTEMS[-1]
    lines = [
        _rate("physical signs detected", figures["signs_detected"], figures["signs"], own.detected, paper.SIGNS, data),
        _rate(
            "detected signs classified", figures["signs_classified"], figures["signs_detected"],
            own.classified, own.detected, data,
        ),
        _false(figures["false_tracks"], figures["frames"], own.false, data),
    ]  # fmt: skip
    if figures["mean_error"] is not None:
        better = figures["mean_error"] <= paper.EQ7_ONLINE
        lines.append(
            f"- *Eq. 7*, {data}: {figures['mean_error']:.4f}, {'below' if better else '**above**'} the paper's "
            f"{paper.EQ7_ONLINE} ({paper.WHERE_EQ7})."
        )
    return "\n".join(lines) + "\n"


def sign_notes(reports: Iterable[VideoReport]) -> dict[str, list[JsonObject]]:
    """Each sign that was missed, misread or split, and each track on no sign, for the report."""
    notes: dict[str, list[JsonObject]] = {"missed": [], "misread": [], "split": [], "false": []}
    for video in reports:
        for sign in video.signs:
            about = {"clip": video.name, "sign": sign.track_id, "class": sign.class_id, "frames": sign.frames}
            if not sign.ids:
                notes["missed"].append(about)
                continue
            if sign.predicted_class != sign.class_id:
                notes["misread"].append(about | {"read": sign.predicted_class})
            if len(sign.ids) > 1:
                notes["split"].append(about | {"ids": len(sign.ids)})
        notes["false"] += [{"clip": video.name, "track": track} for track in video.false_tracks]
    return notes


def _percent(part: int, whole: int) -> str:
    return f"{100 * part / whole:.2f} %" if whole else "-"


def _ms(column: JsonMapping, name: str) -> str:
    value = column.get(name)
    return "not timed" if value is None else f"{value:.1f}"


def _rate(what: str, part: int, whole: int, paper_part: int, paper_whole: int, data: str) -> str:
    if not whole:
        return f"- *{what}*, {data}: there are none."
    reached = part / whole >= paper_part / paper_whole
    low, high = _interval(part, whole)
    verdict = "reaches" if reached else "**falls short of**"
    text = (
        f"- *{what}*, {data}: {part} of {whole} ({100 * part / whole:.2f} %) {verdict} the paper's "
        f"{paper.truncated_percent(paper_part, paper_whole)}."
    )
    return f"{text} 95 % interval of our rate (binomial): {100 * low:.1f} to {100 * high:.1f} %."


def _false(false: int, frames: int, paper_false: int, data: str) -> str:
    own, theirs = 1e3 * false / max(1, frames), 1e3 * paper_false / paper.FRAMES
    verdict = "no more than" if own <= theirs else "**more than**"
    text = (
        f"- *false tracks*, {data}: {false} in {frames:,} frames ({own:.3f} in 1000), {verdict} the paper's "
        f"{paper_false} in {paper.FRAMES:,} ({theirs:.3f} in 1000)."
    )
    return text + (f" With none in {frames:,}, up to {3e3 / max(1, frames):.2f} in 1000 are possible." * (not false))


def _interval(part: int, whole: int) -> tuple[float, float]:
    """Clopper and Pearson's 95 % interval of a share."""
    low = 0.0 if part == 0 else float(beta.ppf(0.025, part, whole - part + 1))
    high = 1.0 if part == whole else float(beta.ppf(0.975, part + 1, whole - part))
    return low, high
