"""Every number of a comparison opens the frames behind it; what can be compared is reported by video."""

from __future__ import annotations

import shutil
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Route, expect, sync_playwright

from sample_videos import SHIPPED
from tests.e2e.live_server import LiveServer
from tests.e2e.review_desk import PATIENCE, Desk, imported
from tests.e2e.screenshots import CHROMIUM, FLAGS

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not CHROMIUM.is_file(), reason=f"{CHROMIUM} is not installed"),
]


def worse() -> bytes:
    """The truth of the drive as a tracker that loses signs, calls some another class, and sees one that is none."""
    head, *rows = SHIPPED[0].truth.read_text().splitlines()
    names = head.split(",")
    at, who, left, right, label = (names.index(name) for name in ("frame", "track_id", "x1", "x2", "class_id"))
    out = [head]
    for row in rows:
        cells = row.split(",")
        frame, track = int(cells[at]), int(cells[who])
        if track % 4 == 3 or frame % 40 in range(10, 18):
            continue
        cells[who] = str(track if frame % 40 < 10 else track + 100)
        cells[left], cells[right] = (str(float(cells[k]) + 1.0) for k in (left, right))
        cells[label] = "14" if track % 4 == 2 else cells[label]
        out.append(",".join(cells))
    out += [",".join(["5", "900", "10", "10", "50", "50", "14", *["0"] * (len(names) - 7)])]
    return "\n".join(out).encode()


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    home = tmp_path_factory.mktemp("compare")
    roots = tmp_path_factory.mktemp("clips")
    for name, shipped in zip(("first.mp4", "second.mp4"), SHIPPED, strict=False):
        shutil.copyfile(shipped.video, roots / name)
    with LiveServer(home, roots=(roots,), sample=False) as server, sync_playwright() as playwright:
        videos = [str(server.add_video(roots / name)["id"]) for name in ("first.mp4", "second.mp4")]
        run = imported(server, videos[0], worse(), "worse")["id"]
        imported(server, videos[1], SHIPPED[1].truth.read_bytes(), "other")
        imported(server, videos[0], SHIPPED[0].truth.read_bytes(), "exact", "truth")
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield Desk(server, browser, videos[0], run)
        browser.close()


def test_each_number_opens_the_frames_behind_it(desk: Desk) -> None:
    page = desk.browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
    page.set_default_timeout(1000 * PATIENCE)
    page.goto(desk.server.link())
    truth = desk.server.call("GET", f"/videos/{desk.video}/ground-truths")["ground_truths"][0]["id"]
    page.evaluate("hash => { location.hash = hash }", f"#/compare?a=truth:{truth}&b=run:{desk.run}")
    page.locator(".figures-table tbody tr").first.wait_for()
    rows = page.locator(".figures-table tbody tr")
    opened = 0
    for row in rows.all():
        for number in row.locator("button").all():
            number.click()
            assert page.locator(".place").count() > 0, row.inner_text()
            opened += 1
        if not row.locator("button").count():
            assert "none" in row.inner_text(), "a number without frames behind it says so"
    assert opened >= 2 * rows.count() - 4
    for number in page.locator(".matrix button").all():
        number.click()
        assert page.locator(".place").count() > 0
    # and a place is a frame of the video, with both sides in sight
    page.locator(".figure-open").first.click()
    page.locator(".place").first.click()
    page.wait_for_function("() => { const r = tsr.store.get().review; return r?.layers.truth && r.shown === r.frame; }")


def test_what_can_be_compared_is_grouped_under_its_video(desk: Desk) -> None:
    page = desk.page()
    page.get_by_role("button", name="Compare", exact=True).click()
    choice = page.locator("#compare-b")
    groups = choice.locator("optgroup")
    expect(groups.first).to_have_attribute("label", "Runs of first.mp4")
    labels = [group.get_attribute("label") for group in groups.all()]
    assert labels == ["Runs of first.mp4", "Corrections on first.mp4", "Ground truth of first.mp4"]
    held: list[Route] = []
    page.route("**/ground-truths", lambda route: held.append(route))
    page.get_by_label("Video", exact=True).last.select_option(label="second.mp4")
    expect(page.get_by_role("dialog").get_by_role("button", name="Compare", exact=True)).to_be_disabled()
    while not held:
        page.wait_for_timeout(20)
    held[0].continue_()
    expect(groups.first).to_have_attribute("label", "Runs of second.mp4")
    assert "other" in choice.locator("option").first.inner_text()
    assert "first.mp4" not in (choice.inner_html())
