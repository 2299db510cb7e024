"""Measures stepping, seeking and playing on the review screen inside the page."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tsr_engine.json_shapes import JsonObject

if TYPE_CHECKING:
    from playwright.sync_api import Page

_GO = """async ([frames, pause]) => {
  const store = tsr.store;
  const go = frame => new Promise((done, fail) => {
    const began = performance.now();
    const end = store.subscribe(state => {
      const r = state.review;
      if (r.shown !== frame || r.frame !== frame) return;
      end();
      requestAnimationFrame(() => done(performance.now() - began));
    });
    setTimeout(() => fail(new Error(`frame ${frame} did not come`)), 30000);
    store.dispatch(state => ({ ...state, review: { ...state.review, frame } }));
  });
  const times = [];
  for (const frame of frames) {
    times.push(await go(frame));
    await new Promise(next => setTimeout(next, pause));
  }
  return times;
}"""

_PLAY = """seconds => new Promise(done => {
  const store = tsr.store, seen = [];
  let bare = 0;
  const end = store.subscribe(state => {
    const r = state.review;
    if (!r.playing || r.frame === seen.at(-1) || r.shown !== r.frame) return;
    seen.push(r.frame);
    if (!r.overlays[r.frame]) bare++;
  });
  const began = performance.now(), first = store.get().review.frame;
  store.dispatch(state => ({ ...state, review: { ...state.review, playing: true } }));
  setTimeout(() => {
    end();
    const last = store.get().review.frame, took = performance.now() - began;
    store.dispatch(state => ({ ...state, review: { ...state.review, playing: false } }));
    done({ frames: seen.length, span: last - first, bare, seconds: took / 1e3 });
  }, seconds * 1e3);
})"""


def _percentiles(times: list[float]) -> dict[str, float]:
    p50, p95 = np.percentile(times, [50, 95])
    return {"n": len(times), "p50": float(p50), "p95": float(p95), "max": max(times)}


def measure_early_seeks(page: Page, seed: int) -> dict[str, float]:
    """Times in ms of seeks to ten places that ``measure_handling`` does not use."""
    frames = page.evaluate("() => tsr.store.get().review.timebase.frames")
    return _percentiles(page.evaluate(_GO, [np.random.default_rng(seed).permutation(frames)[-10:].tolist(), 250]))


def measure_handling(page: Page, seed: int) -> JsonObject:
    """Step forward and back, seek to random frames, play.

    Args:
        page: the review screen of a clip that was not shown before.
        seed: random seed of the order of the seeks.

    Returns:
        ``step``, ``back``, ``seek``: milliseconds from the request to the drawn picture; ``play``: numbers of shown
        frames, of passed frames and of frames shown without overlay, and seconds.
    """
    frames = page.evaluate("() => tsr.store.get().review.timebase.frames")
    found: JsonObject = {}
    # Far places come first, since shown frames stay in the page's cache.
    places = np.random.default_rng(seed).permutation(frames)[: min(frames // 2, 60)].tolist()
    found["seek"] = _percentiles(page.evaluate(_GO, [places, 250]))
    start = 5
    page.evaluate(_GO, [[start], 1500])
    stop = min(frames - 2, 120)
    found["step"] = _percentiles(page.evaluate(_GO, [list(range(start + 1, stop)), 60]))
    found["back"] = _percentiles(page.evaluate(_GO, [list(range(stop - 1, start, -1)), 60]))
    page.evaluate(_GO, [[0], 2000])
    rate = page.evaluate(
        "() => { const t = tsr.store.get().review.timebase; return 1 / (t.secondsAt(1) - t.secondsAt(0)) }"
    )
    found["play"] = {"rate": rate, **page.evaluate(_PLAY, min(8.0, (frames - 5) / rate - 0.5))}
    return found
