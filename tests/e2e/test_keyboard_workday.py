"""A day's work with the keyboard alone, from the library to a new model version. On a real server."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, expect

from sample_videos import SHIPPED
from tests.e2e.review_session import (
    ReviewSession,
    edit_and_save,
    import_tracks,
    open_address,
    serve_video,
    wait_for,
    wait_until_drawn,
    wait_until_no_dialog,
)

FOCUSED = """() => { const one = document.activeElement;
  const said = one.getAttribute('aria-label') ?? one.labels?.[0]?.textContent ?? one.textContent;
  return {said: said.trim(), seen: one.matches(':focus-visible')}; }"""


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ReviewSession]:
    with serve_video(tmp_path_factory, SHIPPED[0].video, "drive.mp4") as (server, browser, video):
        yield ReviewSession(
            server, browser, video, import_tracks(server, video, SHIPPED[0].truth.read_bytes(), "tracker")["id"]
        )


def tab_to(page: Page, name: str, *, back: bool = False) -> None:
    """Tab to a control by its name; fails if Tab does not reach it or its focus is not visible."""
    messages = []
    for _ in range(150):
        page.keyboard.press("Shift+Tab" if back else "Tab")
        now = page.evaluate(FOCUSED)
        messages.append(now["said"])
        if now["said"].startswith(name):
            assert now["seen"], name
            return
    raise AssertionError(f"Tab does not lead to {name!r}: {list(dict.fromkeys(messages))}")


def test_a_day_without_a_mouse(review: ReviewSession, page: Page) -> None:
    open_address(page, "#/")
    tab_to(page, "Review drive.mp4")
    page.keyboard.press("Enter")
    # the review opens at the first open track
    opened = wait_for(page, lambda s: s["selected"] is not None and s["shown"] == s["frame"] and s["overlay"])
    key = opened["selected"]
    now = edit_and_save(page, lambda: page.keyboard.press("a"))
    assert now["docs"][key]["review"] == "accepted"
    # box, end and label of the next one; the label's dialog accepts it as well
    second = wait_for(page, lambda s: s["selected"] not in (None, key) and s["shown"] == s["frame"] and s["overlay"])
    other, at = second["selected"], second["frame"]
    edit_and_save(page, lambda: page.keyboard.press("Shift+ArrowRight"))
    page.keyboard.press("f")
    wait_for(page, lambda s: s["frame"] == at + 1 and s["shown"] == s["frame"] and s["overlay"])
    edit_and_save(page, lambda: page.keyboard.press("Alt+Delete"))
    page.keyboard.press("l")
    page.locator("dialog[open] input:focus").wait_for()
    page.keyboard.type("keep right")
    now = edit_and_save(page, lambda: page.keyboard.press("Control+Enter"))
    doc = now["docs"][other]
    assert (doc["review"], doc["class_id"]) == ("accepted", 38)
    assert max(part["last"] for part in doc["segments"]) == at + 1
    assert str(at) in doc["keys"]
    assert now["docs"] == review.documents()

    # corrections against the engine: a number, its places, and one of them
    wait_until_no_dialog(page)
    page.keyboard.press("Control+k")
    page.locator("dialog[open] input:focus").wait_for()
    page.keyboard.type("compare")
    expect(page.locator("dialog [role=option]").first).to_contain_text("Compare")
    page.keyboard.press("Enter")
    expect(page.get_by_role("dialog").get_by_role("button", name="Compare")).to_be_enabled()
    tab_to(page, "Compare")
    page.keyboard.press("Enter")
    page.locator(".figures-table").wait_for()
    wait_until_no_dialog(page)
    tab_to(page, "Precision")
    page.keyboard.press("Enter")
    expect(page.get_by_role("complementary", name="Frames behind a figure").get_by_role("heading")).to_be_focused()
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    wait_until_drawn(page)

    page.keyboard.press("Shift+E")
    dialog = page.get_by_role("dialog")
    expect(dialog.get_by_role("button", name="Export", exact=True)).to_be_enabled()
    tab_to(page, "Export")
    page.keyboard.press("Enter")
    expect(dialog.get_by_role("link", name="Download")).to_be_visible()
    page.keyboard.press("Escape")
    wait_until_no_dialog(page)

    tab_to(page, "Models", back=True)
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Retrain").wait_for()
    tab_to(page, "Retrain")
    page.keyboard.press("Enter")
    expect(dialog.get_by_role("checkbox", name="drive.mp4")).to_be_checked()
    tab_to(page, "Detector")
    page.keyboard.press("Space")
    expect(dialog.get_by_role("checkbox", name=re.compile("^Detector"))).not_to_be_checked()
    tab_to(page, "Retrain")
    page.keyboard.press("Enter")
    wait_until_no_dialog(page)
    tab_to(page, "Cancel")
    page.keyboard.press("Enter")
    expect(page.get_by_text("cancelled", exact=True)).to_be_visible()
