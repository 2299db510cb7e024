"""A drive of an hour and a half on the review screen: first paint, lanes, memory while it plays."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from benchmarks.review.desk import Desk, open_review, renderers, resident_mb

if TYPE_CHECKING:
    from playwright.sync_api import Page

__all__ = ["first_paint", "lane_intervals", "play_on"]

_PAINT = """hash => new Promise((done, fail) => {
  const began = performance.now();
  let picture = 0;
  location.hash = hash;
  const look = () => {
    const r = tsr.store.get().review;
    if (r && r.shown !== null && r.shown === r.frame) {
      picture ||= performance.now() - began;
      if (r.tracks && r.lanes) {
        requestAnimationFrame(() => requestAnimationFrame(() => done([picture, performance.now() - began])));
        return;
      }
    }
    if (performance.now() - began > 60000) fail(new Error('the review screen did not come'));
    else requestAnimationFrame(look);
  };
  look();
})"""

_LANES = """([kind, length, steps]) => new Promise(done => {
  const store = tsr.store, gaps = [], work = [];
  let last = performance.now(), n = 0;
  const step = now => {
    gaps.push(now - last);
    last = now;
    if (++n > steps) { done({ gaps: gaps.slice(5), work: work.slice(5) }); return; }
    const change = kind === 'seek' ? { frame: (n * 911) % length }
      : kind === 'pan' ? { span: { first: 1000 + n * 200, last: 31000 + n * 200 } }
      : { span: { first: 0, last: length - n * 1300 } };
    const before = performance.now();
    store.dispatch(state => ({ ...state, review: { ...state.review, ...change } }));
    work.push(performance.now() - before);
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
})"""


def first_paint(desk: Desk, video: str, run: str) -> tuple[float, float]:
    """Open the review screen in a fresh profile.

    Returns:
        Milliseconds from the wish to the first picture, and to the picture with tracks and lanes.
    """
    page = desk.page()
    page.wait_for_function("() => tsr.store.get().videos?.length")
    picture, whole = page.evaluate(_PAINT, f"#/review/{video}/{run}")
    page.context.close()
    return picture, whole


def lane_intervals(page: Page, kind: str) -> dict[str, float]:
    """Pan, zoom or seek for 90 frames of the display.

    Returns:
        ``p50`` and ``p95`` of the time between two frames of the display, and of the page's own work in one, ms.
    """
    length = page.evaluate("() => tsr.store.get().review.timebase.frames")
    found = page.evaluate(_LANES, [kind, length, 95])
    gaps, work = sorted(found["gaps"]), sorted(found["work"])
    return {
        "interval_p50": gaps[len(gaps) // 2],
        "interval_p95": gaps[int(0.95 * len(gaps))],
        "work_p50": work[len(work) // 2],
        "work_p95": work[int(0.95 * len(work))],
    }


def play_on(desk: Desk, video: str, run: str, minutes: float) -> list[dict[str, float]]:
    """Play for some minutes, as fast as pictures come, at least as fast as the drive was.

    Returns:
        Twice a minute: ``minutes``, ``frames`` shown, ``heap`` of the page's script after a collection, ``renderers``
        and ``server`` resident, all in MB.
    """
    page = desk.page()
    open_review(page, video, run)
    tools = page.context.new_cdp_session(page)
    page.evaluate(
        "() => { globalThis.passed = 0; const s = tsr.store; const go = () => { const r = s.get().review;"
        " if (r.shown === r.frame) { passed++; s.dispatch(state => ({...state, review: {...state.review,"
        " frame: (r.frame + 1) % r.timebase.frames}})); } setTimeout(go, 15); }; go(); }"
    )
    began, rows = time.monotonic(), []
    while (passed := (time.monotonic() - began) / 60) < minutes:
        page.wait_for_timeout(30_000)
        tools.send("HeapProfiler.collectGarbage")
        heap = tools.send("Runtime.getHeapUsage")["usedSize"] / 2**20
        rows.append(
            {
                "minutes": round(passed + 0.5, 1),
                "frames": page.evaluate("passed"),
                "heap": round(heap, 1),
                "renderers": round(resident_mb(renderers())),
                "server": round(resident_mb([desk.server.pid])),
            }
        )
    page.context.close()
    return rows
