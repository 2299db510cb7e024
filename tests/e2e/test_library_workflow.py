"""The library, the dialogs and the comparison in a real browser on a real server."""

from __future__ import annotations

import json
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import BrowserContext, Page, Route, expect

from sample_videos import SHIPPED
from tests.e2e.forked_server import ForkedServer
from tests.e2e.interception import intercept
from tests.e2e.live_server import LiveServer
from tests.e2e.review_session import fresh_page, go_back, open_address, without_errors

DRIVE = SHIPPED[0]
FRAMES = 100
"""Tracked part of the drive: the whole drive takes too long for a test."""
MAX_WORK_MS = 240_000
"""Patience with the engine on a slow machine, ms."""


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory, window: BrowserContext) -> Iterator[LiveServer]:
    with ForkedServer(tmp_path_factory.mktemp("home"), roots=(DRIVE.video.parent,)) as running:
        # opened before any import: it learns everything later by events
        first = fresh_page(window, running)
        first.goto(running.link())
        expect(first.get_by_role("link", name="Review the sample drive")).to_be_visible(timeout=MAX_WORK_MS)
        expect(first.locator(".welcome-progress .meter")).to_be_visible(timeout=MAX_WORK_MS)
        first.close()
        end = time.monotonic() + MAX_WORK_MS / 1000
        while len(begun := _sample_runs(running)) < len(SHIPPED):
            assert time.monotonic() < end
            time.sleep(0.1)
        for run in begun.values():
            running.call("POST", f"/runs/{run}/cancel")
        videos = running.call("GET", "/videos")["videos"]
        video = next(one for one in videos if one["name"] == DRIVE.video.name)
        running.call("POST", f"/videos/{video['id']}/runs", {"stop": FRAMES})
        running.wait_for_run(DRIVE.video.name, MAX_WORK_MS / 1000)
        yield running


def _sample_runs(server: LiveServer) -> dict[str, str]:
    """Runs that the server started by itself, by name of the video."""
    videos = server.call("GET", "/videos")["videos"]
    return {one["name"]: one["latest_run"] for one in videos if one["latest_run"]}


@pytest.fixture
def page(server: LiveServer, window: BrowserContext) -> Iterator[Page]:
    with without_errors(fresh_page(window, server)) as page:
        page.goto(server.link())
        yield page


def _open_runs(page: Page, name: str) -> None:
    page.get_by_role("button", name=f"of {name}").first.click()
    page.locator("dialog[open]").wait_for()


def test_a_new_user_sees_the_sample_drive_and_reaches_it_with_one_button(page: Page) -> None:
    expect(page.get_by_role("heading", name="Start with the sample drive")).to_be_visible()
    expect(page.locator(".hint")).to_have_count(3)
    page.get_by_role("link", name="Review the sample drive").click()
    expect(page.get_by_role("tab", name="Queue")).to_be_visible()
    expect(page.locator(".review-grid")).to_be_visible()


def test_an_upload_appears_and_a_wrong_one_says_why(page: Page, tmp_path: Path) -> None:
    clip = tmp_path / "my <b>drive.mp4"
    clip.write_bytes(SHIPPED[1].video.read_bytes() + b"\0" * 16)  # other bytes, another video
    wrong = tmp_path / "text.mp4"
    wrong.write_text("this is no video")
    chooser = page.get_by_label("Video files to upload")
    chooser.set_input_files(clip)
    expect(page.get_by_role("heading", name="my <b>drive.mp4")).to_be_visible()
    card = page.get_by_role("listitem").filter(has_text="my <b>drive")
    expect(card).to_have_count(1)  # the upload's line and the video's card are there together for a moment
    expect(card).to_contain_text("300 frames", timeout=MAX_WORK_MS)
    chooser.set_input_files(wrong)
    failed = page.locator(".upload-failed, .card-message-bad").first
    expect(failed).to_be_visible()
    assert len(failed.inner_text()) > 20
    page.get_by_role("button", name="Remove my <b>drive.mp4").click()
    expect(page.get_by_role("dialog")).to_contain_text("stays where it is")
    page.get_by_role("button", name="Remove", exact=True).click()
    expect(page.get_by_role("heading", name="my <b>drive.mp4")).to_have_count(0)


def test_a_path_outside_the_folders_is_refused_in_words(page: Page, tmp_path: Path) -> None:
    outside = tmp_path / "outside.mp4"
    shutil.copyfile(SHIPPED[1].video, outside)
    page.get_by_role("button", name="Add from folder").first.click()
    expect(page.get_by_role("dialog").get_by_role("button", name="country_road.mp4")).to_be_visible()
    page.get_by_label("Path").fill(str(outside))
    page.keyboard.press("Enter")
    expect(page.locator("#add-error")).not_to_be_empty()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    expect(page.get_by_role("button", name="Add from folder").first).to_be_focused()


def test_several_videos_of_a_folder_are_added_at_once(page: Page) -> None:
    names = ("a.mp4", "b.mp4", "c.mp4")
    videos = [{"name": name, "path": f"/v/{name}", "size": 1} for name in names]
    folder = {"path": "/v", "parent": None, "folders": [], "videos": videos, "truncated": False}
    intercept(page, re.compile(r"/api/browse"), lambda route: route.fulfill(json=folder))
    known = page.evaluate("async () => (await (await fetch('/api/videos')).json()).videos[0]")
    requests: list[str] = []

    def add(route: Route) -> None:
        if route.request.method != "POST":
            route.continue_()
            return
        path = json.loads(route.request.post_data or "")["path"]
        requests.append(path)
        if path.endswith("b.mp4"):
            route.fulfill(status=422, json={"error": {"code": "invalid", "message": "b.mp4 is no video."}})
        else:
            route.fulfill(status=201, json=known)

    intercept(page, re.compile(r"/api/videos$"), add)
    page.get_by_role("button", name="Add from folder").first.click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("button", name="Choose all 3").click()
    dialog.get_by_role("button", name="c.mp4").click()
    dialog.get_by_role("button", name="Add 2 videos").click()
    expect(dialog.locator("#add-error")).to_have_text("b.mp4 is no video.")
    expect(dialog.locator("[aria-pressed=true]")).to_have_count(1)
    assert requests == ["/v/a.mp4", "/v/b.mp4"]
    dialog.get_by_role("button", name="b.mp4").click()
    expect(dialog.locator("#add-error")).to_be_hidden()
    dialog.get_by_role("button", name="c.mp4").focus()
    page.keyboard.press("Enter")
    expect(dialog.get_by_label("Path")).to_have_value("/v/c.mp4")
    page.keyboard.press("Enter")
    expect(dialog).to_have_count(0)
    assert requests[2:] == ["/v/c.mp4"]


def test_all_videos_without_a_run_get_one(page: Page) -> None:
    known = page.evaluate("async () => (await (await fetch('/api/videos')).json()).videos[0]")
    ran = page.evaluate("async (id) => (await fetch(`/api/runs/${id}`)).json()", known["latest_run"])
    new = [{**known, "id": digit * 64, "name": f"{digit}.mp4", "runs": 0, "latest_run": None} for digit in "abc"]
    intercept(page, re.compile(r"/api/videos$"), lambda route: route.fulfill(json={"videos": [known, *new]}))
    requests: list[str] = []

    def start(route: Route) -> None:
        video = route.request.url.split("/")[-2]
        requests.append(video[0])
        error = {"code": "full", "message": "There is no room for b.mp4."}
        run = {**ran, "id": video[:32], "video_id": video, "state": "queued"}
        route.fulfill(status=507, json={"error": error}) if video[0] == "b" else route.fulfill(status=201, json=run)

    intercept(page, re.compile(r"/api/videos/[abc]{64}/runs$"), start)
    page.reload()
    page.get_by_label("Search videos").fill("c.mp4")
    expect(page.get_by_role("button", name="Run all new")).to_be_hidden()
    page.get_by_label("Search videos").fill("")
    page.get_by_role("button", name="Run all new (3)").click()
    page.get_by_role("button", name="Start the runs").click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    expect(page.get_by_text("2 runs are started.")).to_be_visible()
    expect(page.get_by_text("There is no room for b.mp4.")).to_be_visible()
    assert requests == ["a", "b", "c"]


def test_a_folder_that_holds_more_than_is_listed_says_so(page: Page) -> None:
    folder = {"path": "/v", "parent": None, "folders": ["<b>drives"], "videos": [], "truncated": True}
    intercept(page, re.compile(r"/api/browse"), lambda route: route.fulfill(json=folder))
    page.get_by_role("button", name="Add from folder").first.click()
    dialog = page.get_by_role("dialog")
    expect(dialog.get_by_role("button", name="<b>drives")).to_be_visible()
    expect(dialog.get_by_text("Only the first 1 folder or video by name are listed.")).to_be_visible()
    expect(dialog.get_by_text("No video in this folder")).to_have_count(0)
    page.keyboard.press("Escape")


def test_parameters_are_checked_while_typing_and_a_run_can_be_cancelled_and_removed(page: Page) -> None:
    _open_runs(page, DRIVE.video.name)
    dialog = page.get_by_role("dialog")
    dialog.get_by_text("Parameters", exact=True).click()
    dialog.get_by_label("Search parameters").fill("tau")
    field = dialog.get_by_label("tau", exact=True)
    field.fill("-3")
    expect(dialog.get_by_text("Not below 0.")).to_be_visible()
    expect(dialog.get_by_role("button", name="Start the run")).to_be_disabled()
    field.fill("25")
    dialog.get_by_label("Last frame").fill("5000")
    expect(dialog.get_by_text("The video has the frames 0 to 299.")).to_be_visible()
    dialog.get_by_label("Last frame").fill("298")  # long enough to be cancelled
    dialog.get_by_label("Name", exact=True).fill("looser gate")
    dialog.get_by_role("button", name="Start the run").click()
    expect(dialog).to_be_hidden()
    _open_runs(page, DRIVE.video.name)
    item = dialog.get_by_role("listitem").filter(has_text="looser gate")
    expect(item).to_contain_text("tau = 25")
    item.get_by_role("button", name="Cancel").click()
    expect(item).to_contain_text("cancelled", timeout=MAX_WORK_MS)
    item.get_by_role("button", name="Remove looser gate").click()
    page.get_by_role("button", name="Remove", exact=True).click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    _open_runs(page, DRIVE.video.name)
    expect(page.get_by_role("dialog").get_by_role("listitem").filter(has_text="looser gate")).to_have_count(0)


def test_the_library_counts_what_was_reviewed_whichever_way_one_comes_back(page: Page, server: LiveServer) -> None:
    video = server.wait_for_run(DRIVE.video.name)
    card = page.get_by_role("listitem").filter(has=page.get_by_role("heading", name=DRIVE.video.name, exact=True))
    expect(card.get_by_text(re.compile(r"^0 of \d+ tracks reviewed$"))).to_be_visible()
    page.get_by_role("link", name=f"Review {video['name']}").click()
    page.wait_for_function("() => tsr.store.get().review?.selected")  # the first open one
    page.keyboard.press("a")
    page.wait_for_function("() => Object.values(tsr.store.get().review.docs).some(doc => doc.review === 'accepted')")
    page.wait_for_function("() => tsr.store.get().review.unsaved.length === 0")
    page.get_by_role("link", name="Files").click()
    page.get_by_role("link", name="Library").click()
    expect(card.get_by_text(re.compile(r"^1 of \d+ tracks reviewed$"))).to_be_visible()
    go_back(page)
    go_back(page)
    page.wait_for_function("() => tsr.store.get().review?.undo")
    page.keyboard.press("Control+z")
    page.wait_for_function("() => Object.values(tsr.store.get().review.docs).every(doc => doc.review === 'open')")
    page.wait_for_function("() => tsr.store.get().review.unsaved.length === 0")


def test_a_what_if_lists_what_changes_and_opens_its_frame(page: Page) -> None:
    _open_runs(page, DRIVE.video.name)
    page.get_by_role("button", name="What if").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("See what would change")
    dialog.get_by_label("Search parameters").fill("birth")
    dialog.get_by_label("birth_score", exact=True).fill("100")
    dialog.get_by_role("button", name="Replay").click()
    row = dialog.locator(".change-row:visible").first
    expect(row).to_be_visible(timeout=MAX_WORK_MS)
    row.click()
    page.wait_for_function("() => tsr.store.get().review?.second")
    page.wait_for_function("() => tsr.store.get().review.frame === tsr.store.get().review.shown")


def test_a_comparison_opens_the_frames_behind_a_number(page: Page, server: LiveServer) -> None:
    video = server.wait_for_run(DRIVE.video.name)
    page.get_by_role("link", name=f"Review {video['name']}").click()
    page.get_by_role("button", name="Compare").click()
    page.get_by_role("dialog").get_by_role("button", name="Compare").click()
    expect(page.get_by_role("heading", name="Confusion of labels")).to_be_visible()
    page.locator(".figures-table button").first.click()
    place = page.locator(".place").first
    frame = int(place.locator(".place-frames").inner_text().split()[-1].replace(",", "").split("\u2013")[0])
    place.click()
    page.wait_for_function("frame => tsr.store.get().review?.shown === frame", arg=frame)


def test_the_theme_is_kept_over_a_reload(page: Page) -> None:
    theme = page.get_by_role("button", name="Theme")
    theme.click()
    theme.click()
    expect(page.locator("html")).to_have_attribute("data-theme", "dark")
    page.reload()
    expect(page.locator("html")).to_have_attribute("data-theme", "dark")


def test_thousands_of_videos_cost_what_is_on_screen_and_all_are_found(server: LiveServer, page: Page) -> None:
    one = server.call("GET", "/videos")["videos"][0]

    def many(route: Route) -> None:
        days = (
            {**one, "id": f"{i:064x}", "name": f"drive {i}.mp4", "runs": 0, "latest_run": None} for i in range(5000)
        )
        route.fulfill(body=json.dumps({"videos": [*days]}), content_type="application/json")

    page.route("**/api/videos", many)
    page.reload()
    cards, more = page.locator(".card"), page.get_by_role("button", name="Show more")
    expect(page.locator(".library-head")).to_contain_text("5,000 videos")
    expect(cards.first).to_be_visible()
    begun = cards.count()
    assert begun < 200
    expect(more).to_contain_text("left")
    # the list has no visible end for keyboard and wheel
    cards.nth(begun - 1).locator("button").last.focus()
    page.keyboard.press("Tab")
    page.wait_for_function("before => document.querySelectorAll('.card').length > before", arg=begun)
    more.focus()
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.activeElement.closest('.card') !== null")
    # the search covers all of them, not only the shown ones
    page.get_by_role("searchbox", name="Search videos").fill("drive 4987")
    expect(cards).to_have_count(1)
    expect(more).to_be_hidden()
    # returning from another screen restores everything
    open_address(page, "#/files")
    expect(page.get_by_role("heading", name="Files", exact=True)).to_be_visible()
    open_address(page, "#/")
    expect(page.get_by_role("searchbox", name="Search videos")).to_have_value("drive 4987")
    expect(cards).to_have_count(1)
