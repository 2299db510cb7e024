"""Measures the review screen with a drive of an hour and a half: first paint, lanes, memory during play."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from benchmarks.review.browser_session import READY, BrowserSession, renderers
from benchmarks.review.debug_port_page import open_debug_port_page
from benchmarks.timing.processes import resident_mb

if TYPE_CHECKING:
    from playwright.sync_api import Page

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


_PLAY = """(() => {
  globalThis.passed = 0;
  const store = tsr.store;
  const go = () => {
    const r = store.get().review;
    if (r.shown === r.frame) {
      passed++;
      store.dispatch(state => ({...state, review: {...state.review, frame: (r.frame + 1) % r.timebase.frames}}));
    }
    setTimeout(go, 15);
  };
  go();
})()"""


def time_first_paint(session: BrowserSession, video: str, run: str) -> tuple[float, float]:
    """Open the review screen in a new profile.

    Returns:
        Milliseconds from the request to the first picture, and to the picture with tracks and lanes.
    """
    page = session.page()
    page.wait_for_function("() => tsr.store.get().videos?.length")
    picture, whole = page.evaluate(_PAINT, f"#/review/{video}/{run}")
    page.context.close()
    return picture, whole


def lane_intervals(page: Page, kind: str) -> dict[str, float]:
    """Pan, zoom or seek for 90 frames of the display.

    Returns:
        ``p50`` and ``p95``, ms, of the time between two display frames, and of the page's work in a frame.
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


def measure_long_play(session: BrowserSession, video: str, run: str, minutes: float) -> list[dict[str, float]]:
    """Play for some minutes at full speed, in a browser without a network debugger.

    Returns:
        Twice a minute: ``minutes``, number of shown ``frames``, ``heap`` of the page's script after garbage collection,
        and resident memory of ``renderers`` and ``server``, MB.
    """
    rows: list[dict[str, float]] = []
    with open_debug_port_page(session.chromium, session.flags, session.server.link(), (1280, 720)) as page:
        page.wait_for("globalThis.tsr?.store.get().session")
        page.evaluate(f"location.hash = '#/review/{video}/{run}?frame=0'")
        page.wait_for(READY)
        page.evaluate(_PLAY)
        began = time.monotonic()
        while (passed := (time.monotonic() - began) / 60) < minutes:
            time.sleep(30)
            page.send("HeapProfiler.collectGarbage")
            heap = page.send("Runtime.getHeapUsage")["usedSize"] / 2**20
            rows.append(
                {
                    "minutes": round(passed + 0.5, 1),
                    "frames": page.evaluate("passed"),
                    "heap": round(heap, 1),
                    "renderers": round(resident_mb(renderers(page.pid))),
                    "server": round(resident_mb([session.server.pid])),
                }
            )
    return rows
