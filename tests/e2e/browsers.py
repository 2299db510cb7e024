"""The browsers of the browser tests. Each starts once per process and serves one test file after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

from playwright.sync_api import Browser, BrowserContext, Playwright, ViewportSize, sync_playwright

from tests.e2e.chromium import CHROMIUM, ENVIRONMENT
from tests.e2e.screenshots import FLAGS

__all__ = ["WINDOW", "close_browsers", "open_browser", "shared_window"]

WINDOW: ViewportSize = {"width": 1280, "height": 720}
_exit_stack = ExitStack()
_playwright: list[Playwright] = []
_running: dict[tuple[str, ...], Browser] = {}
_shared: dict[Browser, BrowserContext] = {}


@contextmanager
def open_browser(flags: Sequence[str] = FLAGS) -> Iterator[Browser]:
    """Chromium with these flags, started unless it runs already. At the end its pages are closed, or left empty."""
    key = tuple(flags)
    if not _playwright:
        _playwright.append(_exit_stack.enter_context(sync_playwright()))
    if key not in _running:
        launch = _playwright[0].chromium.launch
        _running[key] = launch(executable_path=CHROMIUM, args=[*flags], env=ENVIRONMENT)
        _exit_stack.callback(_running[key].close)
    try:
        yield _running[key]
    finally:
        shared = _shared.get(_running[key])
        for context in _running[key].contexts:
            if context is not shared:
                context.close()
        for page in [] if shared is None else shared.pages:
            page.goto("about:blank")


def shared_window(browser: Browser) -> BrowserContext:
    """The window that one file of tests after the other uses: it keeps the compiled modules of the page."""
    if browser not in _shared:
        _shared[browser] = browser.new_context(viewport=WINDOW)
    return _shared[browser]


def close_browsers() -> None:
    """Close all browsers. While Playwright runs, no other test can run an asyncio loop."""
    _playwright.clear()
    _running.clear()
    _shared.clear()
    _exit_stack.close()
