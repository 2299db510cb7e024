"""The review page where room is little: low and narrow windows, pictures full of signs.

The run is the sample's exact truth, imported as somebody else's run with scores, so that nothing waits for the engine.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import FloatRect, Locator, expect, sync_playwright

from sample_videos import SHIPPED
from tests.e2e.live_server import LiveServer
from tests.e2e.review_desk import Desk, to_long_track, wait
from tests.e2e.screenshots import CHROMIUM, FLAGS, quiet

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not CHROMIUM.is_file(), reason=f"{CHROMIUM} is not installed"),
]


def another_tracker() -> bytes:
    """The truth of the drive as a tracker's table; each track has a score of its own."""
    head, *rows = SHIPPED[0].truth.read_text().splitlines()
    place = head.split(",").index("track_id")
    scored = [f"{row},{0.5 + int(row.split(',')[place]) % 40 / 100}" for row in rows]
    return "\n".join([f"{head},score", *scored]).encode()


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    home = tmp_path_factory.mktemp("room")
    roots = tmp_path_factory.mktemp("clips")
    shutil.copyfile(SHIPPED[0].video, roots / "clip.mp4")
    with LiveServer(home, roots=(roots,), sample=False) as server, sync_playwright() as playwright:
        video = str(server.add_video(roots / "clip.mp4")["id"])
        asked = f"/videos/{video}/imports?as=run&name=tracker&format=tracks-csv"
        run = server.call("POST", asked, another_tracker(), "application/octet-stream")["id"]
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield Desk(server, browser, video, run)
        browser.close()


def place(found: Locator) -> FloatRect:
    """Where something is."""
    box = found.bounding_box()
    assert box is not None
    return box


def bottom(found: Locator) -> float:
    box = place(found)
    return box["y"] + box["height"]


def test_bar_gate_and_votes_stand_under_a_usable_picture(desk: Desk) -> None:
    page = desk.page()
    selected = to_long_track(page)["selected"]
    page.locator(".lanes-detail").wait_for()
    quiet(page)
    assert page.locator(".lanes-detail").evaluate("pane => pane.scrollTop") == 0
    for lane in ("gate", "votes"):
        assert bottom(page.locator(f".lanes-lane-{lane}")) <= 720, lane
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
    assert place(page.locator(".picture-stage"))["height"] >= 280


def test_where_the_lanes_begin_is_remembered(desk: Desk) -> None:
    page = desk.page()
    line = page.get_by_role("separator", name="Height of the lanes")
    line.focus()
    before = place(page.locator(".lanes"))["height"]
    page.keyboard.press("Shift+ArrowUp")
    after = place(page.locator(".lanes"))["height"]
    assert after > before + 20
    page.reload()
    wait(page, lambda s: s["overlay"] is not None)
    assert abs(place(page.locator(".lanes"))["height"] - after) < 2


def test_the_queue_is_filtered_by_score(desk: Desk) -> None:
    page = desk.page()
    scores = desk.server.call("GET", f"/runs/{desk.run}/tracks")["score"]
    limit = (min(scores) + max(scores)) / 2
    below = sum(score <= limit for score in scores)
    assert 0 < below < len(scores)
    page.locator(".queue-row").filter(has_text="score").first.wait_for()
    page.get_by_label("Largest score").fill(str(limit))
    page.get_by_text(f"{below} of {len(scores)} shown").wait_for()
    page.get_by_label("Largest score").fill("")
    page.get_by_label("Least score").fill(str(limit))
    page.get_by_text(f"{len(scores) - below} of {len(scores)} shown").wait_for()
    assert "best of its detections" in (page.get_by_label("Least score").get_attribute("title") or "")


def test_ground_truth_that_is_shown_says_whose_it_is(desk: Desk) -> None:
    asked = f"/videos/{desk.video}/imports?as=truth&name=Surveyed by Ann&format=tracks-csv".replace(" ", "%20")
    desk.server.call("POST", asked, SHIPPED[0].truth.read_bytes(), "application/octet-stream")
    page = desk.page()
    badge = page.locator(".picture-badge")
    legend = page.locator(".legend-item", has_text="Truth")
    assert badge.is_hidden()
    page.keyboard.press("7")
    expect(badge).to_have_text("Ground truth: Surveyed by Ann")
    expect(legend).to_contain_text("Surveyed by Ann")
    assert bottom(badge) < bottom(page.locator(".picture-stage"))
    page.keyboard.press("7")
    expect(badge).to_be_hidden()
    expect(legend).not_to_contain_text("Surveyed by Ann")
