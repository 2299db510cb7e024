"""Layout of the review screen, and the frame in which a track is judged. On the engine's run of the sample."""

from __future__ import annotations

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, expect

from tests.e2e.review_session import ReviewSession, edit_and_save, reload_review, wait_for, wait_until_no_dialog
from tests.e2e.scenes import quiet
from tests.e2e.test_small_windows import OUT_OF_SIGHT, UNTIDY, rect_of


def to_track(page: Page) -> str:
    """Open the first track of the queue; its key."""
    page.keyboard.press("j")
    now = wait_for(page, lambda s: s["selected"] is not None and s["shown"] == s["frame"] and s["overlay"])
    page.locator(".lanes-detail").wait_for()
    return str(now["selected"])


def test_the_picture_takes_most_of_the_window_and_bars_and_one_lane_stand_below(page: Page) -> None:
    to_track(page)
    for width, height in ((1280, 720), (1440, 900)):
        page.set_viewport_size({"width": width, "height": height})
        quiet(page)
        assert rect_of(page.locator(".picture-stage"))["height"] >= 0.6 * height
        assert rect_of(page.locator(".picture-foot"))["height"] <= 36, "one row"
        bars, lane = rect_of(page.locator(".lanes-tracks")), rect_of(page.locator(".lanes-lane-gate"))
        assert bars["height"] >= 24
        assert lane["y"] + lane["height"] <= height + 1
        expect(page.locator(".lanes-lane-name:visible")).to_have_count(1)
        assert page.evaluate(UNTIDY) == [], width


def test_the_chosen_lane_and_the_fold_are_remembered(page: Page) -> None:
    to_track(page)
    page.get_by_label("Lane", exact=True).select_option("votes")
    expect(page.locator(".lanes-lane-votes")).to_be_visible()
    expect(page.locator(".lanes-lane-gate")).to_be_hidden()
    reload_review(page)
    expect(page.locator(".lanes-lane-votes")).to_be_visible()
    page.locator(".picture-stage").focus()
    page.keyboard.press("Shift+L")
    expect(page.locator(".lanes-lane-name:visible")).to_have_count(8)
    expect(page.get_by_label("Lane", exact=True)).to_be_hidden()
    reload_review(page)
    expect(page.locator(".lanes-lane-gate")).to_be_visible()
    page.get_by_role("button", name="Fold lanes").click()
    expect(page.locator(".lanes-lane-name:visible")).to_have_count(1)


def test_queue_and_inspector_stand_side_by_side_where_there_is_room(page: Page) -> None:
    key = to_track(page)
    for width, height in ((1600, 900), (1920, 1080), (3840, 2160)):
        page.set_viewport_size({"width": width, "height": height})
        queue, inspector = page.get_by_role("region", name="Queue").first, page.locator(".inspector")
        expect(queue).to_be_visible()
        is_one_line = """(e) => e.scrollWidth <= e.clientWidth
            && e.clientHeight < 2 * parseFloat(getComputedStyle(e).fontSize)"""
        assert queue.locator(".queue-counts").evaluate(is_one_line), width
        expect(inspector).to_contain_text(f"Track #{key[1:]}")
        expect(page.get_by_role("tab")).to_have_count(0)
        quiet(page)
        assert rect_of(page.locator(".queue"))["x"] + 240 < rect_of(inspector)["x"]
        stage = rect_of(page.locator(".picture-stage"))
        assert stage["height"] >= 0.6 * height
        assert stage["width"] >= 0.6 * width
        assert page.evaluate(UNTIDY) == [], width
        font = page.evaluate("() => parseFloat(getComputedStyle(document.body).fontSize)")
        assert font >= height / 100, "no tiny letters on a large screen"
        page.set_viewport_size({"width": 1280, "height": 720})
        expect(page.get_by_role("tab")).to_have_count(2)
        expect(page.get_by_role("tabpanel")).to_have_count(1)


def test_the_count_of_open_tracks_is_whole_beside_the_button_of_deleted_ones(page: Page) -> None:
    to_track(page)
    page.set_viewport_size({"width": 1600, "height": 950})
    edit_and_save(page, lambda: page.keyboard.press("Shift+Delete"))
    expect(page.get_by_role("button", name="1 deleted")).to_be_visible()
    counts = page.locator(".queue-counts")
    assert counts.evaluate("(e) => e.scrollWidth <= e.clientWidth"), counts.inner_text()
    assert page.evaluate(UNTIDY) == []
    edit_and_save(page, lambda: page.keyboard.press("Control+z"))


def test_a_key_a_click_and_a_verdict_lead_to_the_same_frame_of_a_track(review: ReviewSession, page: Page) -> None:
    tracks = review.server.call("GET", f"/runs/{review.run}/tracks")
    key = to_track(page)
    at = tracks["id"].index(int(key[1:]))
    clearest, first = tracks["clearest"][at], tracks["first"][at]
    assert first < clearest
    wait_for(page, lambda s: s["frame"] == clearest)

    def inside() -> None:
        """The cursor in the first frame of the track."""
        page.locator(".picture-stage").focus()
        page.keyboard.press("b")
        wait_for(page, lambda s: s["frame"] == first and s["selected"] == key)

    inside()
    page.locator(f"#queue-{key}").click()
    wait_for(page, lambda s: s["frame"] == clearest and s["selected"] == key)
    inside()
    page.keyboard.press("Escape")
    wait_for(page, lambda s: s["selected"] is None)
    page.keyboard.press("j")
    wait_for(page, lambda s: s["frame"] == clearest and s["selected"] == key)
    page.keyboard.press("j")
    other = wait_for(page, lambda s: s["selected"] not in (None, key))["selected"]
    page.keyboard.press("Shift+J")
    wait_for(page, lambda s: s["selected"] == key)
    inside()
    edit_and_save(page, lambda: page.keyboard.press("a"))
    wait_for(
        page, lambda s: s["selected"] == other and s["frame"] == tracks["clearest"][tracks["id"].index(int(other[1:]))]
    )
    edit_and_save(page, lambda: page.keyboard.press("Control+z"))


def test_the_library_opens_a_review_at_the_first_track_that_is_left(review: ReviewSession, page: Page) -> None:
    key = to_track(page)
    edit_and_save(page, lambda: page.keyboard.press("a"))
    other = wait_for(page, lambda s: s["selected"] not in (None, key))
    page.evaluate("location.hash = '#/'")
    page.get_by_role("link", name="Review drive.mp4").click()
    wait_for(page, lambda s: s["selected"] == other["selected"] and s["frame"] == s["shown"] == other["frame"])
    edit_and_save(page, lambda: page.keyboard.press("Control+z"))


def test_a_track_ends_where_the_end_of_its_bar_is_let_go(review: ReviewSession, page: Page) -> None:
    key = to_track(page)
    tracks = review.server.call("GET", f"/runs/{review.run}/tracks")
    last = tracks["last"][tracks["id"].index(int(key[1:]))]
    handle, before = page.locator(".lanes-end"), review.documents().get(key)

    def hold() -> None:
        handle.wait_for()
        at = rect_of(handle)
        page.mouse.move(at["x"] + at["width"] / 2, at["y"] + at["height"] / 2)
        page.mouse.down()
        wait_for(page, lambda s: s["frame"] == last)
        page.mouse.move(at["x"] - 60, at["y"] + at["height"] / 2, steps=6)
        wait_for(page, lambda s: s["frame"] < last - 3)

    hold()
    page.keyboard.press("Escape")
    wait_for(page, lambda s: s["frame"] == last)
    page.mouse.up()
    assert review.documents().get(key) == before
    hold()
    end = wait_for(page, lambda s: s["frame"] == s["shown"])["frame"]
    edit_and_save(page, page.mouse.up)
    assert [part["last"] for part in review.documents()[key]["segments"]] == [end]
    page.locator(".picture-stage").focus()
    page.keyboard.press("f")
    wait_for(page, lambda s: s["frame"] == end + 1)
    page.get_by_role("tab", name="Inspector").click()
    expect(page.locator(".inspector")).to_contain_text("The track has no box of the engine in this frame.")
    edit_and_save(page, lambda: page.keyboard.press("Control+z"))
    assert [part["last"] for part in review.documents()[key]["segments"]] == [last]


LONG = """() => tsr.store.dispatch((state) => ({...state, labels: state.labels.map((label, i) => ({...label,
  name: (i % 2 ? 'Donaudampfschifffahrt'.repeat(10) : 'a very long name of a label '.repeat(8)).slice(0, 200)}))}))"""
"""Labels of 200 characters, with and without spaces."""


def test_long_labels_and_400_percent_leave_everything_in_reach(page: Page) -> None:
    to_track(page)
    page.evaluate(LONG)
    stage = page.locator(".picture-stage")
    for width, height in ((1280, 720), (640, 720), (480, 270), (320, 180)):
        page.set_viewport_size({"width": width, "height": height})
        for tab in ("Inspector", "Queue"):
            page.get_by_role("tab", name=tab).focus()
            page.get_by_role("tab", name=tab).press("Enter")
            quiet(page)
            assert page.evaluate(UNTIDY) == [], (tab, width)
            assert page.evaluate(OUT_OF_SIGHT) == [], (tab, width)
        assert rect_of(stage)["width"] >= min(width, 380)
        assert rect_of(stage)["height"] >= 150
        page.keyboard.press("Control+k")
        page.locator("dialog[open] input:focus").wait_for()
        page.keyboard.type("label")
        quiet(page)
        assert page.evaluate(UNTIDY) == [], ("palette", width)
        page.keyboard.press("Escape")
        wait_until_no_dialog(page)
