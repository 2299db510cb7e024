"""Merging tracks that share frames, and key frames without a visible sign, in a real browser."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Locator, Page, expect

from sample_videos import SHIPPED
from tests.e2e.review_session import (
    ReviewSession,
    edit_and_save,
    import_tracks,
    select_track,
    serve_video,
    state,
    undone_at_end,
    wait_for,
)


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ReviewSession]:
    """A drive with tracks of another tracker."""
    with serve_video(tmp_path_factory, SHIPPED[0].video, "drive.mp4") as (server, browser, video):
        yield ReviewSession(
            server, browser, video, import_tracks(server, video, SHIPPED[0].truth.read_bytes(), "tracker")["id"]
        )


@pytest.fixture
def page(page: Page) -> Iterator[Page]:
    """A page that leaves nothing behind."""
    with undone_at_end(page):
        yield page


def overlapping(review: ReviewSession) -> tuple[str, str, int]:
    """Two tracks that share frames, and the number of these frames."""
    tracks = review.server.call("GET", f"/runs/{review.run}/tracks")
    spans = list(zip(tracks["id"], tracks["first"], tracks["last"], strict=True))
    shared = {
        (f"m{a}", f"m{b}"): min(last, end) - max(first, start) + 1
        for i, (a, first, last) in enumerate(spans)
        for b, start, end in spans[i + 1 :]
    }
    (one, other), frames = max(shared.items(), key=lambda pair: pair[1])
    assert frames > 1, spans
    return one, other, frames


def test_a_merge_of_tracks_that_share_frames_shows_both_and_asks(review: ReviewSession, page: Page) -> None:
    one, other, frames = overlapping(review)
    for key in (one, other):
        select_track(page, key)
        page.locator(".picture-stage").focus()
        if key == one:
            page.keyboard.press("m")
        else:
            page.keyboard.press("Enter")
    wait_for(page, lambda s: s["marked"] == [one, other])
    page.keyboard.press("m")
    dialog = page.get_by_role("dialog", name="These tracks share frames")
    expect(dialog).to_contain_text(f"have boxes in {frames} common frames")
    pictures = dialog.locator("svg.two-versions-picture")
    expect(pictures).to_have_count(2)
    expect(dialog.locator("rect")).to_have_count(4)
    expect(pictures.first).to_have_attribute("aria-label", f"{_frame(dialog)}: the box of #{one[1:]} stays")
    page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
    assert not any(doc["gone"] for doc in state(page)["docs"].values()), "nothing is merged unasked"
    page.keyboard.press("m")
    dialog.get_by_label(f"#{other[1:]} ·").check()
    expect(pictures.first).to_have_attribute("aria-label", f"{_frame(dialog)}: the box of #{other[1:]} stays")
    edit_and_save(page, dialog.get_by_role("button", name=f"Merge into #{other[1:]}").click)
    now = wait_for(page, lambda s: s["selected"] == other and s["mode"] == "select")
    assert now["docs"][one]["merged_into"] == other


def _frame(dialog: Locator) -> str:
    """The frame in the pictures."""
    caption = dialog.locator("figcaption").first.inner_text()
    return caption.split(":")[0]


def test_a_key_frame_where_the_track_has_no_box_says_what_it_copied(review: ReviewSession, page: Page) -> None:
    tracks = review.server.call("GET", f"/runs/{review.run}/tracks")
    at = min(range(len(tracks["id"])), key=lambda i: tracks["last"][i])
    key, last = f"m{tracks['id'][at]}", tracks["last"][at]
    page.keyboard.press("j")
    wait_for(page, lambda s: s["selected"] is not None)
    select_track(page, key)
    page.wait_for_function("id => tsr.store.get().review.laneOf[id]", arg=tracks["id"][at])
    frame = last + 8
    page.evaluate("(frame) => tsr.store.dispatch((s) => ({...s, review: {...s.review, frame}}))", frame)
    wait_for(page, lambda s: s["shown"] == frame and s["overlay"])
    page.locator(".picture-stage").focus()
    edit_and_save(page, lambda: page.keyboard.press("k"))
    notice = page.locator(".toast")
    expect(notice).to_contain_text(f"had no box in frame {frame}: the box of frame {last} was copied here.")
    edit_and_save(page, notice.get_by_role("button", name="Undo").click)
    assert str(frame) not in state(page)["docs"].get(key, {"keys": {}})["keys"]
    page.keyboard.press("i")
    expect(page.locator(".toast").last).to_contain_text("Needs a key frame before and after. Set one at frame")
    expect(page.get_by_role("button", name="Set key frame")).to_be_visible()
