"""Helpers for tests of the review screen: a server with one tracked clip, and a person's actions in a browser."""

from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlencode
from weakref import WeakSet

import pytest
from playwright.sync_api import Browser, BrowserContext, Error, Page

from tests.e2e.browsers import WINDOW, open_browser, shared_window
from tests.e2e.forked_server import ForkedServer
from tests.e2e.live_server import LiveServer
from tests.e2e.tracked_home import tracked_home

__all__ = [
    "MAX_WAIT_S",
    "SLOWDOWN",
    "WINDOW",
    "ReviewSession",
    "centre",
    "choose_label",
    "drag",
    "edit_and_save",
    "engine_box",
    "fresh_page",
    "go_back",
    "import_tracks",
    "open_address",
    "open_label_dialog",
    "open_long_track",
    "open_session",
    "reload_review",
    "screen_point",
    "select_long_track",
    "select_track",
    "serve_video",
    "state",
    "undone_at_end",
    "wait_for",
    "wait_until_drawn",
    "wait_until_no_dialog",
    "wait_until_saved",
    "without_errors",
    "zoom_in",
]

MAX_WAIT_S = 60
"""The longest wait on a slow machine, s; a condition that holds sooner ends the wait."""
SLOWDOWN = float(os.environ.get("TSR_SLOWDOWN") or 1)
"""How many times slower pages compute than they could; see ``slowdown`` in conftest."""
STATE = """(known) => { const r = window.tsr.store.get().review;
  if (known && r === window.polled) return null;
  window.polled = r;
  return r && JSON.stringify({frame: r.frame, shown: r.shown, selected: r.selected, docs: r.docs,
    unsaved: r.unsaved.length, undo: r.undo, redo: r.redo, viewport: r.viewport, mode: r.mode, marked: r.marked,
    run: r.run && r.run.id, second: r.second, drag: r.drag,
    tracks: r.tracks, overlay: r.overlays[r.frame] || null}); }"""
"""The review's state as JSON, which Playwright passes on much faster than objects.

Null without a review, or if the last call has returned the state and ``known`` is true: states are never changed.
"""
NAVIGATE = """(hash) => new Promise((done) => {
  const drawn = () => requestAnimationFrame(() => requestAnimationFrame(() => done()));
  if (location.hash === hash) return drawn();
  addEventListener('hashchange', drawn, {once: true});
  if (hash === null) history.back();
  else location.hash = hash;
})"""
"""Go to an address, or back for null; ends when the page is drawn with it: what holds then is not the old screen's."""
ADDRESS_IS_WRITTEN = """() => { const key = window.tsr.store.get().review?.selected;
  return !key || new URLSearchParams(location.hash.split('?')[1]).get('track') === key; }"""
"""Whether the address, which is written a moment later, names the selected track."""
IDLE_ADDRESS = "/static/js/theme-boot.js"
"""An address without activity, for a tab between two pages of the same server."""
_tabs: WeakSet[Page] = WeakSet()
"""Tabs that one page has after the other."""
IS_LOADED = "() => document.querySelector('.review-grid')?.getAttribute('aria-busy') !== 'true'"
"""Whether no review is on the screen, or all of it is loaded: run, tracks and edits."""


class ReviewSession:
    """A server with one tracked clip, and a browser."""

    def __init__(self, server: LiveServer, browser: Browser, video: str, run: str) -> None:
        self.server, self.browser, self.video, self.run = server, browser, video, run

    @property
    def window(self) -> BrowserContext:
        """State shared by successive pages; see :func:`fresh_page`."""
        return shared_window(self.browser)

    def page(self, *, deaf: bool = False, shared: bool = False) -> Page:
        """A signed-in page on the review screen with all corrections.

        Args:
            deaf: it hears nothing of what others do.
            shared: it is a :func:`fresh_page` of the window; otherwise it has a window of its own.
        """
        page = fresh_page(self.window, self.server) if shared else self.browser.new_context(viewport=WINDOW).new_page()
        if deaf:
            page.route(re.compile(r"/api/events(\?.*)?$"), lambda route: route.abort())
        page.set_default_timeout(1000 * MAX_WAIT_S)
        page.goto(self.server.link())
        open_address(page, f"#/review/{self.video}/{self.run}")
        wait_until_drawn(page)
        return page

    def documents(self) -> dict[str, Any]:
        """The server's documents."""
        return {d["key"]: d for d in self.server.call("GET", f"/runs/{self.run}/annotation")["docs"]}


def fresh_page(window: BrowserContext, server: LiveServer) -> Page:
    """A signed-out page in the tab of the window's last page, without its state except the server's files.

    The browser keeps its compiled modules, so such a page costs half as much as one in a new tab.
    """
    page, *others = window.pages or [window.new_page()]
    _tabs.add(page)
    for other in others:
        other.close()
    page.unroute_all()
    page.set_default_timeout(1000 * MAX_WAIT_S)
    page.set_viewport_size(WINDOW)
    page.mouse.move(0, 0)
    page.goto(server.base + IDLE_ADDRESS)  # end the last page, so that it writes nothing more
    page.evaluate("() => sessionStorage.clear()")
    session = window.new_cdp_session(page)
    left = {"origin": server.base, "storageTypes": "cookies,local_storage,indexeddb"}
    session.send("Storage.clearDataForOrigin", left)
    session.detach()
    return page


@contextmanager
def serve_video(folders: pytest.TempPathFactory, clip: Path, name: str) -> Iterator[tuple[LiveServer, Browser, str]]:
    """A server on its own data folder, a browser, and the id of the only video.

    Args:
        folders: where the data folder is created.
        clip: the video.
        name: of the video on the server.
    """
    with open_session(folders, clip, None, name) as review:
        yield review.server, review.browser, review.video


@contextmanager
def open_session(
    folders: pytest.TempPathFactory, clip: Path, stop: int | None, name: str = "drive.mp4", run: str | None = None
) -> Iterator[ReviewSession]:
    """A server with one run of the engine, or none, and a browser; :func:`tracked_home` explains the arguments."""
    home = tracked_home(folders, clip, stop, name, run)
    with ForkedServer(home.home, roots=(home.roots,), sample=False) as server, open_browser() as browser:
        yield ReviewSession(server, browser, home.video, home.run)


@contextmanager
def without_errors(page: Page) -> Iterator[Page]:
    """A page that must end without an error. It is closed then, unless the next page reuses its tab."""
    errors: list[str] = []

    def note(error: Error) -> None:
        errors.append(str(error))

    page.on("pageerror", note)
    yield page
    page.remove_listener("pageerror", note)
    if page not in _tabs:
        page.close()
    assert errors == []


@contextmanager
def undone_at_end(page: Page) -> Iterator[Page]:
    """A page on a review that undoes its edits at the end."""
    yield page
    while state(page)["undo"]:
        edit_and_save(page, lambda: page.keyboard.press("Control+z"))


def open_address(page: Page, hash_: str) -> None:
    """Open an address in the page, and wait until it is shown; see :data:`NAVIGATE` and :data:`IS_LOADED`."""
    page.evaluate(NAVIGATE, hash_)
    page.wait_for_function(IS_LOADED)


def go_back(page: Page) -> None:
    """Return to the previous address, and wait until it is shown."""
    page.evaluate(NAVIGATE, None)
    page.wait_for_function(IS_LOADED)


def wait_until_drawn(page: Page) -> dict[str, Any]:
    """Wait until picture and boxes of the frame are drawn; returns the state."""
    return wait_for(page, lambda s: s["shown"] == s["frame"] and s["overlay"] is not None)


def reload_review(page: Page) -> dict[str, Any]:
    """Reload a page on a review; returns the state when everything is loaded again."""
    page.wait_for_function(ADDRESS_IS_WRITTEN)
    page.reload()
    page.wait_for_function(IS_LOADED)
    return wait_until_drawn(page)


def wait_until_no_dialog(page: Page) -> None:
    """Wait until no dialog is open: typing, filling in and focus then go to the page."""
    page.locator("dialog").wait_for(state="detached")


def state(page: Page) -> dict[str, Any]:
    """The review's state in the page."""
    found: dict[str, Any] = json.loads(page.evaluate(STATE, False))
    return found


def wait_for(page: Page, holds: Callable[[dict[str, Any]], bool], seconds: float = MAX_WAIT_S) -> dict[str, Any]:
    """Wait until a condition holds; returns the state."""
    end = time.monotonic() + seconds
    now = None
    while time.monotonic() < end:
        if (text := page.evaluate(STATE, now is not None)) is not None:
            now = json.loads(text)
        if now is not None and holds(now):
            return dict(now)
        page.wait_for_timeout(40)
    raise AssertionError(
        f"it never held: { ({k: v for k, v in (now or {}).items() if k not in ('tracks', 'overlay')}) }"
    )


def wait_until_saved(page: Page) -> dict[str, Any]:
    """Wait until all edits are acknowledged; returns the state."""
    page.wait_for_timeout(60)
    return wait_for(page, lambda s: s["unsaved"] == 0)


def edit_and_save(page: Page, act: Callable[[], object]) -> dict[str, Any]:
    """Wait until the change by ``act`` is acknowledged; returns the state."""
    # during a request the undo target has no name: its answer alone would look like a change
    before = (wait_for(page, lambda s: (s["undo"] or {}).get("op_id") != "")["undo"] or {}).get("op_id")
    act()
    return wait_for(page, lambda s: s["unsaved"] == 0 and (s["undo"] or {}).get("op_id") not in (before, ""))


def zoom_in(page: Page) -> None:
    """Turn the wheel one notch; the browser delivers that later."""
    before = state(page)["viewport"]["zoom"]
    page.mouse.wheel(0, -200)
    wait_for(page, lambda s: s["viewport"]["zoom"] > before)


def choose_label(page: Page, words: str) -> None:
    """Type into the label dialog as soon as it is ready."""
    page.locator("dialog[open] input:focus").wait_for()
    page.keyboard.type(words)
    page.keyboard.press("Enter")
    wait_until_no_dialog(page)


def screen_point(page: Page, x: float, y: float) -> tuple[float, float]:
    """The position of a picture point in the window."""
    view = state(page)["viewport"]
    stage = page.locator(".picture-stage").bounding_box()
    assert stage is not None
    return (
        stage["x"] + stage["width"] / 2 + (x - view["x"]) * view["zoom"],
        stage["y"] + stage["height"] / 2 + (y - view["y"]) * view["zoom"],
    )


def select_long_track(page: Page, frames: int = 30) -> dict[str, Any]:
    """Walk the queue to a long track; returns the state after it is opened."""
    tracks = state(page)["tracks"]
    lasting = [last - first for first, last in zip(tracks["first"], tracks["last"], strict=True)]
    assert max(lasting) >= frames, f"no track of this clip lasts {frames} frames: {lasting}"
    before = None
    while True:
        page.keyboard.press("j")
        now = wait_for(page, lambda s, before=before: s["selected"] not in (None, before))
        before = now["selected"]
        at = now["tracks"]["id"].index(int(before[1:]))
        if now["tracks"]["last"][at] - now["tracks"]["first"][at] >= frames:
            return wait_for(page, lambda s: s["shown"] == s["frame"] and s["overlay"])


def open_long_track(page: Page, frames: int = 30) -> dict[str, Any]:
    """Walk the queue to a long track, and go to its first frame."""
    now = select_long_track(page, frames)
    start = now["tracks"]["first"][now["tracks"]["id"].index(int(now["selected"][1:]))]
    page.keyboard.press("b")
    return wait_for(page, lambda s: s["frame"] == start and s["shown"] == start and s["overlay"])


def select_track(page: Page, key: str) -> None:
    """Select a track wherever the cursor is."""
    page.evaluate("(k) => window.tsr.store.dispatch((s) => ({...s, review: {...s.review, selected: k}}))", key)


def drag(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Drag from one picture point to another."""
    page.mouse.move(*screen_point(page, *start))
    page.mouse.down()
    page.mouse.move(*screen_point(page, *end), steps=5)
    page.mouse.up()


def centre(box: list[float]) -> tuple[float, float]:
    """The middle of a box."""
    return (box[0] + box[2]) / 2, (box[1] + box[3]) / 2


def engine_box(now: dict[str, Any], key: str) -> list[float]:
    """The engine's box of a track in the frame."""
    return next(list(t["box"]) for t in now["overlay"]["tracks"] if f"m{t['id']}" == key)


def import_tracks(server: LiveServer, video: str, table: bytes, name: str, role: str = "run") -> dict[str, Any]:
    """Import a table of tracks onto a video, as a run or as ``truth``; returns the server's answer."""
    url = f"/videos/{video}/imports?{urlencode({'as': role, 'name': name, 'format': 'tracks-csv'})}"
    answer: dict[str, Any] = server.call("POST", url, table, "application/octet-stream")
    return answer


def open_label_dialog(page: Page, place: int) -> str:
    """Select a track by its place in the run and open the label dialog; returns its key."""
    key: str = page.evaluate(
        """at => { const key = `m${tsr.store.get().review.tracks.id[at]}`;
        tsr.store.dispatch((s) => ({...s, review: {...s.review, selected: key}})); return key; }""",
        place,
    )
    page.locator(".picture-stage").focus()
    page.keyboard.press("l")
    page.locator("dialog[open] input:focus").wait_for()
    return key
