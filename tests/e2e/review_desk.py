"""Helpers for tests of the review screen: a desk with one tracked clip, and a person's actions on it."""

from __future__ import annotations

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

from tests.e2e.browsers import WINDOW, kept_window, open_browser
from tests.e2e.forked_server import ForkedServer
from tests.e2e.live_server import LiveServer
from tests.e2e.tracked_home import tracked_home

__all__ = [
    "PATIENCE", "SLOWED", "WINDOW", "Desk", "back", "box_of", "centre", "choose", "choose_label", "drag", "drawn",
    "edited", "faultless", "fresh_page", "go", "imported", "next_long_track", "no_dialog", "on_screen", "one_video",
    "open_desk", "relabel", "reloaded", "saved", "state", "tidied", "to_long_track", "wait", "zoom_in",
]  # fmt: skip

PATIENCE = 60
"""The longest wait on a slow machine, s; a condition that holds sooner ends the wait."""
SLOWED = float(os.environ.get("TSR_SLOWDOWN") or 1)
"""How many times slower pages compute than they could; see ``slowdown`` in conftest."""
STATE = """() => { const r = window.tsr.store.get().review;
  return r && {frame: r.frame, shown: r.shown, selected: r.selected, docs: r.docs, unsaved: r.unsaved.length,
    undo: r.undo, redo: r.redo, viewport: r.viewport, mode: r.mode, marked: r.marked,
    run: r.run && r.run.id, second: r.second, drag: r.drag,
    tracks: r.tracks, overlay: r.overlays[r.frame] || null}; }"""
LEAD = """(hash) => new Promise((done) => {
  const drawn = () => requestAnimationFrame(() => requestAnimationFrame(() => done()));
  if (location.hash === hash) return drawn();
  addEventListener('hashchange', drawn, {once: true});
  if (hash === null) history.back();
  else location.hash = hash;
})"""
"""Go to an address, or back for null; ends when the page is drawn with it: what holds then is not the old screen's."""
ADDRESSED = """() => { const key = window.tsr.store.get().review?.selected;
  return !key || new URLSearchParams(location.hash.split('?')[1]).get('track') === key; }"""
"""Whether the address, which is written a moment later, names the selected track."""
NOTHING = "/static/js/theme-boot.js"
"""An address without activity, for a tab between two pages of the same server."""
_tabs: WeakSet[Page] = WeakSet()
"""Tabs that one page has after the other."""
OPEN = "() => document.querySelector('.review-grid')?.getAttribute('aria-busy') !== 'true'"
"""Whether no review is on the screen, or all of it is loaded: run, tracks and edits."""


class Desk:
    """A server with one tracked clip, and a browser."""

    def __init__(self, server: LiveServer, browser: Browser, video: str, run: str) -> None:
        self.server, self.browser, self.video, self.run = server, browser, video, run

    @property
    def window(self) -> BrowserContext:
        """State shared by successive pages; see :func:`fresh_page`."""
        return kept_window(self.browser)

    def page(self, *, deaf: bool = False, shared: bool = False) -> Page:
        """A signed-in page on the review screen with all corrections.

        Args:
            deaf: it hears nothing of what others do.
            shared: it is a :func:`fresh_page` of the window; otherwise it has a window of its own.
        """
        page = fresh_page(self.window, self.server) if shared else self.browser.new_context(viewport=WINDOW).new_page()
        if deaf:
            page.route(re.compile(r"/api/events(\?.*)?$"), lambda route: route.abort())
        page.set_default_timeout(1000 * PATIENCE)
        page.goto(self.server.link())
        go(page, f"#/review/{self.video}/{self.run}")
        drawn(page)
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
    page.set_default_timeout(1000 * PATIENCE)
    page.set_viewport_size(WINDOW)
    page.mouse.move(0, 0)
    page.goto(server.base + NOTHING)  # end the last page, so that it writes nothing more
    page.evaluate("() => sessionStorage.clear()")
    session = window.new_cdp_session(page)
    left = {"origin": server.base, "storageTypes": "cookies,local_storage,indexeddb"}
    session.send("Storage.clearDataForOrigin", left)
    session.detach()
    return page


@contextmanager
def one_video(folders: pytest.TempPathFactory, clip: Path, name: str) -> Iterator[tuple[LiveServer, Browser, str]]:
    """A server on its own data folder, a browser, and the id of the only video.

    Args:
        folders: where the data folder is created.
        clip: the video.
        name: of the video on the server.
    """
    with open_desk(folders, clip, None, name) as desk:
        yield desk.server, desk.browser, desk.video


@contextmanager
def open_desk(
    folders: pytest.TempPathFactory, clip: Path, stop: int | None, name: str = "drive.mp4", run: str | None = None
) -> Iterator[Desk]:
    """A desk with one run of the engine, or none; :func:`tracked_home` explains the arguments."""
    home = tracked_home(folders, clip, stop, name, run)
    with ForkedServer(home.home, roots=(home.roots,), sample=False) as server, open_browser() as browser:
        yield Desk(server, browser, home.video, home.run)


@contextmanager
def faultless(page: Page) -> Iterator[Page]:
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
def tidied(page: Page) -> Iterator[Page]:
    """A page on a review that undoes its edits at the end."""
    yield page
    while state(page)["undo"]:
        edited(page, lambda: page.keyboard.press("Control+z"))


def go(page: Page, hash_: str) -> None:
    """Open an address in the page, and wait until it is shown; see :data:`LEAD` and :data:`OPEN`."""
    page.evaluate(LEAD, hash_)
    page.wait_for_function(OPEN)


def back(page: Page) -> None:
    """Return to the previous address, and wait until it is shown."""
    page.evaluate(LEAD, None)
    page.wait_for_function(OPEN)


def drawn(page: Page) -> dict[str, Any]:
    """Wait until picture and boxes of the frame are drawn; returns the state."""
    return wait(page, lambda s: s["shown"] == s["frame"] and s["overlay"] is not None)


def reloaded(page: Page) -> dict[str, Any]:
    """Reload a page on a review; returns the state when everything is loaded again."""
    page.wait_for_function(ADDRESSED)
    page.reload()
    page.wait_for_function(OPEN)
    return drawn(page)


def no_dialog(page: Page) -> None:
    """Wait until no dialog is open: typing, filling in and focus then go to the page."""
    page.locator("dialog").wait_for(state="detached")


def state(page: Page) -> dict[str, Any]:
    """The review's state in the page."""
    found: dict[str, Any] = page.evaluate(STATE)
    return found


def wait(page: Page, holds: Callable[[dict[str, Any]], bool], seconds: float = PATIENCE) -> dict[str, Any]:
    """Wait until a condition holds; returns the state."""
    end = time.monotonic() + seconds
    now = None
    while time.monotonic() < end:
        now = page.evaluate(STATE)
        if now is not None and holds(now):
            return dict(now)
        page.wait_for_timeout(40)
    raise AssertionError(
        f"it never held: { ({k: v for k, v in (now or {}).items() if k not in ('tracks', 'overlay')}) }"
    )


def saved(page: Page) -> dict[str, Any]:
    """Wait until all edits are acknowledged; returns the state."""
    page.wait_for_timeout(60)
    return wait(page, lambda s: s["unsaved"] == 0)


def edited(page: Page, act: Callable[[], object]) -> dict[str, Any]:
    """Wait until the change by ``act`` is acknowledged; returns the state."""
    # during a request the undo target has no name: its answer alone would look like a change
    before = (wait(page, lambda s: (s["undo"] or {}).get("op_id") != "")["undo"] or {}).get("op_id")
    act()
    return wait(page, lambda s: s["unsaved"] == 0 and (s["undo"] or {}).get("op_id") not in (before, ""))


def zoom_in(page: Page) -> None:
    """Turn the wheel one notch; the browser delivers that later."""
    before = state(page)["viewport"]["zoom"]
    page.mouse.wheel(0, -200)
    wait(page, lambda s: s["viewport"]["zoom"] > before)


def choose_label(page: Page, words: str) -> None:
    """Type into the label dialog as soon as it is ready."""
    page.locator("dialog[open] input:focus").wait_for()
    page.keyboard.type(words)
    page.keyboard.press("Enter")
    no_dialog(page)


def on_screen(page: Page, x: float, y: float) -> tuple[float, float]:
    """The position of a picture point in the window."""
    view = state(page)["viewport"]
    stage = page.locator(".picture-stage").bounding_box()
    assert stage is not None
    return (
        stage["x"] + stage["width"] / 2 + (x - view["x"]) * view["zoom"],
        stage["y"] + stage["height"] / 2 + (y - view["y"]) * view["zoom"],
    )


def to_long_track(page: Page, frames: int = 30) -> dict[str, Any]:
    """Walk the queue to a long track; returns the state after it is opened."""
    tracks = state(page)["tracks"]
    lasting = [last - first for first, last in zip(tracks["first"], tracks["last"], strict=True)]
    assert max(lasting) >= frames, f"no track of this clip lasts {frames} frames: {lasting}"
    before = None
    while True:
        page.keyboard.press("j")
        now = wait(page, lambda s, before=before: s["selected"] not in (None, before))
        before = now["selected"]
        at = now["tracks"]["id"].index(int(before[1:]))
        if now["tracks"]["last"][at] - now["tracks"]["first"][at] >= frames:
            return wait(page, lambda s: s["shown"] == s["frame"] and s["overlay"])


def next_long_track(page: Page, frames: int = 30) -> dict[str, Any]:
    """Walk the queue to a long track, and go to its first frame."""
    now = to_long_track(page, frames)
    start = now["tracks"]["first"][now["tracks"]["id"].index(int(now["selected"][1:]))]
    page.keyboard.press("b")
    return wait(page, lambda s: s["frame"] == start and s["shown"] == start and s["overlay"])


def choose(page: Page, key: str) -> None:
    """Select a track wherever the cursor is."""
    page.evaluate("(k) => window.tsr.store.dispatch((s) => ({...s, review: {...s.review, selected: k}}))", key)


def drag(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Drag from one picture point to another."""
    page.mouse.move(*on_screen(page, *start))
    page.mouse.down()
    page.mouse.move(*on_screen(page, *end), steps=5)
    page.mouse.up()


def centre(box: list[float]) -> tuple[float, float]:
    """The middle of a box."""
    return (box[0] + box[2]) / 2, (box[1] + box[3]) / 2


def box_of(now: dict[str, Any], key: str) -> list[float]:
    """The engine's box of a track in the frame."""
    return next(list(t["box"]) for t in now["overlay"]["tracks"] if f"m{t['id']}" == key)


def imported(server: LiveServer, video: str, table: bytes, name: str, role: str = "run") -> dict[str, Any]:
    """Import a table of tracks onto a video, as a run or as ``truth``; returns the server's answer."""
    asked = f"/videos/{video}/imports?{urlencode({'as': role, 'name': name, 'format': 'tracks-csv'})}"
    answer: dict[str, Any] = server.call("POST", asked, table, "application/octet-stream")
    return answer


def relabel(page: Page, place: int) -> str:
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
