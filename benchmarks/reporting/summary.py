"""The table at the top of the report: one row for each headline figure, computed from the stored results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from benchmarks.experiment import Result
from benchmarks.reporting.markdown import table
from tsr_engine.json_shapes import JsonMapping

Figures = JsonMapping
"""Figures of experiments by their name."""

_PEERS = ("ByteTrack", "C-BIoU", "OC-SORT", "SORT")
_STRESSES = ("blur", "illumination", "occlusion", "shake", "steady", "turn")
_SCORES = ("HOTA", "IDF1", "MOTA")


class Row(NamedTuple):
    """One row.

    Attributes:
        what: name of the figure.
        needs: names of the experiments from which it is computed.
        value: computes the text of the figure.
        source: computes the text about data and command.
    """

    what: str
    needs: tuple[str, ...]
    value: Callable[[Figures], str]
    source: Callable[[Figures], str]


def summary(results: Path) -> str:
    """The section of the summary, in Markdown.

    Args:
        results: folder of the JSON files.

    Returns:
        A heading and a table of the rows whose experiments have results; empty without any. Figures of other processors
        follow. If results are older than their row and lack a figure, the row names it.
    """
    figures, elsewhere = {}, {}
    for path in sorted(results.glob("*.json")):
        result = Result.load(path)
        if not result.skipped:
            figures[result.name] = result.figures
            elsewhere[result.name] = result.elsewhere
    rows = [_cells(row, figures, elsewhere) for row in ROWS if all(name in figures for name in row.needs)]
    if not rows:
        return ""
    return "## Summary\n\n" + table([["what", "figure", "measured on"], *rows]) + "\n"


def _cells(row: Row, figures: Figures, elsewhere: Mapping[str, Mapping[str, str]]) -> list[str]:
    try:
        value, source = row.value(figures), row.source(figures)
    except KeyError as error:
        return [row.what, f"*Skipped:* the results have no {error}", f"run `python -m benchmarks {row.needs[0]}`"]
    for name in row.needs:
        for processor, headline in sorted(elsewhere[name].items()):
            value += f"; on {processor}: {headline.rpartition(' (commit')[0]}"
    return [row.what, value, source]


def percent(share: float) -> str:
    """A share as a percentage: ``0.972`` is ``97.2 %``, and ``1.0`` is ``100 %``."""
    return f"{100 * share:.1f} %".replace("100.0", "100")


def _detection(f: Figures) -> str:
    curves = f["detection"]["curves"]
    return f"{curves['ACF']['ap']:.3f}, with prior {curves['ACF and prior']['ap']:.3f}"


def _recall(f: Figures) -> str:
    curves = f["detection"]["curves"]
    alone, prior = (
        " / ".join(f"{curves[name]['recall_at'][at]:.3f}" for at in ("0.03", "0.1", "1.0"))
        for name in ("ACF", "ACF and prior")
    )
    return f"{alone}, with prior {prior}"


def _classification(f: Figures) -> str:
    return f"{f['fusion']['single']:.3f}, {f['fusion']['crop_ms']:.2f} ms a crop"


def _fusion(f: Figures) -> str:
    held, folds = f["fusion"], f["fusion"]["folds"]
    fewer, pooled = (
        sum(a < b for a, b in zip(each["rates"]["clamped"], each["rates"]["equal"], strict=True))
        for each in (held, folds)
    )
    part, whole = held["rates"]["clamped"][-1], folds["rates"]["clamped"][-1]
    return (
        f"{part:.3f} of {held['tracks']} held-out tracks; {whole:.4f} of all {folds['tracks']:,}, each quarter held "
        f"out once. Equal weights do better at {fewer} of {len(held['frames'])} numbers of frames, over all tracks at "
        f"{pooled} of {len(folds['frames'])}"
    )


def _clips(f: Figures) -> str:
    held = f["clips"]["default"]["held out"]
    return f"{held['signs_detected']} of {held['signs']}, {held['false_tracks']}, {held['ids_per_sign']:.2f}"


def _coverage(f: Figures) -> str:
    held = f["clips"]["default"]["held out"]
    return f"{percent(held['coverage'])}, {held['mean_error']:.3f} (the paper 0.1175)"


def _read_right(f: Figures) -> str:
    held, chosen = f["clips"]["default"]["held out"], f["clips"]["default"]["chosen on"]
    right = f"{held['signs_classified']} of {held['signs']}"
    return f"{right} (on the other three clips {chosen['signs_classified']} of {chosen['signs']})"


def _peers(f: Figures) -> str:
    groups = f["trackers"]["groups"]
    everywhere = (*_STRESSES, "all approaches", "held out")
    higher = [
        f"{peer} ({group})"
        for group in everywhere
        for peer in _PEERS
        if groups[group][peer]["shared"]["ours"] >= groups[group][peer]["shared"]["theirs"]
    ]
    shared = [groups["held out"][peer]["shared"] for peer in _PEERS]
    gains = [round(100 * (1 - one["ours"] / one["theirs"])) for one in shared]
    span = str(min(gains)) if min(gains) == max(gains) else f"{min(gains)} to {max(gains)}"
    error = f"{span} % lower on the clips; on simulated approaches " + (
        f"not lower than {', '.join(higher)}" if higher else "lower than each of them under every stress"
    )
    less = [
        f"{peer} ({group})"
        for group, found in groups.items()
        for peer in _PEERS
        if found["default"]["coverage"] < found[peer]["coverage"]
    ]
    coverage = f"coverage below {', '.join(less)}" if less else "coverage never below theirs"
    behind = {
        (peer, group): max(groups[group][peer][name] - groups[group]["default"][name] for name in _SCORES)
        for group in _STRESSES
        for peer in _PEERS
    }
    worse = [f"{peer}'s under {group} by up to {by:.3f}" for (peer, group), by in behind.items() if by > 0]
    scores = f"HOTA, IDF1 or MOTA below {', '.join(worse)}" if worse else "HOTA, IDF1 and MOTA never below theirs"
    return f"{error}; {coverage}; {scores}"


def _quarter(f: Figures) -> str:
    found = f["frame_rates"]["groups"]["held out"]["4"]
    ours = found["default"]
    spans = []
    for key, form in (
        ("coverage", lambda v: f"{100 * v:.1f}"),
        ("mean_error", "{:.3f}".format),
        ("ids_per_sign", "{:.2f}".format),
    ):
        values = sorted(found[peer][key] for peer in _PEERS)
        spans.append(f"{form(values[0])} to {form(values[-1])}" + (" %" if key == "coverage" else ""))
    own = f"{percent(ours['coverage'])}, {ours['mean_error']:.3f}, {ours['ids_per_sign']:.2f}"
    return f"{own} (peers tuned for that rate: {', '.join(spans)})"


def _gaps(f: Figures) -> str:
    found = {name: each["20"] for name, each in f["gaps"]["groups"]["held out"].items() if "20" in each}
    texts = {name: f"{each['error']:.3f}, {100 * each['held']:.0f} %" for name, each in found.items()}
    return (
        f"{texts['default']} (filter alone {texts['KF alone']}; OpenCV's CSRT {texts['CSRT']}). With unknown camera "
        f"motion: {texts['default, camera unknown']} (filter alone {texts['KF alone, camera unknown']})"
    )


def _review(f: Figures) -> str:
    clip = f["review"]["clip"]
    bare, rate = clip["play"]["bare"], clip["play"]["rate"]
    playing = "every overlay" if bare == 0 else f"{bare} frames without overlays"
    return f"p95 {clip['step']['p95']:.0f} ms, {clip['seek']['p95']:.0f} ms, {rate} frames/s with {playing}"


def _network(f: Figures) -> str:
    times = f["yolo_time"]
    peer = "YOLO11n, 736x576"
    detection, whole = (times["ratios"][part][peer] for part in ("detection", "whole engine"))
    ours, theirs, engine = (
        times[where][what]["median"]
        for where, what in (("scenes", "detection"), ("scenes", peer), ("drive", "whole engine"))
    )
    return (
        f"{detection:.2f} and {whole:.2f} of the network's time ({ours:.0f} ms against {theirs:.0f}; the whole engine "
        f"{engine:.0f} ms a frame)"
    )


def _yolo(f: Figures) -> str:
    scenes, group = f["yolo"]["scenes"], f["yolo"]["groups"]["held out"]
    ours, theirs = scenes["ACF"], scenes["YOLO11n"]
    text = (
        f"AP {ours['ap']:.3f} against {theirs['ap']:.3f}, recall at 0.1 false detections a picture "
        f"{ours['recall_at']['0.1']:.3f} against {theirs['recall_at']['0.1']:.3f}"
    )
    peers = [name for name in group if name in _PEERS]
    if not peers:
        return text
    best = max(peers, key=lambda name: float(group[name]["HOTA"]))
    mine, other = group["our engine"], group[best]
    return (
        f"{text}; on the clips with {best}, the best tracker there: coverage {percent(mine['coverage'])} against "
        f"{percent(other['coverage'])}, mean Eq. 7 {mine['mean_error']:.3f} against {other['mean_error']:.3f}, HOTA "
        f"{mine['HOTA']:.3f} against {other['HOTA']:.3f}"
    )


def _memory(f: Figures) -> str:
    first, *_, last = f["scale"]["real"]
    return f"{first['peak_mb']:.0f} MB after a minute, {last['peak_mb']:.0f} MB at the end"


def _corrections(f: Figures) -> str:
    texts = []
    for case in ("as filmed", "dim camera"):
        before, after = f["retraining"][case]["before"], f["retraining"][case]["after"]
        texts.append(
            f"{case}: AP from {before['ap50']:.3f} to {after['ap50']:.3f}, "
            f"Eq. 7 from {before['mean_error']:.3f} to {after['mean_error']:.3f}"
        )
    return "; ".join(texts)


def _corrected_on(f: Figures) -> str:
    dim = f["retraining"]["dim camera"]["after"]
    return f"the other three clips; dim: {dim['signs_detected']} of {dim['signs']} signs found; `retraining`"


def _exports(f: Figures) -> str:
    found = f["exports"]["formats"]
    return f"at most {max(one['seconds'] for one in found):.1f} s and {max(one['peak_mb'] for one in found)} MB"


def _recordings(f: Figures) -> str:
    copied, encoded = f["recordings"]["drives"]
    return (
        f"{copied['megabytes']:.1f} MB in {copied['seconds'][0]:.1f} s with packets copied, "
        f"{encoded['megabytes']:.1f} MB in {encoded['seconds'][0]:.1f} s re-encoded"
    )


def _held_out(f: Figures) -> str:
    return f"3 held-out dash-cam clips ({f['clips']['default']['held out']['frames']} frames); `clips`"


def _text(text: str) -> Callable[[Figures], str]:
    return lambda _: text


ROWS: tuple[Row, ...] = (
    Row(
        "detection: AP at IoU 0.5, 43 classes as one",
        ("detection",),
        _detection,
        _text("220 signs in 150 held-out GTSDB scenes; `detection`"),
    ),
    Row("detection: recall at 0.03 / 0.1 / 1 false detections a picture", ("detection",), _recall, _text("the same")),
    Row(
        "classification of single crops",
        ("fusion",),
        _classification,
        lambda f: f"GTSRB crops of {f['fusion']['tracks']} held-out tracks; `fusion`",
    ),
    Row(
        "signs classified correctly by fused votes",
        ("fusion",),
        _fusion,
        lambda f: f"the same, {f['fusion']['frames'][-1]} frames a track",
    ),
    Row("tracking: signs found, false tracks, ids per sign", ("clips",), _clips, _held_out),
    Row("tracking: coverage at IoU 0.5 from 20 px, mean Eq. 7", ("clips",), _coverage, _text("the same")),
    Row("tracking: signs classified correctly", ("clips",), _read_right, _text("the same")),
    Row(
        "tracking compared with tuned ByteTrack, C-BIoU, OC-SORT and SORT on the same detections: Eq. 7",
        ("trackers", "stress"),
        _peers,
        _text("the same clips and simulated approaches; `trackers`"),
    ),
    Row(
        "tracking at a quarter of the frame rate: coverage, mean Eq. 7, ids per sign",
        ("frame_rates",),
        _quarter,
        _text("the same clips; `frame_rates`"),
    ),
    Row(
        "tracking with detections withheld: Eq. 7 and share at IoU 0.5 after 20 frames",
        ("gaps",),
        _gaps,
        lambda f: f"{f['gaps']['groups']['held out']['default']['20']['gaps']} starts in the same clips; `gaps`",
    ),
    Row(
        "review screen, 1280x720: next frame, seek, playback",
        ("review",),
        _review,
        _text("Chromium on the same machine; `review`"),
    ),
    Row(
        "time of detection and of the whole engine, compared with a YOLO11n-size network",
        ("yolo_time",),
        _network,
        _text("720x576, signs from 16 px, one thread, 15 GTSDB scenes and the sample drive; `yolo_time`"),
    ),
    Row(
        "accuracy compared with a YOLO11n that a GPU trained on the same scenes",
        ("yolo",),
        _yolo,
        _text("150 held-out GTSDB scenes, the three held-out clips; `yolo`"),
    ),
    Row(
        "memory of a long run",
        ("scale",),
        _memory,
        lambda f: f"{f['scale']['real'][-1]['frames']:,} frames of 720x576; `scale`",
    ),
    Row("retraining on three corrected clips (four signs)", ("retraining",), _corrections, _corrected_on),
    Row(
        "export of a long drive, any format",
        ("exports",),
        _exports,
        _text("132,400 frames with 5,000 tracks; `exports`"),
    ),
    Row("recording for Rerun", ("recordings",), _recordings, _text("300 frames at 720p; `recordings`")),
)
