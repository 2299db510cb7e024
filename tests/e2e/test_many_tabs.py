"""More tabs than a browser has connections to a server."""

from __future__ import annotations

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page

from tests.e2e.browsers import WINDOW
from tests.e2e.review_session import (
    ReviewSession,
    edit_and_save,
    open_address,
    select_track,
    wait_for,
    wait_until_drawn,
)

CONNECTIONS = 6
"""Connections of Chromium to a server by HTTP/1.1, of all tabs together."""
SHOW = """(isShown) => {
  Object.defineProperty(document, 'hidden', { value: !isShown, configurable: true });
  document.dispatchEvent(new Event('visibilitychange'));
}"""
"""What the browser does when the user goes to another tab: here all tabs count as visible."""
LISTENS = "() => window.tsr?.store.get().connection === 'online'"


def test_a_tab_loads_beside_many_hidden_ones_which_catch_up(review: ReviewSession) -> None:
    first = review.browser.new_context(viewport=WINDOW).new_page()
    first.goto(review.server.link())
    open_address(first, f"#/review/{review.video}/{review.run}")
    key = "m" + str(wait_until_drawn(first)["tracks"]["id"][0])
    first.evaluate(SHOW, False)
    last: Page = first
    for _ in range(CONNECTIONS):
        last.evaluate(SHOW, False)
        last = first.context.new_page()
        last.goto(f"{review.server.base}/#/")
        last.wait_for_function(LISTENS)
    open_address(last, f"#/review/{review.video}/{review.run}")
    wait_until_drawn(last)
    select_track(last, key)
    done = edit_and_save(last, lambda: last.keyboard.press("u"))
    ignored = done["docs"][key].get("ignore", False)
    first.evaluate(SHOW, True)
    wait_for(first, lambda s: key in s["docs"] and s["docs"][key].get("ignore", False) is ignored)
    edit_and_save(last, lambda: last.keyboard.press("u"))
    first.context.close()
