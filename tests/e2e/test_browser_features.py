"""What the page needs from the browser and requests on a visit, and what it says if the browser lacks something."""

from __future__ import annotations

from collections import Counter

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, Request, expect

from tests.e2e.browsers import WINDOW
from tests.e2e.review_session import ReviewSession, open_address, select_track, wait_for, wait_until_drawn


def page_without(review: ReviewSession, feature: str) -> Page:
    """A signed-in page in a browser without a feature."""
    page = review.browser.new_context(viewport=WINDOW).new_page()
    page.add_init_script(f"delete {feature}")
    page.goto(review.server.link())
    return page


def test_a_page_by_plain_http_can_edit(review: ReviewSession) -> None:
    page = page_without(review, "Crypto.prototype.randomUUID")
    open_address(page, f"#/review/{review.video}/{review.run}")
    key = "m" + str(wait_until_drawn(page)["tracks"]["id"][0])
    before = review.documents().get(key, {}).get("ignore", False)
    select_track(page, key)
    page.keyboard.press("u")
    wait_for(page, lambda s: key in s["docs"] and s["docs"][key].get("ignore", False) is not before)
    wait_for(page, lambda s: s["unsaved"] == 0)
    assert review.documents()[key].get("ignore", False) is not before
    page.keyboard.press("u")
    wait_for(page, lambda s: s["unsaved"] == 0 and s["docs"][key].get("ignore", False) is before)
    page.context.close()


def test_an_old_browser_is_told_which_ones_will_do(review: ReviewSession) -> None:
    page = page_without(review, "AbortSignal.any")
    expect(page.get_by_role("alert")).to_contain_text("too old for the page. Use Chrome or Edge from version 116")
    page.context.close()


@pytest.mark.parametrize("defect", ["throw new TypeError('x')", "Promise.reject(new TypeError('x'))"])
def test_a_defect_of_the_page_is_not_silent(review: ReviewSession, defect: str) -> None:
    page = review.page(shared=True)
    page.evaluate(f"() => void setTimeout(() => {{ {defect} }})")
    expect(page.locator(".toast")).to_contain_text("Something in the page went wrong.")


def test_a_visit_requests_each_list_once(review: ReviewSession) -> None:
    page = review.page(shared=True)
    requested: Counter[str] = Counter()

    def count(request: Request) -> None:
        requested.update([request.url.removeprefix(f"{review.server.base}/api/")])

    page.on("request", count)
    page.reload()
    page.wait_for_function("() => globalThis.tsr?.store.get().models !== null && tsr.store.get().outputs !== null")
    page.remove_listener("request", count)  # later tests use the same page
    lists = ("session", "labels", "parameters", "videos", "outputs", "models")
    assert {name: requested[name] for name in lists} == dict.fromkeys(lists, 1)
