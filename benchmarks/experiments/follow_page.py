"""Following on the review page, with real keys in a real browser."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from benchmarks.experiment import Data, Experiment, Result
from benchmarks.following.visible_signs import signs_of
from benchmarks.reporting.markdown import met, table
from benchmarks.review.browser_session import BrowserSession, open_browser_session
from benchmarks.review.faulty_runs import Case
from benchmarks.review.following_actions import draw_missed, extend_late_tracks, time_first_proposal
from sample_videos import SHIPPED
from tsr_engine.evaluation.track_tables import read_clip_truth
from tsr_engine.json_shapes import JsonObject

PRESSES = 10
BARS = {"late": 3, "missed": 4}
"""Largest number of actions per sign."""
MAX_FIRST_MS = 200.0
"""Largest time from the key to the first proposed box, ms."""
_MIN_FRAMES = 30
"""Least number of frames in which a sign is visible."""
_LABEL = 14


def _run(data: Data) -> Result:
    figures: JsonObject = {"late": [], "missed": []}
    with (
        tempfile.TemporaryDirectory() as home,
        open_browser_session(Path(home), (SHIPPED[0].video.parent,), sample=False) as session,
    ):
        for clip in SHIPPED:
            added = session.server.add_video(clip.video)
            cases = _cases(clip.truth, int(added["width"]), int(added["height"]))
            names = _names(session)
            figures["late"] += extend_late_tracks(session, added["id"], cases, names)
            figures["missed"] += draw_missed(session, added["id"], cases, names)
            if "first" not in figures:
                figures["first"] = time_first_proposal(session, added["id"], cases, PRESSES, data.seed)
    return Result(
        data="The sample drives. The ground truth of each sign that is visible for "
        f"{_MIN_FRAMES} frames becomes a track. *Late*: the track begins with the last third of the sign's life. "
        f"*Missed*: the track is absent. The first proposed box: T is pressed {PRESSES} times on the first sample "
        "drive, on a random track in a random frame, on a page that has been open for some seconds; the frame is shown "
        "for a second before the key. Chromium without a GPU, 1280x720, on the machine of the server.",
        figures=figures,
        settings={"seed": data.seed},
    )


def _cases(truth: Path, width: int, height: int) -> dict[int, Case]:
    lives = [sign.life for sign in signs_of(read_clip_truth(truth), width, height)]
    # one that is hidden meanwhile would be two tracks
    whole = [dict(life) for life in lives if max(life) - min(life) + 1 == len(life) >= _MIN_FRAMES]
    return {number: Case("", _LABEL, life) for number, life in enumerate(whole, start=1)}


def _names(session: BrowserSession) -> dict[int, str]:
    return {label["id"]: label["name"] for label in session.server.call("GET", "/labels")}


def _report(result: Result) -> str:
    f = result.figures
    rows = [["a track is", "signs", "actions a sign, on average", "at most", "bar", "right afterwards", "keys"]]
    for kind, bar in BARS.items():
        counts = [len(row["actions"]) for row in f[kind]]
        share = np.mean([row["share"] for row in f[kind]])
        keys = " ".join(f"`{key}`" for key in max((row["actions"] for row in f[kind]), key=len))
        most = [str(max(counts)), f"{bar}, {met(max(counts) <= bar)}"]
        rows.append([kind, str(len(counts)), f"{np.mean(counts):.2f}", *most, f"{share:.3f}", keys])
    p50, p95 = np.percentile(f["first"]["ms"], [50, 95])
    return table(rows) + (
        "\n*Right afterwards*: share of the sign's life with an IoU of 0.7 after the proposed boxes are accepted.\n\n"
        f"From the key to the first proposed box on the screen: {p50:.0f} ms (median of {len(f['first']['ms'])}), "
        f"{p95:.0f} ms (95 %); bar {MAX_FIRST_MS:.0f} ms, {met(p95 <= MAX_FIRST_MS)}, "
        f"at a load of {f['first']['load']:.1f} on {result.machine['cores']} cores. "
        f"Each: {', '.join(f'{ms:.0f}' for ms in sorted(f['first']['ms']))} ms.\n"
    )


EXPERIMENT = Experiment(
    "follow_page",
    "Following on the review page",
    "How many actions extend a late track back to the first frame of its sign, or draw a missed sign over its whole "
    "life, and how soon does the first proposed box appear?",
    _run,
    _report,
)
