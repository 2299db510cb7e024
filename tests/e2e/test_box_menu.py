"""The menu of a box in a real browser: opened by the right button or the keyboard, and its entries."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, expect

from tests.e2e.review_session import (
    centre,
    edit_and_save,
    engine_box,
    open_long_track,
    screen_point,
    state,
    undone_at_end,
    wait_for,
)


@pytest.fixture
def page(page: Page) -> Iterator[Page]:
    """A page that leaves nothing behind."""
    with undone_at_end(page):
        yield page


def test_the_right_button_opens_the_menu_of_the_box_below(page: Page) -> None:
    now = open_long_track(page)
    key = now["selected"]
    box = engine_box(now, key)
    page.keyboard.press("Escape")
    x, y = screen_point(page, *centre(box))
    menu = page.get_by_role("menu", name="Menu of the box")
    expect(menu).to_be_hidden()
    page.mouse.click(x, y, button="right")
    expect(menu).to_be_visible()
    assert state(page)["selected"] == key
    names = menu.get_by_role("menuitem")
    expect(names.first).to_be_focused()
    if folder := os.environ.get("TSR_SHOTS"):
        page.screenshot(path=f"{folder}/box_menu.png")
    texts = names.all_inner_texts()
    for wanted in (
        "Follow",
        "Extend back to the first frame of the sign",
        "Split the track here",
        "Delete the whole track",
    ):
        assert any(text.startswith(wanted) for text in texts), (wanted, texts)
    for place in menu.get_by_role("menuitem").all():
        assert place.get_attribute("title")

    after = edit_and_save(page, lambda: menu.get_by_role("menuitem", name="Occluded from here on").click())
    assert after["undo"]["name"] == "set_occluded"
    expect(menu).to_be_hidden()
    expect(page.locator(".picture-stage")).to_be_focused()


def test_the_keyboard_opens_it_walks_and_leaves_it(page: Page) -> None:
    now = open_long_track(page)
    page.locator(".picture-stage").focus()
    menu = page.get_by_role("menu", name="Menu of the box")
    page.keyboard.press("Shift+F10")
    expect(menu).to_be_visible()
    items = menu.get_by_role("menuitem")
    page.keyboard.press("ArrowUp")
    expect(items.last).to_be_focused()
    page.keyboard.press("Home")
    expect(items.first).to_be_focused()
    page.keyboard.press("Escape")
    expect(menu).to_be_hidden()
    assert state(page)["selected"] == now["selected"], "Escape has left the menu, not the track"
    # a letter is the key of an operation in the menu too
    page.keyboard.press("ContextMenu")
    expect(menu).to_be_visible()
    after = edit_and_save(page, lambda: page.keyboard.press("q"))
    assert after["undo"]["name"] == "set_occluded"


def test_it_closes_when_it_is_about_something_else(page: Page) -> None:
    now = open_long_track(page)
    box = engine_box(now, now["selected"])
    menu = page.get_by_role("menu", name="Menu of the box")
    x, y = screen_point(page, *centre(box))
    page.mouse.click(x, y, button="right")
    expect(menu).to_be_visible()
    page.keyboard.press("ArrowRight")
    assert state(page)["undo"] is None, "an arrow in the menu does not move the box below it"
    expect(menu).to_be_visible()
    page.keyboard.press("End")
    page.evaluate("() => window.tsr.store.dispatch((s) => ({...s, review: {...s.review, frame: s.review.frame + 1}}))")
    wait_for(page, lambda s: s["shown"] == now["frame"] + 1)
    expect(menu).to_be_hidden()
    page.mouse.click(x, y, button="right")
    expect(menu).to_be_visible()
    page.locator(".picture-foot").click(position={"x": 3, "y": 3})
    expect(menu).to_be_hidden()
    # dragging with the right button still moves the picture
    page.mouse.move(x, y)
    page.mouse.down(button="right")
    page.mouse.move(x + 40, y + 20, steps=3)
    page.mouse.up(button="right")
    expect(menu).to_be_hidden()
    # no menu without a box
    corner = page.locator(".picture-stage").bounding_box()
    assert corner is not None
    page.mouse.click(corner["x"] + 3, corner["y"] + corner["height"] - 3, button="right")
    expect(menu).to_be_hidden()
