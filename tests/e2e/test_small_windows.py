"""The review page in small windows: low and narrow ones, and pictures full of signs.

The run is an import of the sample's exact ground truth with scores, so that no test waits for the engine.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import FloatRect, Locator, Page, expect

from sample_videos import SHIPPED
from tests.e2e.review_session import (
    ReviewSession,
    centre,
    edit_and_save,
    import_tracks,
    open_address,
    reload_review,
    screen_point,
    select_long_track,
    serve_video,
    wait_for,
    wait_until_no_dialog,
)
from tests.e2e.scenes import quiet

UNTIDY = """() => {
  const found = [];
  const root = [...document.querySelectorAll('dialog[open]')].at(-1) ?? document;
  const name = (e) => (e.getAttribute('aria-label') || e.textContent || e.className).trim().slice(0, 30);
  const shown = (e) => e.checkVisibility({checkOpacity: true, checkVisibilityCSS: true});
  const seen = (e) => shown(e) && !e.closest('.visually-hidden');
  // what of it is in sight, and how much of its width is hidden for good
  const sight = (e) => {
    const {left, top, right, bottom} = e.getBoundingClientRect();
    const box = {left, top, right, bottom};
    let cut = 0;
    for (let p = e.parentElement; p; p = p.parentElement) {
      const style = getComputedStyle(p);
      const q = p.getBoundingClientRect();
      if (['hidden', 'clip'].includes(style.overflowX)) cut = Math.max(cut, box.right - q.right, q.left - box.left);
      if (style.overflowX !== 'visible') {
        [box.left, box.right] = [Math.max(box.left, q.left), Math.min(box.right, q.right)];
      }
      if (style.overflowY !== 'visible') {
        [box.top, box.bottom] = [Math.max(box.top, q.top), Math.min(box.bottom, q.bottom)];
      }
    }
    return {e, box, cut: Math.max(cut, box.right - innerWidth, -box.left)}; // what can be scrolled to is no loss
  };
  const controls = [...root.querySelectorAll('button, a.btn, select, input, .badge, .nav-link')].filter(seen).map(sight)
    .filter(({box}) => box.right - box.left > 1 && box.bottom - box.top > 1);
  for (const {e, cut} of controls) {
    if (cut > 1.5) found.push(`cut off: ${name(e)}`);
    const tight = e.matches('button, .btn, .badge') && e.scrollWidth > e.clientWidth + 2;
    if (tight) found.push(`its words are cut: ${name(e)}`);
  }
  controls.forEach((a, i) => controls.slice(i + 1).forEach((b) => {
    if (a.e.contains(b.e) || b.e.contains(a.e)) return;
    const wide = Math.min(a.box.right, b.box.right) - Math.max(a.box.left, b.box.left);
    const high = Math.min(a.box.bottom, b.box.bottom) - Math.max(a.box.top, b.box.top);
    if (wide > 2 && high > 2) found.push(`over each other: ${name(a.e)}, ${name(b.e)}`);
  }));
  for (const e of root.querySelectorAll('span, p, h1, h2, h3, strong, td, th')) {
    if (e.children.length || !seen(e) || e.closest('.truncate, .lanes, .queue-reason, .matrix')) continue;
    if (sight(e).cut > 2) found.push(`words cut off: ${name(e)}`);
  }
  if (document.documentElement.scrollWidth > innerWidth) found.push('the page scrolls sideways');
  return found;
}"""
"""What of the page, or of the dialog over it, lies over something else or is cut off."""


def another_tracker() -> bytes:
    """The ground truth of the drive as a tracker's table; each track has its own score."""
    head, *rows = SHIPPED[0].truth.read_text().splitlines()
    place = head.split(",").index("track_id")
    scored = [f"{row},{0.5 + int(row.split(',')[place]) % 40 / 100}" for row in rows]
    return "\n".join([f"{head},score", *scored]).encode()


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ReviewSession]:
    with serve_video(tmp_path_factory, SHIPPED[0].video, "clip.mp4") as (server, browser, video):
        yield ReviewSession(server, browser, video, import_tracks(server, video, another_tracker(), "tracker")["id"])


def rect_of(found: Locator) -> FloatRect:
    """Where something is."""
    box = found.bounding_box()
    assert box is not None
    return box


def bottom_of(found: Locator) -> float:
    box = rect_of(found)
    return box["y"] + box["height"]


def test_bar_gate_and_votes_stand_under_a_usable_picture(page: Page) -> None:
    page.keyboard.press("Shift+L")
    selected = select_long_track(page)["selected"]
    page.locator(".lanes-detail").wait_for()
    quiet(page)
    assert page.locator(".lanes-detail").evaluate("pane => pane.scrollTop") == 0
    for lane in ("gate", "votes"):
        assert bottom_of(page.locator(f".lanes-lane-{lane}")) <= 720, lane
    row = page.evaluate(
        """async key => {
          const {buildLaneIndex} = await import('/static/js/model/lanes_lod.js');
          const {trackEntries} = await import('/static/js/model/track_entries.js');
          const {tracks, lanes, docs} = tsr.store.get().review;
          const index = buildLaneIndex(trackEntries(tracks, docs), lanes, docs);
          const pane = document.querySelector('.lanes-tracks');
          const high = pane.querySelector('.lanes-spacer').clientHeight / index.rows;
          const top = index.row[index.barOf.get(key)] * high - pane.scrollTop;
          return top >= 0 && top + high <= pane.clientHeight;
        }""",
        selected,
    )
    assert row, "the bar of the selected track is in sight"
    assert rect_of(page.locator(".picture-stage"))["height"] >= 280


def test_where_the_lanes_begin_is_remembered(page: Page) -> None:
    line = page.get_by_role("separator", name="Height of the folded lanes")
    line.focus()
    before = rect_of(page.locator(".lanes"))["height"]
    page.keyboard.press("Shift+ArrowUp")
    quiet(page)
    after = rect_of(page.locator(".lanes"))["height"]
    assert after > before + 20
    reload_review(page)
    quiet(page)
    assert abs(rect_of(page.locator(".lanes"))["height"] - after) < 2


def test_the_queue_is_filtered_by_score(review: ReviewSession, page: Page) -> None:
    scores = review.server.call("GET", f"/runs/{review.run}/tracks")["score"]
    limit = (min(scores) + max(scores)) / 2
    below = sum(score <= limit for score in scores)
    assert 0 < below < len(scores)
    page.locator(".queue-row").filter(has_text="score").first.wait_for()
    page.get_by_label("Maximum score").fill(str(limit))
    page.get_by_text(f"{below} of {len(scores)} shown").wait_for()
    page.get_by_label("Maximum score").fill("")
    page.get_by_label("Minimum score").fill(str(limit))
    page.get_by_text(f"{len(scores) - below} of {len(scores)} shown").wait_for()
    assert "best of its detections" in (page.get_by_label("Minimum score").get_attribute("title") or "")


def test_notes_are_found_again(page: Page) -> None:
    selected = select_long_track(page)["selected"]
    page.get_by_role("tab", name="Inspector").click()
    page.locator(".notes-form .textarea").fill("Behind the lorry")
    edit_and_save(page, page.locator(".notes-form .btn").click)
    page.get_by_role("tab", name="Queue").click()
    found = page.locator(f"#queue-{selected}")
    for on, off in (
        (lambda: page.get_by_label("Search tracks").fill("lorry"), lambda: page.get_by_label("Search tracks").fill("")),
        (page.get_by_role("button", name="Only tracks with notes").click,) * 2,
    ):
        on()
        expect(page.locator(".queue-row")).to_have_count(1)
        assert "Note: Behind the lorry" in (found.get_attribute("title") or "")
        off()
        expect(page.locator(".queue-row")).not_to_have_count(1)


def test_ground_truth_that_is_shown_says_whose_it_is(review: ReviewSession, page: Page) -> None:
    import_tracks(review.server, review.video, SHIPPED[0].truth.read_bytes(), "Surveyed by Ann", "truth")
    reload_review(page)
    badge = page.locator(".picture-badge")
    legend = page.locator(".legend-item", has_text="Truth")
    assert badge.is_hidden()

    def place() -> Any:
        return page.locator(".picture-stage").bounding_box()

    before = place()
    page.keyboard.press("7")
    expect(badge).to_have_text("Ground truth: Surveyed by Ann")
    expect(legend).to_have_attribute("title", "Ground truth: Surveyed by Ann (7)")
    assert place() == before, "the picture does not jump"
    assert bottom_of(badge) < bottom_of(page.locator(".picture-stage"))
    page.keyboard.press("7")
    expect(badge).to_be_hidden()


WIDTHS = (640, 700, 760)


def layout_faults(page: Page) -> dict[int, Any]:
    """Layout faults in narrow windows by width, once each is stable."""
    found = {}
    for width in WIDTHS:
        page.set_viewport_size({"width": width, "height": 720})
        quiet(page)
        found[width] = page.evaluate(UNTIDY)
    return {width: what for width, what in found.items() if what}


def test_nothing_overlaps_or_is_cut_off_in_a_narrow_window(review: ReviewSession, page: Page) -> None:
    select_long_track(page)
    page.set_viewport_size({"width": WIDTHS[0], "height": 720})
    for tab in ("Inspector", "Queue"):
        page.get_by_role("tab", name=tab).click()
        assert layout_faults(page) == {}, tab
    for opener in ("Runs", "Compare"):
        page.get_by_role("button", name=opener, exact=True).click()
        page.locator("dialog[open] .run-item, dialog[open] option").first.wait_for(state="attached")
        assert layout_faults(page) == {}, opener
        page.keyboard.press("Escape")
        wait_until_no_dialog(page)
    other = f"#/compare?a=annotation:{review.run}&b=run:{review.run}"
    for address, ready in (("#/", ".card"), (other, ".figures-table"), ("#/files", "main h1"), ("#/models", ".model")):
        open_address(page, address)
        page.locator(ready).first.wait_for()
        assert layout_faults(page) == {}, address


OUT_OF_SIGHT = """() => {
  const found = [];
  const shown = (e) => e.tabIndex >= 0 && e.checkVisibility({checkOpacity: true, checkVisibilityCSS: true});
  for (const e of document.querySelectorAll('button, a[href]:not(.skip-link), select, input, textarea, [tabindex]')) {
    if (!shown(e)) continue;
    e.focus();
    const {left, top, right, bottom, width, height} = e.getBoundingClientRect();
    const box = [Math.max(left, 0), Math.max(top, 0), Math.min(right, innerWidth), Math.min(bottom, innerHeight)];
    for (let p = e.parentElement; p; p = p.parentElement) {
      if (getComputedStyle(p).overflow === 'visible') continue;
      const q = p.getBoundingClientRect();
      [box[0], box[1]] = [Math.max(box[0], q.left), Math.max(box[1], q.top)];
      [box[2], box[3]] = [Math.min(box[2], q.right), Math.min(box[3], q.bottom)];
    }
    const inSight = box[2] - box[0] >= Math.min(width, 20) - 1 && box[3] - box[1] >= Math.min(height, 20) - 1;
    const crop = e.closest('.crops-scroll'); // arrow keys go through them
    if (document.activeElement !== e || !(inSight || crop)) found.push(e.getAttribute('aria-label') || e.textContent);
  }
  return found;
}"""
"""What has the focus and is not to be seen."""


def test_zoom_leaves_a_picture_and_everything_in_reach(page: Page) -> None:
    select_long_track(page)
    for width, height in ((911, 512), (683, 384), (640, 360)):
        page.set_viewport_size({"width": width, "height": height})
        quiet(page)
        stage = rect_of(page.locator(".picture-stage"))
        assert stage["height"] >= 150
        assert stage["y"] + stage["height"] <= height
        assert rect_of(page.locator(".queue-list"))["height"] >= 74, "a row of the queue"
        for tab in ("Inspector", "Queue"):
            page.get_by_role("tab", name=tab).click()
            page.keyboard.press("Tab")
            quiet(page)
            assert page.evaluate(UNTIDY) == [], (tab, width)
            assert page.evaluate(OUT_OF_SIGHT) == [], (tab, width)
        page.locator(".lanes-detail").focus()
        assert rect_of(page.locator(".lanes-lane-gate"))["y"] + 30 <= height
        if height < 480:
            assert bottom_of(page.locator(".lanes-lane-gate")) <= height


def test_the_key_h_names_only_what_one_looks_at_and_is_remembered(page: Page) -> None:
    select_long_track(page)
    button = page.get_by_role("button", name="Fewer names in the picture")
    assert "(H)" in (button.get_attribute("title") or "")
    expect(button).to_have_attribute("aria-pressed", "false")
    page.keyboard.press("h")
    expect(button).to_have_attribute("aria-pressed", "true")
    now = wait_for(page, lambda s: s["shown"] == s["frame"] and s["overlay"] is not None)
    under = now["overlay"]["tracks"][0]
    page.mouse.move(*screen_point(page, *centre(under["box"])))
    page.wait_for_function("key => tsr.store.get().review.hovered === key", arg=f"m{under['id']}")
    page.mouse.move(5, 5)
    page.wait_for_function("() => tsr.store.get().review.hovered === null")
    reload_review(page)
    expect(button).to_have_attribute("aria-pressed", "true")
    button.click()
    expect(button).to_have_attribute("aria-pressed", "false")
    page.keyboard.press("F1")
    row = page.locator(".help-list dd", has_text="Fewer names in the picture")
    expect(row).to_be_visible()
    assert row.locator("xpath=preceding-sibling::dt[1]").inner_text() == "H"


def test_no_filter_of_the_queue_stands_in_a_row_of_its_own(page: Page) -> None:
    for width in (1280, 1920, 2560):
        page.set_viewport_size({"width": width, "height": 1080})
        quiet(page)
        filters = page.locator(".queue-filters > .select, .queue-filters > .input").filter(visible=True)
        tops = filters.evaluate_all("all => all.map((one) => one.offsetTop)")
        assert [tops.count(top) for top in sorted(set(tops))] == [3, 3], width


def test_the_toolbar_stands_in_one_row(page: Page) -> None:
    for width in (1280, 1811):
        page.set_viewport_size({"width": width, "height": 720})
        quiet(page)
        tops = page.locator(".toolbar-group").evaluate_all("groups => groups.map((g) => g.getBoundingClientRect().top)")
        assert len(set(tops)) == 1, width


def test_the_run_that_is_open_can_be_told_from_the_others(review: ReviewSession, page: Page) -> None:
    name = "Run 1 with another tau, and none of the window rescoring"
    run = import_tracks(review.server, review.video, another_tracker(), name)
    open_address(page, f"#/review/{review.video}/{run['id']}")
    chooser = page.locator(".topbar-run")
    for width in (1001, 1024, 1240):
        page.set_viewport_size({"width": width, "height": 768})
        expect(chooser).to_have_value(run["id"])
        quiet(page)
        shown = chooser.evaluate("select => select.selectedOptions[0].text")
        assert name in shown
        expect(chooser).to_have_attribute("title", shown)
        assert rect_of(chooser)["width"] >= 200
        assert rect_of(page.locator(".topbar"))["height"] <= 48, "one row"
        assert page.evaluate(UNTIDY) == [], width
