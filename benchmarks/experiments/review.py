"""Measures the review tool in the browser: first correction, stepping, seeking, playing, long drives."""

from __future__ import annotations

import tempfile
from pathlib import Path

from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.markdown import table
from benchmarks.review.browser_session import open_browser_session, open_review
from benchmarks.review.first_use import first_correction
from benchmarks.review.interaction_times import measure_early_seeks, measure_handling
from benchmarks.review.long_drive import lane_intervals, time_first_paint
from sample_videos import SHIPPED
from tsr_engine.json_shapes import JsonObject

CLIP = "SH13_9f8bd8.mp4"
"""Clip of 1280x720 px with a key frame every 128 pictures, the hardest one to seek in."""


def _clip(data: Data, home: Path) -> tuple[str, JsonObject]:
    clip = SHIPPED[0].video
    truth = SHIPPED[0].truth.read_bytes()
    if data.clips is not None and (data.clips / CLIP).is_file():
        clip = data.clips / CLIP
        truth = (data.clips / "gt" / CLIP).with_suffix(".csv").read_bytes()
    with open_browser_session(home, (clip.parent,), sample=False) as session:
        video = session.server.add_video(clip)["id"]
        # An imported run replaces the engine's, since only the page is timed here.
        where = f"/videos/{video}/imports?as=run&name=boxes&format=tracks-csv"
        run = session.server.call("POST", where, truth, "application/octet-stream")["id"]
        page = session.page()
        open_review(page, video, run)
        page.wait_for_timeout(1000)
        early = measure_early_seeks(page, data.seed)
        page.wait_for_timeout(1000)
        return clip.name, {"early": early, **measure_handling(page, data.seed)}


def _long(home: Path) -> JsonObject:
    from tests.app.long_run import make_long_run

    made = make_long_run(home)
    found: JsonObject = {}
    with open_browser_session(home, (home,), sample=False) as session:
        found["first_paint"] = [time_first_paint(session, made.video_id, made.run_id) for _ in range(4)]
        page = session.page()
        open_review(page, made.video_id, made.run_id)
        page.wait_for_timeout(2000)
        found["lanes"] = {kind: lane_intervals(page, kind) for kind in ("pan", "zoom", "seek")}
    return found


def _run(data: Data) -> Result:
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        for name in ("first", "clip", "long"):
            (place / name).mkdir()
        figures: JsonObject = {"first": first_correction(place / "first")}
        clip, figures["clip"] = _clip(data, place / "clip")
        figures["long"] = _long(place / "long")
    return Result(
        data=f"The sample drive in a new data folder; {clip} with its ground truth as boxes; a synthetic drive of "
        "132,400 frames with 5,000 tracks. Headless Chromium without a GPU, 1280x720, on the machine of the server.",
        figures=figures,
        settings={"seed": data.seed},
    )


def _report(result: Result) -> str:
    f = result.figures
    first, clip, long = f["first"], f["clip"], f["long"]
    start = f"{first['corrected']:.0f} s (library {first['library']:.1f}, first track {first['first_track']:.1f})"
    rows = [
        ["what", "figure", "bar"],
        ["from the command in a new folder to a saved correction on the sample drive", start, "120 s"],
    ]
    for name, words, bar in (
        ("step", "next frame", "p95 40 ms"),
        ("back", "previous frame", ""),
        ("seek", "seek to a new position, first picture (preview frame, then sharp)", "p95 150 ms"),
        ("early", "the same right after the import", "p95 150 ms"),
    ):
        t = clip[name]
        rows.append([words, f"p50 {t['p50']:.0f}, p95 {t['p95']:.0f}, max {t['max']:.0f} ms of {t['n']}", bar])
    play = clip["play"]
    playing = f"playing {play['seconds']:.0f} s at {play['rate']:.0f} frames/s"
    shown = f"{play['frames']} of {play['span']} frames shown, {play['bare']} without their overlay"
    rows.append([playing, shown, "no overlay dropped"])
    paint = [whole for _, whole in long["first_paint"]]
    later = f"{min(paint[1:]) / 1e3:.2f} to {max(paint[1:]) / 1e3:.2f} s"
    first_paint = f"{paint[0] / 1e3:.2f} s right after the start of the server, then {later}"
    rows.append(["132,400 frames: first paint with tracks and lanes", first_paint, "1 s"])
    for kind, t in long["lanes"].items():
        interval = f"display interval p50 {t['interval_p50']:.1f}, p95 {t['interval_p95']:.1f} ms"
        text = f"script time p95 {t['work_p95']:.1f} ms; {interval}"
        rows.append([f"132,400 frames: {kind} the lanes", text, "16.7 ms"])
    workers = ", ".join(str(mb) for mb in first["workers_mb"])
    rows.append(["idle server", f"{first['server_mb']:.0f} MB (workers {workers} MB)", "250 MB"])
    return table(rows) + "\n"


EXPERIMENT = Experiment(
    "review",
    "The review tool",
    "How fast is the page, also on a long drive?",
    _run,
    _report,
    optional=("clips",),
)
