"""Two people on one track in a real browser: no work is overwritten, and each sees the other's changes."""

from __future__ import annotations

import re

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page

from tests.e2e.review_session import (
    ReviewSession,
    centre,
    drag,
    edit_and_save,
    engine_box,
    select_track,
    state,
    wait_for,
    wait_until_no_dialog,
)


def second_page(review: ReviewSession, page: Page) -> tuple[Page, str]:
    """Another page without events, and a track without a verdict that both have selected."""
    other = review.page(deaf=True)
    tracks = [f"m{track}" for track in state(page)["tracks"]["id"]]
    docs = review.documents()
    judged = {key for key, doc in docs.items() if doc["gone"] or doc.get("ignore") or doc["review"] != "open"}
    key = next((key for key in tracks if key not in judged), None)
    assert key is not None, f"every track of this clip has a verdict: {tracks}"
    for each in (page, other):
        select_track(each, key)
    return other, key


def test_two_pages_on_one_track(review: ReviewSession, page: Page) -> None:
    other, key = second_page(review, page)
    mine = edit_and_save(page, lambda: page.keyboard.press("w"))["docs"][key]["review"]
    other.keyboard.press("u")
    dialog = other.locator("dialog[open]")
    dialog.wait_for()
    assert review.documents()[key]["review"] == mine  # no overwrite
    for meant_for_the_picture in ("Space", "Enter", "f", "a"):
        other.keyboard.press(meant_for_the_picture)
    assert state(other)["unsaved"] == 1
    assert dialog.is_visible()
    dialog.get_by_role("button", name="Keep mine").click()
    wait_for(other, lambda s: s["unsaved"] == 0)
    dialog.wait_for(state="detached")  # the next key is for the picture
    both = review.documents()[key]
    assert (both["review"], both.get("ignore")) == (mine, True)
    # the other choice: the first page's edit is kept
    wait_for(page, lambda s: s["docs"][key].get("ignore", False))  # the first page is notified
    select_track(page, key)  # a verdict has moved on to the next track
    theirs = edit_and_save(page, lambda: page.keyboard.press("x"))["docs"][key]["review"]
    other.keyboard.press("u")
    dialog.wait_for()
    dialog.get_by_role("button", name="Take the saved version").click()
    wait_for(other, lambda s: s["unsaved"] == 0)
    assert review.documents()[key]["review"] == theirs
    assert review.documents()[key].get("ignore", False) is True
    other.context.close()


def test_two_boxes_of_one_frame_are_seen_before_one_is_chosen(review: ReviewSession, page: Page) -> None:
    other, key = second_page(review, page)
    tracks = state(page)["tracks"]
    frame = tracks["first"][tracks["id"].index(int(key[1:]))]

    def moved(each: Page, right: int, down: int) -> None:
        each.keyboard.press("b")
        now = wait_for(each, lambda s: s["frame"] == frame and s["shown"] == frame and s["overlay"])
        x, y = centre(engine_box(now, key))
        drag(each, (x, y), (x + right, y + down))

    boxes = [edit_and_save(page, lambda: moved(page, 6, 4))["docs"][key]["keys"][str(frame)]["box"]]
    moved(other, -5, 6)
    wait_for(other, lambda s: s["unsaved"] == 1)
    # as soon as the server has refused it, the box in the picture is the saved one
    boxes.append(other.evaluate("tsr.store.get().review.unsaved[0].command.box"))
    dialog = other.locator("dialog[open]")
    for whose, box in zip(("saved", "mine"), boxes, strict=True):
        drawn = dialog.locator(f".two-versions-{whose}")
        drawn.wait_for()
        found = [float(drawn.get_attribute(name) or "nan") for name in ("x", "y", "width", "height")]
        assert found == pytest.approx([box[0], box[1], box[2] - box[0], box[3] - box[1]])
    assert dialog.get_by_text(f"Frame {frame}", exact=True).count() >= 1
    dialog.get_by_role("button", name="Keep mine").click()
    wait_for(other, lambda s: s["unsaved"] == 0)
    assert review.documents()[key]["keys"][str(frame)]["box"] == pytest.approx(boxes[1])
    other.context.close()


def test_an_edit_of_a_track_that_another_page_has_deleted(review: ReviewSession, page: Page) -> None:
    other, key = second_page(review, page)
    assert edit_and_save(page, lambda: page.keyboard.press("Shift+Delete"))["docs"][key]["gone"]
    other.keyboard.press("u")
    dialog = other.locator("dialog[open]")
    dialog.get_by_text("was deleted: “Keep mine” restores it").wait_for()
    assert dialog.get_by_role("row", name="State").get_by_role("cell").all_inner_texts() == ["deleted", "not reviewed"]
    dialog.get_by_role("button", name="Keep mine").click()
    wait_for(other, lambda s: s["unsaved"] == 0 and not s["docs"][key]["gone"])
    assert (review.documents()[key]["gone"], review.documents()[key].get("ignore", False)) == (False, True)
    other.context.close()
    # deleted tracks are listed and restored from the list
    wait_for(page, lambda s: s["docs"][key].get("ignore", False))
    select_track(page, key)
    assert edit_and_save(page, lambda: page.keyboard.press("Shift+Delete"))["docs"][key]["gone"]
    page.get_by_role("button", name=re.compile("deleted tracks?, show")).click()
    rows = page.get_by_role("list", name="Deleted tracks").get_by_role("listitem")
    row = rows.filter(has=page.get_by_role("button", name=f"Restore track #{key[1:]}", exact=True))
    row.get_by_text(re.compile("^deleted by .+ · ")).wait_for()
    assert row.locator("img").evaluate("async image => { await image.decode(); return image.naturalWidth; }") > 0
    back = edit_and_save(page, lambda: row.get_by_role("button", name="Restore").click())
    assert (back["docs"][key]["gone"], back["selected"]) == (False, key)
    row.wait_for(state="detached")
    page.keyboard.press("Escape")
    wait_until_no_dialog(page)
