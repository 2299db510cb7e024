"""What a page shows after its server was away: everything, without a reload."""

from __future__ import annotations

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, Route, expect

from tests.e2e.interception import intercept
from tests.e2e.review_session import ReviewSession, open_address


def test_a_lost_network_is_a_banner_within_seconds(page: Page) -> None:
    """The browser says so at once; the page need not wait until its connection has been silent for long."""
    page.context.set_offline(True)
    lost = page.locator(".banner", has_text="The server cannot be reached.")
    expect(lost).to_be_visible(timeout=10_000)
    page.context.set_offline(False)
    expect(lost).to_have_count(0)


@pytest.mark.parametrize("screen", ["#/search", "#/"])
def test_pictures_that_could_not_be_loaded_are_loaded_when_the_server_is_back(
    review: ReviewSession, page: Page, screen: str
) -> None:
    def without_pictures(route: Route) -> None:
        if route.request.resource_type == "image":
            route.abort()
        else:
            route.continue_()

    intercept(page, "**/api/**", without_pictures)
    open_address(page, screen)
    missing = page.locator("img.no-picture[src]")
    expect(missing.first).to_be_attached()
    page.unroute("**/api/**")
    review.server.kill()
    page.locator(".banner").first.wait_for()
    review.server.start(int(review.server.base.rpartition(":")[2]))
    expect(missing).to_have_count(0)
    expect(page.locator(".banner")).to_have_count(0)
    page.wait_for_function("() => [...document.querySelectorAll('main img[src]')].every((one) => one.naturalWidth > 0)")
