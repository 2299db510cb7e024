"""The library, the dialogs and the comparison, as a person uses them, in a real browser on a real server."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, expect, sync_playwright

from sample_videos import SHIPPED
from tests.e2e.live_server import LiveServer
from tests.e2e.screenshots import CHROMIUM, FLAGS

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not CHROMIUM.is_file(), reason=f"{CHROMIUM} is not installed"),
]


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    with LiveServer(tmp_path_factory.mktemp("home"), roots=(SHIPPED[0].video.parent,)) as running:
        running.wait_for_run(SHIPPED[1].video.name)
        yield running


@pytest.fixture
def page(server: LiveServer) -> Iterator[Page]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        errors: list[str] = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(server.link())
        yield page
        assert errors == []
        browser.close()


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
    expect(page.get_by_role("heading", name="my <b>drive.mp4")).to_be_visible(timeout=30_000)
    expect(page.get_by_role("listitem").filter(has_text="my <b>drive")).to_contain_text("300 frames", timeout=60_000)
    chooser.set_input_files(wrong)
    failed = page.locator(".upload-failed, .card-message-bad").first
    expect(failed).to_be_visible(timeout=30_000)
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


def test_parameters_are_checked_while_typing_and_a_run_can_be_cancelled_and_removed(page: Page) -> None:
    _open_runs(page, SHIPPED[1].video.name)
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Search parameters").fill("tau")
    field = dialog.get_by_label("tau", exact=True)
    field.fill("-3")
    expect(dialog.get_by_text("Not below 0.")).to_be_visible()
    expect(dialog.get_by_role("button", name="Start the run")).to_be_disabled()
    field.fill("25")
    dialog.get_by_label("Last frame").fill("5000")
    expect(dialog.get_by_text("The video has the frames 0 to 299.")).to_be_visible()
    dialog.get_by_label("Last frame").fill("99")
    dialog.get_by_label("Name").fill("looser gate")
    dialog.get_by_role("button", name="Start the run").click()
    item = dialog.get_by_role("listitem").filter(has_text="looser gate")
    expect(item).to_contain_text("tau = 25")
    item.get_by_role("button", name="Cancel").click()
    expect(item).to_contain_text("cancelled", timeout=30_000)
    item.get_by_role("button", name="Remove the run").click()
    page.get_by_role("button", name="Remove", exact=True).click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    _open_runs(page, SHIPPED[1].video.name)
    expect(page.get_by_role("dialog").get_by_role("listitem").filter(has_text="looser gate")).to_have_count(0)


def test_a_what_if_lists_what_changes_and_opens_its_frame(page: Page) -> None:
    _open_runs(page, SHIPPED[1].video.name)
    page.get_by_role("button", name="What if").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("See what would change")
    dialog.get_by_label("Search parameters").fill("birth")
    dialog.get_by_label("birth_score", exact=True).fill("100")
    dialog.get_by_role("button", name="Replay").click()
    row = dialog.locator(".change-row:visible").first
    expect(row).to_be_visible(timeout=180_000)
    row.click()
    page.wait_for_function("() => tsr.store.get().review?.second", timeout=30_000)
    page.wait_for_function("() => tsr.store.get().review.frame === tsr.store.get().review.shown")


def test_a_comparison_opens_the_frames_behind_a_number(page: Page, server: LiveServer) -> None:
    video = server.wait_for_run(SHIPPED[1].video.name)
    server.call("PUT", f"/videos/{video['id']}/truths/exact", body=SHIPPED[1].truth.read_bytes(), type_="text/csv")
    page.get_by_role("link", name=f"Review {video['name']}").click()
    page.get_by_role("button", name="Compare").click()
    page.get_by_role("dialog").get_by_role("button", name="Compare").click()
    expect(page.get_by_role("heading", name="Confusion of classes")).to_be_visible(timeout=30_000)
    page.get_by_role("button", name="False boxes").click()
    place = page.locator(".place").first
    frame = int(place.locator(".place-frames").inner_text().split()[-1].replace(",", "").split("\u2013")[0])
    place.click()
    page.wait_for_function("frame => tsr.store.get().review?.shown === frame", arg=frame, timeout=30_000)


def test_the_theme_is_kept_over_a_reload(page: Page) -> None:
    theme = page.get_by_role("button", name="Theme")
    theme.click()
    theme.click()
    expect(page.locator("html")).to_have_attribute("data-theme", "dark")
    page.reload()
    expect(page.locator("html")).to_have_attribute("data-theme", "dark")
