"""README's table of figures says what the committed results say."""

from __future__ import annotations

import json
from typing import Any

import pytest

from benchmarks.experiment import ROOT

README = (ROOT.parent / "README.md").read_text(encoding="utf-8")
PEERS = ("ByteTrack", "C-BIoU", "OC-SORT", "SORT")
STRESSES = ("blur", "illumination", "occlusion", "shake", "steady", "turn")


def figures(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((ROOT / "results" / f"{name}.json").read_text())["figures"]
    return found


def row(start: str) -> str:
    lines = [line for line in README.splitlines() if line.startswith(f"| {start}")]
    assert len(lines) == 1, start
    return lines[0]


def percent(share: float) -> str:
    return f"{100 * share:.1f} %".replace("100.0", "100")


def detection() -> list[str]:
    curves = figures("detection")["curves"]
    return [f"{curves['ACF']['ap']:.3f}, with prior {curves['ACF and prior']['ap']:.3f}"]


def recall() -> list[str]:
    curves = figures("detection")["curves"]
    alone, prior = (
        " / ".join(f"{curves[name]['recall_at'][at]:.3f}" for at in ("0.03", "0.1", "1.0"))
        for name in ("ACF", "ACF and prior")
    )
    return [f"{alone}, with prior {prior}"]


def classification() -> list[str]:
    f = figures("fusion")
    return [f"{f['single']:.3f}, {f['crop_ms']:.2f} ms each", f"of {f['tracks']} held-out tracks"]


def fusion() -> list[str]:
    f = figures("fusion")
    folds = f["folds"]
    fewer, pooled = (
        sum(a < b for a, b in zip(each["rates"]["clamped"], each["rates"]["equal"], strict=True)) for each in (f, folds)
    )
    assert fewer == 0
    part, whole = f["rates"]["clamped"][-1], folds["rates"]["clamped"][-1]
    return [
        f"over {f['frames'][-1]} frames",
        f"{part:.3f} of those {f['tracks']}",
        f"{whole:.4f} of all {folds['tracks']:,}",
        f"at {pooled} of {len(folds['frames'])} numbers of frames fewer than with equal weights",
    ]


def clips() -> list[str]:
    f = figures("clips")["default"]["held out"]
    return [
        f"{f['signs_detected']} of {f['signs']}, {f['false_tracks']}, {f['ids_per_sign']:.2f}",
        f"{f['frames']} frames",
    ]


def coverage() -> list[str]:
    f = figures("clips")["default"]["held out"]
    return [f"{percent(f['coverage'])}, {f['mean_error']:.3f} (the paper 0.1175)"]


def read_right() -> list[str]:
    f = figures("clips")["default"]["held out"]
    return [f"{f['signs_classified']} of {f['signs']}"]


def peers() -> list[str]:
    groups = figures("trackers")["groups"]
    for group in (*STRESSES, "all approaches", "held out"):
        shared = [groups[group][peer]["shared"] for peer in PEERS]
        assert all(s["ours"] < s["theirs"] for s in shared), group
    gains = [round(100 * (1 - s["ours"] / s["theirs"])) for s in (groups["held out"][p]["shared"] for p in PEERS)]
    span = str(min(gains)) if min(gains) == max(gains) else f"{min(gains)} to {max(gains)}"
    behind = {
        (peer, group): max(
            groups[group][peer][name] - groups[group]["default"][name] for name in ("HOTA", "IDF1", "MOTA")
        )
        for group in STRESSES
        for peer in PEERS
    }
    assert all(groups[g]["default"]["coverage"] >= groups[g][peer]["coverage"] for g in groups for peer in PEERS)
    ((peer, group), most) = next((where, by) for where, by in behind.items() if by > 0)
    assert sum(by > 0 for by in behind.values()) == 1
    return [
        f"below {peer}'s under {group}, by up to {most:.3f}",
        f"({span} %)",
        f"{figures('stress')['all']['default']['videos']} simulated approaches",
    ]


def quarter() -> list[str]:
    found = figures("frame_rates")["groups"]["held out"]["4"]
    ours = found["default"]
    spans = []
    for key, form in (
        ("coverage", lambda v: f"{100 * v:.1f}"),
        ("mean_error", "{:.3f}".format),
        ("ids_per_sign", "{:.2f}".format),
    ):
        values = sorted(found[peer][key] for peer in PEERS)
        spans.append(f"{form(values[0])} to {form(values[-1])}" + (" %" if key == "coverage" else ""))
    return [
        f"{percent(ours['coverage'])}, {ours['mean_error']:.3f}, {ours['ids_per_sign']:.2f} "
        f"(peers tuned for that rate: {', '.join(spans)})"
    ]  # fmt: skip


def gaps() -> list[str]:
    found = {name: f["20"] for name, f in figures("gaps")["groups"]["held out"].items() if "20" in f}
    said = {name: f"{f['error']:.3f}, {100 * f['held']:.0f} %" for name, f in found.items()}
    return [
        f"{said['default']} (filter alone {said['KF alone']}; OpenCV's CSRT {said['CSRT']})",
        f"{said['default, camera unknown']} (filter alone {said['KF alone, camera unknown']})",
        f"{found['default']['gaps']} starts",
    ]


def review() -> list[str]:
    f = figures("review")["clip"]
    assert f["play"]["bare"] == 0
    return [f"p95 {f['step']['p95']:.0f} ms, {f['seek']['p95']:.0f} ms, {f['play']['rate']} frames/s"]


def network() -> list[str]:
    f = figures("yolo_time")
    ratios = (f["ratios"][part]["YOLO11n, 736x576"] for part in ("detection", "whole engine"))
    ours, theirs, whole = (
        f[where][what]["median"]
        for where, what in (("scenes", "detection"), ("scenes", "YOLO11n, 736x576"), ("drive", "whole engine"))
    )
    return [
        ", ".join(f"{ratio:.2f}" for ratio in ratios),
        f"{ours:.0f} ms against {theirs:.0f}; the whole engine {whole:.0f} ms a frame",
    ]


def memory() -> list[str]:
    first, *_, last = figures("scale")["real"]
    return [f"{first['peak_mb']:.0f} MB after a minute, {last['peak_mb']:.0f} at the end", f"{last['frames']:,} frames"]


def corrections() -> list[str]:
    f = figures("retraining")
    said = []
    for case in ("as filmed", "dim camera"):
        before, after = f[case]["before"], f[case]["after"]
        said.append(f"{before['mean_error']:.3f} to {after['mean_error']:.3f}")
        said.append(
            f"{before['ap50']:.3f} " + ("before and after" if case == "as filmed" else f"to {after['ap50']:.3f}")
        )
    return said


def exports() -> list[str]:
    found = figures("exports")["formats"]
    most = max(f["seconds"] for f in found), max(f["peak_mb"] for f in found)
    return [f"at most {most[0]:.1f} s and {most[1]} MB"]


def recordings() -> list[str]:
    copied, encoded = figures("recordings")["drives"]
    return [
        f"{copied['megabytes']:.1f} MB in {copied['seconds'][0]:.1f} s with packets copied, "
        f"{encoded['megabytes']:.1f} MB in {encoded['seconds'][0]:.1f} s encoded anew"
    ]


ROWS = {
    "detection, AP": detection,
    "recall at 0.03": recall,
    "classification of single crops": classification,
    "signs read right over": fusion,
    "real dash-cam clips": clips,
    "the same clips: coverage": coverage,
    "the same clips: signs classified": read_right,
    "the same detections through tuned": peers,
    "the three clips at a quarter": quarter,
    "the same clips with detections withheld": gaps,
    "review screen": review,
    "time of detection": network,
    "memory of a run": memory,
    "three clips corrected": corrections,
    "export of 132,400": exports,
    "recording for Rerun": recordings,
}
"""How a row of the table begins -> what it says, from the results."""


@pytest.mark.parametrize("start", ROWS)
def test_a_row_says_what_was_measured(start: str) -> None:
    said = row(start)
    for figure in ROWS[start]():
        assert figure in said, f"README: {figure!r} is not in {said!r}"


def test_every_row_is_checked() -> None:
    table = README.split("## What it reaches today")[1].split("\n\n")[1].splitlines()[2:]
    assert len(table) == len(ROWS)
