"""Tests that answer a page's requests in place of the server."""

from __future__ import annotations

import re
from collections.abc import Callable

from playwright.sync_api import Page, Route

__all__ = ["intercept"]

MARKER = "/static/js/theme-boot.js?intercepted"
"""Only the test answers it with 204."""
IS_INTERCEPTED = f"() => fetch('{MARKER}').then((answer) => answer.status === 204)"
"""Whether the page's requests come to the test."""


def intercept(page: Page, url: str | re.Pattern[str], answer: Callable[[Route], object]) -> None:
    """Let ``answer`` handle the requests of a loaded page to an address from now on.

    After ``Page.route`` alone, the next request of a busy page may still reach the server: one in seven did.
    """
    page.route(url, answer)
    page.route(re.compile(re.escape(MARKER) + "$"), lambda route: route.fulfill(status=204))
    page.wait_for_function(IS_INTERCEPTED)
