"""The browsers of the browser tests. Each starts once per process and serves one test file after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

from playwright.sync_api import Browser, Playwright, sync_playwright

from tests.e2e.chromium import CHROMIUM, ENVIRONMENT
from tests.e2e.screenshots import FLAGS

__all__ = ["close_browsers", "open_browser"]

_end = ExitStack()
_playwright: list[Playwright] = []
_running: dict[tuple[str, ...], Browser] = {}


@contextmanager
def open_browser(flags: Sequence[str] = FLAGS) -> Iterator[Browser]:
    """Chromium with these flags, started unless it runs already. Its pages are closed at the end."""
    key = tuple(flags)
    if not _playwright:
        _playwright.append(_end.enter_context(sync_playwright()))
    if key not in _running:
        launch = _playwright[0].chromium.launch
        _running[key] = launch(executable_path=CHROMIUM, args=[*flags], env=ENVIRONMENT)
        _end.callback(_running[key].close)
    try:
        yield _running[key]
    finally:
        for context in _running[key].contexts:
            context.close()


def close_browsers() -> None:
    """Close all browsers. While Playwright runs, no other test can run an asyncio loop."""
    _playwright.clear()
    _running.clear()
    _end.close()
