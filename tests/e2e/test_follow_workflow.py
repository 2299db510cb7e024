"""Following signs in a real browser: drawn, late and corrected ones. Each test counts its actions."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, expect

from tests.e2e.review_session import (
    MAX_WAIT_S,
    ReviewSession,
    choose_label,
    drag,
    edit_and_save,
    engine_box,
    open_long_track,
    reload_review,
    select_track,
    undone_at_end,
    wait_for,
    wait_until_saved,
)

FOLLOWING = "() => window.tsr.store.get().review.following"


@pytest.fixture
def page(page: Page) -> Iterator[Page]:
    """A page that leaves nothing behind."""
    with undone_at_end(page):
        yield page


def proposed(page: Page) -> dict[str, Any]:
    """The proposals after all have arrived."""
    page.wait_for_function(f"() => ['complete', 'failed'].includes(({FOLLOWING})()?.state)", timeout=60_000)
    found: dict[str, Any] = page.evaluate(FOLLOWING)
    assert found["state"] == "complete", found["error"]
    return found


def test_a_missed_sign_is_drawn_over_its_whole_life_in_four_actions(review: ReviewSession, page: Page) -> None:
    now = open_long_track(page)
    key = now["selected"]
    place = now["tracks"]["id"].index(int(key[1:]))
    life = now["tracks"]["first"][place], now["tracks"]["last"][place]
    middle = (life[0] + life[1]) // 2
    page.evaluate("(k) => window.tsr.store.dispatch((s) => ({...s, review: {...s.review, frame: k}}))", middle)
    now = wait_for(page, lambda s: s["shown"] == middle and s["overlay"])
    box = engine_box(now, key)
    # the engine has missed it
    edit_and_save(page, lambda: page.keyboard.press("Shift+Delete"))
    page.keyboard.press("n")  # 1
    drag(page, (box[0], box[1]), (box[2], box[3]))  # 2
    choose_label(page, "stop")  # 3
    found = proposed(page)
    drawn = found["key"]
    after = edit_and_save(page, lambda: page.keyboard.press("Enter"))  # 4
    assert page.evaluate(FOLLOWING) is None
    assert after["undo"]["name"] == "follow"
    frames = sorted(map(int, review.documents()[drawn]["keys"]))
    assert frames[0] <= life[0] + 3
    assert frames[-1] >= life[1] - 3
    assert len(frames) < (frames[-1] - frames[0]) * 0.8, "thinned to key frames"
    # one undo reverts all of it
    edit_and_save(page, lambda: page.keyboard.press("Control+z"))
    assert list(review.documents()[drawn]["keys"]) == [str(middle)]


def test_a_late_track_is_brought_back_to_its_first_sight_in_three_actions(review: ReviewSession, page: Page) -> None:
    now = open_long_track(page)
    key = now["selected"]
    first = now["frame"]
    late = first + 20
    page.evaluate("(k) => window.tsr.store.dispatch((s) => ({...s, review: {...s.review, frame: k}}))", late)
    wait_for(page, lambda s: s["shown"] == late and s["overlay"])
    after = edit_and_save(page, lambda: page.keyboard.press("Alt+m"))
    half = after["selected"]
    assert half != key
    select_track(page, key)
    edit_and_save(page, lambda: page.keyboard.press("Shift+Delete"))
    select_track(page, half)  # 1: as J or a click does
    page.keyboard.press(",")  # 2
    found = proposed(page)
    assert found["anchors"][0]["frame"] == late
    edit_and_save(page, lambda: page.keyboard.press("Enter"))  # 3
    doc = review.documents()[half]
    frames = sorted(map(int, doc["keys"]))
    assert frames[0] <= first + 3
    assert frames[-1] == late
    assert doc["keys"][str(late)]["interpolate"] is False, "behind the anchor the engine's boxes stand"


def test_proposals_outlive_a_reload_and_escape_drops_them(review: ReviewSession, page: Page) -> None:
    now = open_long_track(page)
    stored = review.documents()
    page.keyboard.press("t")
    before = proposed(page)
    reload_review(page)
    after = proposed(page)
    assert after["id"] == before["id"]
    assert after["proposals"].keys() == before["proposals"].keys()
    select_track(page, now["selected"])
    expect(page.locator(".follow-bar")).to_be_visible()
    titles = page.locator(".follow-bar button").evaluate_all("all => all.map((one) => one.title)")
    assert [title[title.rindex("(") :] for title in titles] == ["(Enter)", "([)", "(])", "(Escape)"]
    page.keyboard.press("Escape")
    expect(page.locator(".follow-bar")).to_be_hidden()
    assert page.evaluate(FOLLOWING) is None
    assert wait_until_saved(page)["selected"] == now["selected"], "Escape was about the proposals"
    end = time.monotonic() + MAX_WAIT_S
    while review.server.call("GET", f"/runs/{review.run}/follows")["found"] is not None:
        assert time.monotonic() < end, "the server keeps what was dropped"
        page.wait_for_timeout(40)
    assert review.documents() == stored


def test_a_cut_and_a_corrected_box_change_what_is_proposed(review: ReviewSession, page: Page) -> None:
    now = open_long_track(page)
    key = now["selected"]
    cut = now["frame"] + 12
    page.keyboard.press("t")
    proposed(page)
    for _ in range(12):
        page.keyboard.press("f")
    wait_for(page, lambda s: s["frame"] == s["shown"] == cut and s["overlay"])
    page.keyboard.press("]")
    assert page.evaluate(FOLLOWING)["to"] == cut
    page.keyboard.press("ArrowRight")
    page.wait_for_function(f"() => ({FOLLOWING})()?.anchors.length === 2")
    found = proposed(page)
    assert [anchor["frame"] for anchor in found["anchors"]] == [cut - 12, cut]
    edit_and_save(page, lambda: page.keyboard.press("Enter"))
    keys = review.documents()[key]["keys"]
    assert max(map(int, keys)) == cut
    assert [frame for frame, one in keys.items() if not one["followed"]] == [str(cut - 12), str(cut)]
