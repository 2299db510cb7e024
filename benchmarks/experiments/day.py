"""A day at the review screen: actions and seconds per track of an annotator who knows the ground truth."""

from __future__ import annotations

import tempfile
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.reporting.markdown import met, table
from benchmarks.review.browser_session import READY, BrowserSession, open_browser_session
from benchmarks.review.faulty_runs import KINDS, ROUNDS, make_faulty_run
from benchmarks.review.simulated_annotator import SimulatedAnnotator, Work
from benchmarks.videos.clips import read_clips
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.track_table import TrackTable

CLIPS = ("03_c0da85", "SH4_70b651", "SH13_9f8bd8")
FINAL_FIGURES = ("precision", "recall", "signs_classified")
"""Figures of the finished work against the ground truth."""
_LABELS = "(tsr.store.get().labels ?? tsr.store.get().classes)"
BARS = {"right": 1.5, "box, label and end": 4.0}
"""Largest number of actions per track, by kind."""


def _run(data: Data) -> Result:
    pairs = read_clips(data.need("clips"))
    missing = [name for name in CLIPS if name not in pairs]
    if missing:
        raise Skip(f"the folder `clips` lacks {', '.join(missing)}.")
    chosen = {name: pairs[name] for name in CLIPS}
    figures: JsonObject = {"now": _day(chosen, data.seed, None)}
    if data.before is not None:
        figures["before"] = _day(chosen, data.seed, data.before)
    return Result(
        data=f"Three clips with ground truth ({', '.join(CLIPS)}), each as {ROUNDS} runs: the ground truth with "
        "planted errors. The errors: a wrong label; a box that is off by 40 % of its width where the sign is largest; "
        "a track that continues for 12 frames after its sign is gone; all three; a missing sign; a track on no sign.",
        figures=figures,
        settings={"seed": data.seed},
    )


def _day(clips: Mapping[str, tuple[Path, TrackTable]], seed: int, code: Path | None) -> JsonObject:
    """The whole day with one version of the tool; ``code``: checkout of another version."""
    done: list[Work] = []
    left: list[dict[str, float]] = []
    with tempfile.TemporaryDirectory() as home:
        roots = (next(iter(clips.values()))[0].parent,)
        with open_browser_session(Path(home), roots, sample=False, code=code) as session:
            for path, truth in clips.values():
                video = session.server.add_video(path)
                rows = path.parent / "gt" / f"{path.stem}.csv"
                given = _import_table(session, video, rows.read_bytes(), "truth")
                for turn in range(ROUNDS):
                    run, found = _correct_run(session, video, truth, turn, seed)
                    path_and_query = f"/compare?reference=truth:{given}&candidate=annotation:{run}"
                    figures = session.server.call("GET", path_and_query)["figures"]
                    done += found
                    left.append({name: figures[name]["value"] for name in FINAL_FIGURES})
    return {
        "kinds": _by_kind(done),
        "tracks": len(done),
        "actions": float(np.mean([len(work.actions) for work in done])),
        "left": {name: min(one[name] for one in left) for name in FINAL_FIGURES},
    }


def _correct_run(
    session: BrowserSession, video: JsonMapping, truth: TrackTable, turn: int, seed: int
) -> tuple[str, list[Work]]:
    size = int(video["width"]), int(video["height"])
    content, cases = make_faulty_run(truth, size, int(video["frames"]), turn, seed)
    run = _import_table(session, video, content, "run")
    page = session.page()
    page.get_by_role("link", name=f"Review {video['name']}").click()  # the newest run, which is this one
    page.wait_for_function(f"run => {READY} && tsr.store.get().review.run.id === run", arg=run)
    page.wait_for_function(f"() => {_LABELS}?.length")
    names = {label["id"]: label["name"] for label in page.evaluate(f"() => {_LABELS}")}
    found = SimulatedAnnotator(page, cases, names).work_through()
    page.context.close()
    return run, found


def _import_table(session: BrowserSession, video: JsonMapping, content: bytes, kind: str) -> str:
    """Import a table into a video as a run or as ground truth; returns the id."""
    path_and_query = f"/videos/{video['id']}/imports?as={kind}&name={kind}&format=tracks-csv"
    return str(session.server.call("POST", path_and_query, content, "application/octet-stream")["id"])


def _by_kind(done: Sequence[Work]) -> JsonObject:
    kinds: dict[str, list[Work]] = defaultdict(list)
    for work in done:
        kinds[work.kind].append(work)
    return {
        kind: {
            "tracks": len(some),
            "actions": float(np.mean([len(work.actions) for work in some])),
            "seconds": float(np.median([work.seconds for work in some])),
            "example": some[-1].actions,
        }
        for kind, some in kinds.items()
    }


def _report(result: Result) -> str:
    now, before = result.figures["now"], result.figures.get("before")
    rows = [["error of the track", "tracks", "actions a track", "seconds a track", "bar"]]
    if before is not None:
        rows[0][3:3] = ["before"]
        rows[0][5:5] = ["before"]
    for kind in (*KINDS, "false"):
        if kind not in now["kinds"]:
            continue
        found = now["kinds"][kind]
        row = [kind, str(found["tracks"]), f"{found['actions']:.2f}", f"{found['seconds']:.2f}", _bar(kind, found)]
        if before is not None:
            old = before["kinds"][kind]
            row[3:3] = [f"{old['actions']:.2f}"]
            row[5:5] = [f"{old['seconds']:.2f}"]
        rows.append(row)
    whole = f"{now['actions']:.2f} actions a track over all {now['tracks']} tracks"
    if before is not None:
        whole += f" (earlier version, *before*: {before['actions']:.2f})"
    left = now["left"]
    return table(rows) + (
        f"\n{whole}. Seconds are medians of page and server under the machine's load at the time; a person's thinking "
        "is not included. An action is a key press that is a command, a click or a drag; typing a name or a number, "
        "with its final Enter, is one action. Compared with the ground truth, the result of the worst run has "
        f"precision {left['precision']:.2f} and recall {left['recall']:.2f} at IoU 0.5, and "
        f"{left['signs_classified']:.2f} of its signs have the right label. "
        "The missed boxes are frames in which a drawn sign was not followed.\n"
        + "".join(f"\n* {kind}: {', '.join(now['kinds'][kind]['example'])}" for kind in KINDS if kind in now["kinds"])
        + "\n"
    )


def _bar(kind: str, found: JsonMapping) -> str:
    if kind not in BARS:
        return ""
    return f"{BARS[kind]:g} actions, {met(found['actions'] <= BARS[kind])}"


EXPERIMENT = Experiment(
    "day",
    "A day at the review screen",
    "How many actions and seconds does an annotator who knows the ground truth need for a track, by error?",
    _run,
    _report,
    optional=("before",),
)
