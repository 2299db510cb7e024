"""Every number of a comparison opens its frames; sides to compare are listed by video."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, Route, expect

from sample_videos import SHIPPED
from tests.attack.many_tracks import mot_archive
from tests.e2e.browsers import open_browser
from tests.e2e.forked_server import ForkedServer
from tests.e2e.interception import intercept
from tests.e2e.review_session import ReviewSession, fresh_page, go_back, import_tracks, open_address
from tests.e2e.test_small_windows import rect_of


def worse_tracks() -> bytes:
    """The ground truth of the drive as a tracker that loses signs, confuses a class, and reports a false sign."""
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
def review(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ReviewSession]:
    home = tmp_path_factory.mktemp("compare")
    roots = tmp_path_factory.mktemp("clips")
    for name, shipped in zip(("first.mp4", "second.mp4"), SHIPPED, strict=False):
        shutil.copyfile(shipped.video, roots / name)
    with ForkedServer(home, roots=(roots,), sample=False) as server, open_browser() as browser:
        videos = [str(server.add_video(roots / name)["id"]) for name in ("first.mp4", "second.mp4")]
        run = import_tracks(server, videos[0], worse_tracks(), "worse")["id"]
        import_tracks(server, videos[1], SHIPPED[1].truth.read_bytes(), "other")
        import_tracks(server, videos[0], SHIPPED[0].truth.read_bytes(), "exact", "truth")
        yield ReviewSession(server, browser, videos[0], run)


def test_each_number_opens_the_frames_behind_it(review: ReviewSession) -> None:
    page = fresh_page(review.window, review.server)
    page.goto(review.server.link())
    truth = review.server.call("GET", f"/videos/{review.video}/ground-truths")["ground_truths"][0]["id"]
    open_address(page, f"#/compare?a=truth:{truth}&b=run:{review.run}")
    page.locator(".figures-table tbody tr").first.wait_for()
    rows = page.locator(".figures-table tbody tr")
    opened = 0
    for row in rows.all():
        for number in row.locator("button").all():
            number.click()
            page.locator(".place").first.wait_for()
            opened += 1
        if not row.locator("button").count():
            assert "none" in row.inner_text(), "a number without frames behind it says so"
    assert opened >= 2 * rows.count() - 4
    for number in page.locator(".matrix button").all():
        number.click()
        page.locator(".place").first.wait_for()
    # a place is a frame of the video with both sides visible
    page.locator(".figure-open").first.click()
    page.locator(".place").first.click()
    page.wait_for_function("() => { const r = tsr.store.get().review; return r?.layers.truth && r.shown === r.frame; }")


def opened(review: ReviewSession, run: str, truth: str) -> Page:
    """The comparison of a run's corrections with a ground truth, in a separate window."""
    page = fresh_page(review.window, review.server)
    page.goto(review.server.link())
    open_address(page, f"#/compare?a=truth:{truth}&b=annotation:{run}")
    page.locator(".figures-table tbody tr").first.wait_for()
    return page


def test_places_show_both_boxes_and_ground_truth_is_taken_over_with_one_undo(review: ReviewSession) -> None:
    run = str(import_tracks(review.server, review.video, worse_tracks(), "to be corrected")["id"])
    truth = review.server.call("GET", f"/videos/{review.video}/ground-truths")["ground_truths"][0]["id"]
    page = opened(review, run, truth)
    recall = page.locator(".figures-table tbody tr", has_text="Recall").locator(".figure-value")
    before = recall.inner_text()
    assert before != "100 %"
    page.get_by_role("button", name="Missed boxes").last.click()
    # the crop is a part of the picture, with the box of the truth on it
    place = page.locator(".place").first
    expect(place.locator(".place-box-reference")).to_have_count(1)
    page.wait_for_function("() => document.querySelector('.place img').naturalWidth === 128")
    # a place opens close to the pair, with the sign of the truth chosen
    place.click()
    page.wait_for_function(
        "() => { const r = tsr.store.get().review;"
        " return r && r.truthSign !== null && r.shown === r.frame && r.viewport.zoom > 1; }"
    )
    expect(page.locator(".truth-words")).to_contain_text("Sign ")
    go_back(page)
    page.get_by_role("button", name=re.compile(r"^Take over \d+ signs$")).click()
    expect(page.locator(".toasts")).to_contain_text("Taken over:")
    expect(recall).to_have_text("100 %")
    page.locator(".toasts").get_by_role("button", name="Undo").click()
    expect(recall).to_have_text(before)


def test_a_box_of_the_ground_truth_is_chosen_and_taken_over_by_keys(review: ReviewSession) -> None:
    run = str(import_tracks(review.server, review.video, worse_tracks(), "by keys")["id"])
    truth = review.server.call("GET", f"/videos/{review.video}/ground-truths")["ground_truths"][0]["id"]
    page = opened(review, run, truth)
    page.get_by_role("button", name="Missed boxes").last.click()
    page.locator(".place").first.click()
    page.wait_for_function(
        "() => { const r = tsr.store.get().review;"
        " return r && r.truthSign !== null && r.overlays[r.frame] && r.truth[r.frame]; }"
    )
    sign = page.evaluate("() => tsr.store.get().review.truthSign")
    box = page.evaluate(
        "() => { const r = tsr.store.get().review; return r.truth[r.frame].find((b) => b.track === r.truthSign).box; }"
    )
    page.keyboard.press("Shift+Y")  # the box alone
    boxes = (
        "Object.values(tsr.store.get().review.docs).flatMap((d) => Object.values(d.gone ? {} : d.keys))"
        ".filter(({box}) => box !== null)"
    )
    page.wait_for_function(f"() => {boxes}.length === 1")
    assert page.evaluate(boxes)[0]["box"] == pytest.approx(box, abs=0.1)
    page.keyboard.press("Control+z")
    page.wait_for_function(f"() => {boxes}.length === 0")
    page.keyboard.press("y")
    page.wait_for_function("() => tsr.store.get().review.truthSign !== null")
    while page.evaluate("() => tsr.store.get().review.truthSign") != sign:
        page.keyboard.press("y")
        page.wait_for_timeout(20)
    page.keyboard.press("Alt+y")  # the whole sign
    expect(page.locator(".toasts")).to_contain_text("Taken over:")
    # the sign in the upper half of the picture: its bar, the hint and the notice share the lower edge
    page.evaluate(
        "(sign) => tsr.store.dispatch((s) => ({...s, review: {...s.review, selected: null, truthSign: sign,"
        " viewport: {...s.review.viewport, y: s.review.viewport.y + 50}}}))",
        sign,
    )
    parts = [page.locator(name) for name in (".picture-hint", ".picture-truth-below", ".toasts")]
    for part in parts:
        expect(part).to_be_visible()
    hint, bar, notice = (rect_of(part) for part in parts)
    assert bar["y"] + bar["height"] <= hint["y"]
    assert notice["y"] + notice["height"] <= bar["y"]
    page.wait_for_function("() => tsr.store.get().review.undo?.name === 'take_over'")
    page.keyboard.press("Control+z")
    page.wait_for_function("() => tsr.store.get().review.redo?.name === 'take_over'")


def test_what_can_be_compared_is_grouped_under_its_video(review: ReviewSession, page: Page) -> None:
    page.get_by_role("button", name="Compare", exact=True).click()
    choice = page.locator("#compare-b")
    groups = choice.locator("optgroup")
    expect(groups.first).to_have_attribute("label", "Runs of first.mp4")
    labels = [group.get_attribute("label") for group in groups.all()]
    assert labels == ["Runs of first.mp4", "Corrections on first.mp4", "Ground truth of first.mp4"]
    held: list[Route] = []
    intercept(page, "**/ground-truths", lambda route: held.append(route))
    page.get_by_label("Video", exact=True).last.select_option(label="second.mp4")
    expect(page.get_by_role("dialog").get_by_role("button", name="Compare", exact=True)).to_be_disabled()
    while not held:
        page.wait_for_timeout(20)
    held[0].continue_()
    expect(groups.first).to_have_attribute("label", "Runs of second.mp4")
    assert "other" in choice.locator("option").first.inner_text()
    assert "first.mp4" not in (choice.inner_html())


def test_ground_truth_that_the_dialog_lacks_is_imported_on_the_way(review: ReviewSession, page: Page) -> None:
    page.get_by_role("button", name="Compare", exact=True).click()
    dialog, reference, candidate = page.get_by_role("dialog"), page.locator("#compare-a"), page.locator("#compare-b")
    run = candidate.locator("option", has_text="worse").first.evaluate("option => option.value")
    candidate.select_option(run)

    def bring(name: str, content: bytes) -> None:
        dialog.get_by_role("button", name="Import ground truth").click()
        expect(dialog.get_by_role("heading", name="Import for first.mp4")).to_be_visible()
        expect(dialog.get_by_role("radio", name="Ground truth")).to_be_checked()
        page.locator("#import-file").set_input_files({"name": name, "mimeType": "", "buffer": content})
        dialog.get_by_role("button", name="Import", exact=True).click()

    bring("by hand.csv", SHIPPED[0].truth.read_bytes())
    expect(reference.locator("option:checked")).to_contain_text("by hand")
    expect(candidate).to_have_value(run)
    # whoever closes the import is back with the sides as they were
    chosen = reference.input_value()
    dialog.get_by_role("button", name="Import ground truth").click()
    dialog.locator("#import-name").wait_for()
    page.keyboard.press("Escape")
    expect(reference).to_have_value(chosen)
    # what was repaired or skipped is read first
    bring("theirs.zip", mot_archive(3, 5))
    dialog.get_by_role("button", name="Back to the comparison").click()
    expect(reference.locator("option:checked")).to_contain_text("theirs")
    dialog.get_by_role("button", name="Compare", exact=True).click()
    page.locator(".figures-table tbody tr").first.wait_for()
    assert page.evaluate("location.hash").endswith(f"b={run.replace(':', '%3A')}")
