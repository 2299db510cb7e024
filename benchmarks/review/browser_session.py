"""Starts a server and a browser for measurements."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.experiment import Skip
from benchmarks.timing.processes import child_processes

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.e2e.live_server import LiveServer

READY = "(r => r && r.shown === r.frame && r.tracks && r.lanes)(tsr.store.get().review)"
"""JavaScript condition: the review screen shows its picture, tracks and lanes."""


@dataclass
class BrowserSession:
    """A running server and a browser."""

    server: LiveServer
    browser: Browser
    chromium: str
    flags: list[str]

    def page(self) -> Page:
        """A signed-in page in a new window with a new profile."""
        page = self.browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
        page.set_default_timeout(120_000)
        page.goto(self.server.link())
        page.wait_for_function("() => globalThis.tsr?.store.get().session")
        return page


@contextlib.contextmanager
def open_browser_session(
    home: Path, roots: tuple[Path, ...], *, sample: bool, code: Path | None = None
) -> Iterator[BrowserSession]:
    """Start ``tsr review`` on a data folder, and Chromium.

    Raises:
        Skip: Playwright or Chromium is missing.
    """
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise Skip("no browser: the package `playwright` is not installed.") from None
    from tests.e2e.live_server import LiveServer
    from tests.e2e.screenshots import FLAGS

    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        raise Skip("no browser: Chromium is not installed.")
    with sync_playwright() as playwright, LiveServer(home, roots, sample=sample, code=code) as server:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        try:
            yield BrowserSession(server, browser, chromium, FLAGS)
        finally:
            browser.close()


def open_review(page: Page, video: str, run: str) -> None:
    """Open the review screen and wait for its picture, its tracks and its lanes."""
    page.evaluate("hash => { location.hash = hash }", f"#/review/{video}/{run}?frame=0")
    page.wait_for_function(f"() => {READY}")


def renderers(browser: int) -> list[int]:
    """The page processes of a browser."""
    found = []
    for pid in child_processes(browser):
        with contextlib.suppress(OSError):
            if b"--type=renderer" in Path(f"/proc/{pid}/cmdline").read_bytes():
                found.append(pid)
    return found
