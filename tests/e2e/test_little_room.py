"""The review page where room is little: low and narrow windows, pictures full of signs."""

from __future__ import annotations

import shutil
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import FloatRect, Locator, sync_playwright

from sample_videos import SHIPPED
from tests.e2e.live_server import LiveServer
from tests.e2e.review_desk import Desk, to_long_track, tracked, wait
from tests.e2e.screenshots import CHROMIUM, FLAGS, quiet

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not CHROMIUM.is_file(), reason=f"{CHROMIUM} is not installed"),
]
FRAMES = 150


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    home = tmp_path_factory.mktemp("room")
    roots = tmp_path_factory.mktemp("clips")
    shutil.copyfile(SHIPPED[0].video, roots / "clip.mp4")
    with LiveServer(home, roots=(roots,), sample=False) as server, sync_playwright() as playwright:
        video = str(server.add_video(roots / "clip.mp4")["id"])
        run = tracked(server, video, {"stop": FRAMES})
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
