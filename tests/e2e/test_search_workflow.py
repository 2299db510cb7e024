"""The search in a browser: filters in the URL, selection by keys, an action, its undo, and opening a frame."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright")

from playwright.sync_api import Page, Route, expect

from tests.e2e.interception import intercept
from tests.e2e.review_session import (
    ReviewSession,
    fresh_page,
    go_back,
    open_address,
    wait_until_no_dialog,
    without_errors,
)


@pytest.fixture
def found(review: ReviewSession) -> Iterator[Page]:
    """The search with all tracks of the review's run."""
    page = fresh_page(review.window, review.server)
    with without_errors(page):
        page.goto(review.server.link())
        page.get_by_role("link", name="Search", exact=True).click()
        page.locator(".found-tile img").first.wait_for()
        yield page


def test_many_are_judged_by_keys_and_taken_back(review: ReviewSession, found: Page) -> None:
    total = found.locator(".found-tile").count()
    assert total >= 2
    expect(found.get_by_role("listbox", name="Found tracks")).to_be_focused()
    found.keyboard.press("Control+a")
    expect(found.locator('.found-tile[aria-selected="true"]')).to_have_count(total)
    found.keyboard.press("a")
    expect(found.locator('.found-tile[data-state="accepted"]')).to_have_count(total)
    assert {doc["review"] for doc in review.documents().values()} == {"accepted"}
    found.keyboard.press("Control+z")
    expect(found.locator('.found-tile[data-state="open"]')).to_have_count(total)
    expect(found.get_by_text("Undone: accepted")).to_be_visible()


def test_the_keys_work_when_the_first_answer_came_before_the_run_was_read(found: Page) -> None:
    found.get_by_role("link", name="Library", exact=True).click()
    found.locator(".found").wait_for(state="detached")

    def unread(route: Route) -> None:
        answer = route.fetch()
        route.fulfill(response=answer, json={**answer.json(), "tracks": [], "next": None, "total": 0, "unread": 1})

    intercept(found, re.compile(r"/api/search\?"), unread)
    found.get_by_role("link", name="Search", exact=True).click()
    found.get_by_text("The runs are still being read.").wait_for()
    found.unroute_all()
    expect(found.get_by_role("listbox", name="Found tracks")).to_be_focused()


def test_filters_are_an_address(found: Page) -> None:
    found.get_by_label("Smallest size, px").fill("9999")
    found.get_by_text("No track matches these filters").wait_for()
    assert found.evaluate("location.hash") == "#/search?size_min=9999"
    found.get_by_label("Smallest size, px").fill("1")
    found.locator(".found-tile").first.wait_for()
    found.get_by_label("Label", exact=True).fill("unicorn")
    found.keyboard.press("Enter")
    found.get_by_text("has the key, name, alias or number 'unicorn'").wait_for()
    # words of a name find its label, and the page says which
    name = found.evaluate("async () => (await (await fetch('/api/search')).json()).tracks[0].label.name")
    found.get_by_label("Label", exact=True).fill(name.split()[0][:4])
    found.keyboard.press("Enter")
    found.locator(".found-tile").first.wait_for()
    expect(found.locator(".search-note")).to_contain_text(name)
    expect(found.locator(".tooltip")).to_be_hidden()
    open_address(found, "#/search?state=accepted&tag=night")
    found.get_by_text("No track matches these filters").wait_for()
    assert found.get_by_label("State", exact=True).input_value() == "accepted"
    assert found.get_by_label("Tag", exact=True).input_value() == "night"


def test_a_crop_opens_its_frame_and_the_way_back_leads_to_it(found: Page) -> None:
    tiles = found.locator(".found-tile")
    tiles.nth(1).click()
    name = tiles.nth(1).get_attribute("aria-label")
    assert name is not None
    frame = name.rsplit("frame ", 1)[1]
    found.keyboard.press("Enter")
    found.wait_for_function("f => window.tsr.store.get().review?.shown === f", arg=int(frame))
    found.wait_for_function("() => window.tsr.store.get().review.selected !== null")
    go_back(found)
    expect(found.locator('.found-tile[aria-selected="true"]')).to_have_attribute("aria-label", name)


def test_a_tag_and_a_label_are_given_in_dialogs(review: ReviewSession, found: Page) -> None:
    found.locator(".found-tile").first.click()
    found.keyboard.press("t")
    found.locator("dialog[open] #tags-add").fill("night")
    found.keyboard.press("Enter")
    wait_until_no_dialog(found)
    assert review.server.call("GET", f"/videos/{review.video}")["tags"] == ["night"]
    found.locator(".found-tile").first.click()
    found.keyboard.press("l")
    found.locator("dialog[open] input:focus").wait_for()
    found.keyboard.type("roundabout")
    found.keyboard.press("Enter")
    expect(found.locator(".found-tile").first).to_contain_text("roundabout")
    found.get_by_role("button", name="Undo").last.click()
    expect(found.get_by_text("Undone: relabelled roundabout")).to_be_visible()
