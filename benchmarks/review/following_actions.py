"""Measures following on the review page: actions with real keys, and the time to the first proposed box."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.review.browser_session import BrowserSession, open_review
from benchmarks.review.faulty_runs import CSV_HEAD, Case, csv_row
from benchmarks.review.simulated_annotator import Proposals, SimulatedAnnotator
from tsr_engine.follow import MIN_WIDTH_PX
from tsr_engine.geometry.boxes import iou_each
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import FloatArray

if TYPE_CHECKING:
    from playwright.sync_api import Page

_MISSING_SHARE = 2 / 3
"""Share of a sign's life that a late track lacks at its beginning."""
_WARM_UP_S = 12.0
"""Seconds with an open page until the standby worker has loaded everything."""
_PAUSE_MS = 1000
"""Milliseconds from a new frame to the key press."""
_LISTEN = """() => {
  globalThis.first = null;
  let pressed = null;
  addEventListener('keydown', (event) => { pressed = event.timeStamp; }, { capture: true, once: true });
  const end = tsr.store.subscribe((state) => {
    const { following } = state.review;
    if (pressed === null || !following || Object.keys(following.proposals).length < 2) return;
    end();
    requestAnimationFrame(() => { globalThis.first = performance.now() - pressed; });
  });
}"""


def extend_late_tracks(
    session: BrowserSession, video: str, cases: Mapping[int, Case], names: Mapping[int, str]
) -> list[JsonObject]:
    """Follow each of a run's tracks, which all begin late, back to the first frame of its sign.

    Args:
        session: server and browser.
        video: id of the video.
        cases: signs by the number of their track.
        names: label id -> its name.

    Returns:
        A row for each sign: ``actions``, and ``share`` of its life with an IoU of at least 0.7 afterwards.
    """
    late = {number: _late(case) for number, case in cases.items()}
    page = _opened(session, video, late)
    rows = []
    for number, work, taken in SimulatedAnnotator(page, dict(cases), dict(names)).extend_tracks_back():
        kept = {k: box for k, box in cases[number].truth.items() if k >= min(late[number])}
        rows.append({"actions": work.actions, "share": _share(cases[number], {**_boxes(taken), **kept})})
    page.context.close()
    return rows


def draw_missed(
    session: BrowserSession, video: str, cases: Mapping[int, Case], names: Mapping[int, str]
) -> list[JsonObject]:
    """Draw each sign but one, which the run lacks, in the middle of its life.

    Arguments and result are those of :func:`extend_late_tracks`.
    """
    first = min(cases)
    page = _opened(session, video, {first: cases[first].truth})
    annotator = SimulatedAnnotator(page, dict(cases), dict(names))
    rows = []
    for number, case in cases.items():
        if number != first:
            frames = sorted(case.truth)
            _show_frame(page, frames[len(frames) // 2])
            work, taken = annotator.draw_missed(number)
            rows.append({"actions": work.actions, "share": _share(case, _boxes(taken))})
    page.context.close()
    return rows


def time_first_proposal(
    session: BrowserSession, video: str, cases: Mapping[int, Case], times: int, seed: int
) -> JsonObject:
    """Press T on random tracks in random frames.

    Args:
        session: server and browser.
        video: id of the video.
        cases: signs by the number of their track.
        times: number of presses.
        seed: random seed of tracks and frames.

    Returns:
        ``ms``: times from each key to the first proposed box on the screen; ``load``: the machine's load before.
    """
    rng = np.random.default_rng(seed)
    page = _opened(session, video, {number: case.truth for number, case in cases.items()})
    time.sleep(_WARM_UP_S)
    load = os.getloadavg()[0]
    found = []
    for _ in range(times):
        number = int(rng.choice(list(cases)))
        frame = int(rng.choice(sorted(cases[number].truth)[5:-5]))
        _show_frame(page, frame, f"m{number}")
        page.evaluate(_LISTEN)
        page.keyboard.press("t")
        page.wait_for_function("() => globalThis.first !== null")
        found.append(float(page.evaluate("() => globalThis.first")))
        page.wait_for_function("() => tsr.store.get().review.following?.state === 'complete'")
        page.keyboard.press("Escape")
    page.context.close()
    return {"ms": found, "load": load}


def _opened(session: BrowserSession, video: str, tracks: Mapping[int, Mapping[int, FloatArray]]) -> Page:
    """The review screen of a new run with these tracks."""
    lines = [CSV_HEAD]
    for number, boxes in tracks.items():
        lines += [csv_row(k, number, box, 14) for k, box in sorted(boxes.items())]
    asked = f"/videos/{video}/imports?as=run&name=tracks&format=tracks-csv"
    run = session.server.call("POST", asked, "\n".join(lines).encode(), "application/octet-stream")["id"]
    page = session.page()
    open_review(page, video, run)
    return page


def _show_frame(page: Page, frame: int, track: str | None = None) -> None:
    """Show a frame, and wait for a moment."""
    where = f"?frame={frame}" + ("" if track is None else f"&track={track}")
    page.evaluate("where => { location.hash = location.hash.split('?')[0] + where }", where)
    page.wait_for_function(
        "([frame, track]) => (r => r.frame === frame && r.shown === frame && r.overlays[frame] && "
        "(!track || r.selected === track))(tsr.store.get().review)",
        arg=[frame, track],
    )
    page.wait_for_timeout(_PAUSE_MS)


def _late(case: Case) -> dict[int, FloatArray]:
    frames = sorted(case.truth)
    return {k: case.truth[k] for k in frames[int(_MISSING_SHARE * len(frames)) :]}


def _boxes(taken: Proposals) -> dict[int, FloatArray]:
    return {k: np.array(box) for k, box in taken}


def _share(case: Case, boxes: Mapping[int, FloatArray]) -> float:
    """Share of the frames with an IoU of at least 0.7, of those in which the sign is wide enough to follow."""
    life = {k: box for k, box in case.truth.items() if box[2] - box[0] >= MIN_WIDTH_PX}
    return float(np.mean([k in boxes and iou_each(boxes[k], box)[0] >= 0.7 for k, box in life.items()]))
