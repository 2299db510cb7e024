"""Corrections of a run in another tool and in a newer run, and its what-ifs."""

from __future__ import annotations

import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, expect

from sample_videos import SHIPPED
from tests.e2e.review_session import (
    MAX_WAIT_S,
    ReviewSession,
    choose_label,
    edit_and_save,
    open_address,
    open_long_track,
    open_session,
    reload_review,
    wait_for,
    wait_until_no_dialog,
)
from tests.e2e.scenes import quiet

FRAMES = 120
"""Of the run that other files share."""
LATER_FRAMES = 45
"""Of a newer run: enough for the long track of the first frame."""
LONG = 60
"""Length of that track at least; no other one is as long."""


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ReviewSession]:
    with open_session(tmp_path_factory, SHIPPED[0].video, FRAMES, "clip.mp4") as review:
        yield review


def exported(review: ReviewSession, folder: Path) -> Path:
    """The current run as a CVAT file."""
    made = review.server.call("POST", "/exports", {"runs": [review.run], "format": "cvat-video", "pictures": "none"})[
        "id"
    ]
    end = time.monotonic() + MAX_WAIT_S
    while (now := review.server.call("GET", f"/outputs/{made}"))["state"] != "complete":
        assert time.monotonic() < end, now
        assert now["state"] != "failed", now
        time.sleep(0.1)
    request = urllib.request.Request(review.server.base + f"/api/outputs/{made}/download")
    request.add_header("Authorization", "Bearer " + (review.server.home / "token").read_text().strip())
    with urllib.request.urlopen(request, timeout=60) as answer:
        (folder / "labels.zip").write_bytes(answer.read())
    return folder / "labels.zip"


def lane_of(page: Page, key: str) -> Any:
    """The engine's lane of a track, once loaded."""
    return page.wait_for_function("k => tsr.store.get().review.laneOf[Number(k.slice(1))]", arg=key).json_value()


def test_another_class_keeps_source_score_and_lanes(review: ReviewSession, page: Page, tmp_path: Path) -> None:
    key = str(open_long_track(page)["selected"])
    lane = lane_of(page, key)
    assert set(lane["source"]) <= {0, 1, 2}
    page.keyboard.press("l")
    edit_and_save(page, lambda: choose_label(page, "stop"))
    content = exported(review, tmp_path)
    edit_and_save(page, lambda: page.keyboard.press("Control+z"))
    page.locator("[data-operation=import]").click()
    page.locator("#import-file").set_input_files(content)
    page.locator("[name=import-as][value=annotation]").check()
    page.get_by_role("button", name="Import", exact=True).click()
    page.get_by_role("button", name="Show the corrected run").click()
    now = wait_for(page, lambda s: s["docs"].get(key, {}).get("class_id") == 14)
    assert now["docs"][key]["keys"] == {}
    assert lane_of(page, key) == lane
    expect(page.locator(".lanes-detail-name")).to_contain_text("stop")


def test_a_sign_that_is_not_in_the_set_and_the_way_back_to_the_engines(review: ReviewSession, page: Page) -> None:
    key = str(open_long_track(page)["selected"])
    page.get_by_role("tab", name="Inspector").click()
    human = page.locator(".inspector-human")
    engine: str = page.evaluate(
        """k => { const { labels, review: { tracks } } = tsr.store.get();
        return labels[tracks.class_id[tracks.id.indexOf(Number(k.slice(1)))]].name; }""",
        key,
    )
    page.keyboard.press("l")
    page.locator("dialog[open] input:focus").wait_for()
    edit_and_save(page, lambda: page.get_by_role("button", name="Not in the set", exact=True).click())
    assert wait_for(page, lambda s: s["docs"].get(key, {}).get("class_id") == -1)
    page.locator(".inspector-name", has_text="not in the set").wait_for()
    expect(human).to_have_text(f"Label set by a person; the engine reads {engine}.")
    # a label of one box, then the engine's label for the whole track: it applies to every box
    page.keyboard.press("l")
    page.locator("dialog[open] input:focus").wait_for()
    page.keyboard.press("Alt+b")
    expect(page.get_by_role("button", name="As the whole track")).to_be_visible()
    edit_and_save(page, lambda: choose_label(page, "yield"))
    page.locator(".inspector-human", has_text="Single boxes have other labels: give way in frame").wait_for()
    page.keyboard.press("l")
    edit_and_save(page, lambda: page.get_by_role("button", name="As read by the engine").click())
    now = wait_for(page, lambda s: s["docs"][key]["class_id"] is None)
    assert now["docs"][key]["keys"] == {}
    page.locator(".inspector-name", has_text=engine).wait_for()
    expect(human).to_be_hidden()
    # Enter alone changes nothing, nor does the same label
    for act in (
        lambda: page.keyboard.press("Enter"),
        lambda: page.get_by_role("button", name="As read by the engine").click(),
    ):
        page.keyboard.press("l")
        page.locator("dialog[open] input:focus").wait_for()
        act()
        wait_until_no_dialog(page)
    assert wait_for(page, lambda s: s["unsaved"] == 0)["undo"] == now["undo"]
    edit_and_save(page, lambda: page.keyboard.press("Control+z"))
    assert wait_for(page, lambda s: s["docs"][key]["class_id"] == -1)["docs"][key]["keys"], (
        "undo brings single ones back"
    )
    for _ in range(2):
        edit_and_save(page, lambda: page.keyboard.press("Control+z"))


def test_corrections_of_an_earlier_run_are_offered_to_a_new_one(review: ReviewSession, page: Page) -> None:
    key = str(open_long_track(page, LONG)["selected"])
    page.keyboard.press("l")
    edit_and_save(page, lambda: choose_label(page, "yield"))
    page.keyboard.press("v")
    at = wait_for(page, lambda s: s["frame"] == s["shown"] > 0)["frame"]
    later = review.server.track(review.video, {"stop": LATER_FRAMES, "name": "Later"})
    page.locator(".topbar-run").select_option(later)
    notice = page.locator(".banner", has_text="in an earlier run")
    notice.get_by_role("button", name="Carry them over").click()
    reported = page.get_by_role("dialog").get_by_role("status")
    reported.filter(has_text="1 track kept, 0 not needed").wait_for()
    page.get_by_role("dialog").get_by_role("button", name="Close").last.click()
    now = wait_for(page, lambda s: s["run"] == later and s["docs"])
    assert now["frame"] == at
    assert [doc["class_id"] for doc in now["docs"].values()] == [13]
    notice.wait_for(state="detached")
    assert reload_review(page)["docs"]
    assert notice.count() == 0
    # more corrections there are reported again, and the notice can be dismissed for good
    page.locator(".topbar-run").select_option(review.run)
    wait_for(page, lambda s: s["run"] == review.run and key in s["docs"])
    open_address(page, f"#/review/{review.video}/{review.run}?track={key}")
    wait_for(page, lambda s: s["selected"] == key)
    page.keyboard.press("l")
    edit_and_save(page, lambda: choose_label(page, "stop"))
    wait_for(page, lambda s: s["docs"][key]["class_id"] == 14 and s["unsaved"] == 0)
    for reported_again in (True, False):
        with page.expect_response(f"**/runs/{later}/earlier"):
            page.locator(".topbar-run").select_option(later)
        wait_for(page, lambda s: s["run"] == later and s["docs"] and s["overlay"] is not None)
        if reported_again:
            notice.get_by_role("button", name="Hide this warning").click()
        quiet(page)
        expect(notice).to_have_count(0)
        page.locator(".topbar-run").select_option(review.run)
        wait_for(page, lambda s: s["run"] == review.run)


def test_what_ifs_stand_under_their_run_have_names_and_go_at_once(review: ReviewSession, page: Page) -> None:
    for tau in (5.0, 40.0):
        made = review.server.call("POST", f"/runs/{review.run}/whatif", {"parameters": {"tau": tau}})["id"]
        end = time.monotonic() + 240
        while review.server.call("GET", f"/runs/{made}")["state"] != "complete":
            assert time.monotonic() < end
            time.sleep(0.1)
    later = str(review.server.call("POST", f"/videos/{review.video}/runs", {"stop": 2, "name": "Newest"})["id"])
    page.get_by_role("button", name="Runs", exact=True).click()
    items = page.locator(".run-item")
    items.filter(has_text="tau = 5").wait_for()
    names = page.locator(".run-item .run-name").all_inner_texts()
    mine = next(i for i, name in enumerate(names) if name == "Run 1")
    assert names[mine + 1 : mine + 3] == ["tau = 40", "tau = 5"]
    under = items.filter(has_text="tau = 5")
    assert "run-under" in (under.get_attribute("class") or "")
    under.get_by_role("button", name="Rename").click()
    page.locator("dialog[open] input:focus").wait_for()
    page.keyboard.type("A strict gate")
    page.keyboard.press("Enter")
    items.filter(has_text="A strict gate").wait_for()
    items.filter(has_text="A strict gate").get_by_role("button", name="Rename").click()
    page.locator("dialog[open] input:focus").wait_for()
    page.keyboard.type("never mind")
    page.keyboard.press("Escape")
    page.get_by_role("dialog").wait_for()
    assert "A strict gate" in page.locator(".run-item .run-name").all_inner_texts()
    items.filter(has_text="Remove its 2 what-ifs").get_by_role("button", name="Remove its 2 what-ifs").click()
    page.get_by_role("dialog").get_by_role("button", name="Remove", exact=True).click()
    page.get_by_text("2 what-ifs were removed.").wait_for()
    left = {run["kind"] for run in review.server.call("GET", f"/videos/{review.video}/runs")["runs"]}
    assert left == {"engine"}
    assert later
