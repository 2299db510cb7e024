"""Starts a server and a browser for measurements."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.experiment import Skip

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.e2e.live_server import LiveServer

__all__ = ["READY", "BrowserSession", "descendants", "open_browser_session", "open_review", "renderers", "resident_mb"]

READY = "(r => r && r.shown === r.frame && r.tracks && r.lanes)(tsr.store.get().review)"
"""JavaScript condition: the review screen shows its picture, tracks and lanes."""
SIZE = {"width": 1280, "height": 720}


@dataclass
class BrowserSession:
    """A running server and a browser."""

    server: LiveServer
    browser: Browser
    chromium: str
    flags: list[str]

    def page(self, width: int = SIZE["width"], height: int = SIZE["height"]) -> Page:
        """A signed-in page in a new window with a new profile."""
        page = self.browser.new_context(viewport={"width": width, "height": height}).new_page()
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


def open_review(page: Page, video: str, run: str, frame: int = 0) -> None:
    """Open the review screen and wait for its picture, its tracks and its lanes."""
    page.evaluate("hash => { location.hash = hash }", f"#/review/{video}/{run}?frame={frame}")
    page.wait_for_function(f"() => {READY}")


def resident_mb(pids: Iterable[int]) -> float:
    """Resident memory of processes, in MB of 2^20 bytes.

    This is an upper bound, since memory that several processes share counts for each.
    """
    total = 0
    for pid in pids:
        with contextlib.suppress(OSError):
            lines = Path(f"/proc/{pid}/status").read_text().splitlines()
            total += next((int(line.split()[1]) for line in lines if line.startswith("VmRSS")), 0)
    return total / 1024


def descendants(pid: int) -> list[int]:
    """All direct and indirect child processes of a process (Linux)."""
    parents: dict[int, list[int]] = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            # State and parent follow the last bracket, since the name in brackets may contain brackets.
            parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
            parents.setdefault(parent, []).append(int(folder.name))
    found = list(parents.get(pid, ()))
    for child in found:
        found += parents.get(child, ())
    return found


def renderers(browser: int) -> list[int]:
    """The page processes of a browser."""
    found = []
    for pid in descendants(browser):
        with contextlib.suppress(OSError):
            if b"--type=renderer" in Path(f"/proc/{pid}/cmdline").read_bytes():
                found.append(pid)
    return found
