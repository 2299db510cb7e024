"""Exports, imports, files, model versions and views beside the picture, in a real browser on a real server.

The run is an import of the sample's exact ground truth, so that no test waits for the engine.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as ET

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import BrowserContext, Page, expect

from sample_videos import SHIPPED
from tests.attack.many_tracks import mot_archive
from tests.e2e.live_server import LiveServer
from tests.e2e.review_session import (
    fresh_page,
    import_tracks,
    open_address,
    serve_video,
    wait_until_no_dialog,
    without_errors,
)
from tests.e2e.screenshots import AXE_SCRIPT, serious_violations

MAX_WORK_MS = 90_000
"""The longest wait for work of the server, ms: the machine may be busy."""
NAME = SHIPPED[1].video.name


class ImportedRun(NamedTuple):
    """A server with one video and one run."""

    server: LiveServer
    video: str
    run: str
    tracks: int
    boxes: int


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ImportedRun]:
    with serve_video(tmp_path_factory, SHIPPED[1].video, NAME) as (server, _, video):
        found = import_tracks(server, video, SHIPPED[1].truth.read_bytes(), "tracker")
        yield ImportedRun(server, video, found["id"], found["tracks"], found["boxes"])


@pytest.fixture
def page(review: ImportedRun, window: BrowserContext) -> Iterator[Page]:
    with without_errors(fresh_page(window, review.server)) as page:
        page.goto(review.server.link())
        page.wait_for_function(
            "() => globalThis.tsr?.store.get().videos?.length && tsr.store.get().session", timeout=60_000
        )
        yield page


def _review(page: Page, review: ImportedRun) -> None:
    open_address(page, f"#/review/{review.video}/{review.run}?frame=100")
    page.wait_for_function(
        "() => tsr.store.get().review?.shown === 100 && tsr.store.get().review.tracks", timeout=60_000
    )


def _accessible(page: Page) -> None:
    if AXE_SCRIPT.is_file():
        assert serious_violations(page) == []


def _choose(page: Page, name: str, content: bytes) -> None:
    chosen = {"name": name, "mimeType": "application/octet-stream", "buffer": content}
    page.locator("#import-file").set_input_files(chosen)  # type: ignore[arg-type]


def test_an_export_is_listed_and_can_be_downloaded(page: Page, review: ImportedRun) -> None:
    _review(page, review)
    page.get_by_role("button", name="Export annotations").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Format", exact=True).select_option("cvat-video")
    expect(dialog.locator("#export-format + p, .run-column p").filter(has_text="CVAT").first).to_be_visible()
    # without verdicts and edits, open tracks are exported only on request
    dialog.get_by_label("Edited", exact=True).uncheck()
    expect(dialog.locator(".export-count")).to_contain_text("Nothing would be exported", timeout=30_000)
    expect(dialog.locator(".export-count")).to_contain_text("left out")
    dialog.get_by_label("Open", exact=True).check()
    expect(dialog.locator(".export-count")).to_contain_text(f"{review.tracks} tracks")
    _accessible(page)
    dialog.get_by_label("Last frame").fill("5000")
    expect(dialog.get_by_role("alert")).to_contain_text("from 0 to 299")
    dialog.get_by_label("Last frame").fill("")
    dialog.get_by_label("File name").fill("my <b>export")
    dialog.get_by_role("button", name="Export", exact=True).click()
    with page.expect_download(timeout=MAX_WORK_MS) as download:
        dialog.get_by_role("link", name="Download my <b>export").click(timeout=MAX_WORK_MS)
    assert download.value.suggested_filename.endswith(".zip")
    expect(dialog).to_contain_text("It is listed under Files.")
    with zipfile.ZipFile(io.BytesIO(Path(download.value.path()).read_bytes())) as archive:
        manifest = json.loads(archive.read("manifest.json"))
        xml = ET.fromstring(archive.read(next(n for n in archive.namelist() if n.endswith(".xml"))))
    assert manifest["counts"]["boxes"] == review.boxes
    assert len(xml.findall("track")) == review.tracks
    dialog.get_by_role("button", name="Close").last.click()
    expect(dialog).to_be_hidden()  # it leads to the files too, until the page is drawn without it
    page.get_by_role("link", name="Files").click()
    row = page.get_by_role("listitem").filter(has_text="my <b>export")
    expect(row).to_contain_text("ready")
    expect(row).to_contain_text(NAME)
    _accessible(page)
    row.get_by_role("button", name="Delete").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(page.get_by_role("listitem").filter(has_text="my <b>export")).to_have_count(0)


def test_an_impossible_split_shows_the_reason_and_the_choice_is_remembered(page: Page, review: ImportedRun) -> None:
    page.get_by_role("button", name="Export", exact=True).click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Format", exact=True).select_option("coco")
    dialog.get_by_label("Split into").check()
    expect(dialog.get_by_text("leakage check")).to_be_visible()
    dialog.get_by_label("Validation", exact=True).fill("30")
    dialog.get_by_role("button", name="Export", exact=True).click()
    # all signs of this drive share frames, so none can be kept apart
    expect(dialog.locator(".made")).to_contain_text("must stay whole", timeout=MAX_WORK_MS)
    page.keyboard.press("Escape")
    page.reload()
    page.get_by_role("button", name="Export", exact=True).click(timeout=60_000)
    dialog = page.get_by_role("dialog")
    expect(dialog.get_by_label("Format", exact=True)).to_have_value("coco")
    expect(dialog.get_by_label("Validation", exact=True)).to_have_value("30")


def test_what_a_format_allows_of_pictures_leaves_the_choice_of_the_others(page: Page, review: ImportedRun) -> None:
    _review(page, review)
    page.get_by_role("button", name="Export annotations").click()
    dialog = page.get_by_role("dialog")
    formats, none = dialog.get_by_label("Format", exact=True), dialog.get_by_label("None", exact=True)
    formats.select_option("cvat-video")
    none.check()
    formats.select_option("gtsrb")
    expect(none).to_be_disabled()
    expect(dialog.get_by_label("Annotated frames")).to_be_checked()
    formats.select_option("label-studio")
    expect(none).to_be_checked()
    # and so does one without pictures
    formats.select_option("coco")
    dialog.get_by_label("All frames").check()
    formats.select_option("tracks-csv")
    expect(none).to_be_checked()
    expect(dialog.get_by_label("All frames")).to_be_disabled()
    formats.select_option("coco")
    expect(dialog.get_by_label("All frames")).to_be_checked()


def test_ground_truth_imported_from_the_library_is_shown(page: Page, review: ImportedRun) -> None:
    page.get_by_role("link", name="Library").click()
    name = SHIPPED[1].video.name
    page.get_by_role("button", name=f"Import annotations for {name}").click()
    dialog = page.get_by_role("dialog")
    dialog.locator("[name=import-as][value=truth]").check()
    _choose(page, "seen.csv", SHIPPED[1].truth.read_bytes())
    dialog.get_by_role("button", name="Import", exact=True).click()
    dialog.get_by_role("button", name="Show the ground truth").click(timeout=MAX_WORK_MS)
    page.wait_for_function(
        "() => tsr.store.get().review?.layers.truth && (tsr.store.get().review.truth[0] ?? null) !== null",
        timeout=30_000,
    )
    for truth in review.server.call("GET", f"/videos/{review.video}/ground-truths")["ground_truths"]:
        review.server.call("DELETE", f"/ground-truths/{truth['id']}")


def test_an_import_shows_its_progress_and_can_be_cancelled(page: Page, review: ImportedRun) -> None:
    page.get_by_role("link", name="Library").click()
    page.get_by_role("button", name=f"Import annotations for {NAME}").click()
    dialog = page.get_by_role("dialog")
    dialog.locator("[name=import-as][value=truth]").check()
    _choose(page, "many.zip", mot_archive(6_000, 50))
    dialog.get_by_role("button", name="Import", exact=True).click()
    status = dialog.get_by_role("status").filter(has_text="boxes …")
    expect(status).to_be_visible(timeout=MAX_WORK_MS)
    dialog.get_by_role("button", name="Cancel import").click()
    expect(dialog.get_by_role("alert").filter(has_text="Nothing was imported")).to_be_visible(timeout=MAX_WORK_MS)
    expect(dialog.get_by_role("button", name="Cancel import")).to_be_hidden()
    assert review.server.call("GET", f"/videos/{review.video}/ground-truths")["ground_truths"] == []
    expect(dialog.get_by_role("button", name="Import", exact=True)).to_be_enabled()


def test_a_file_is_imported_as_ground_truth_and_its_layer_is_shown(page: Page, review: ImportedRun) -> None:
    _review(page, review)
    page.get_by_role("button", name="Import annotations").click()
    dialog = page.get_by_role("dialog")
    dialog.locator("[name=import-as][value=truth]").check()
    _choose(page, "exact.csv", SHIPPED[1].truth.read_bytes())
    expect(dialog.get_by_label("Name", exact=True)).to_have_value("exact")
    _accessible(page)
    dialog.get_by_role("button", name="Import", exact=True).click()
    expect(dialog.get_by_text(f"Imported: {review.tracks} tracks")).to_be_visible(timeout=MAX_WORK_MS)
    dialog.get_by_role("button", name="Show the ground truth").click()
    page.wait_for_function(
        "() => tsr.store.get().review.layers.truth && (tsr.store.get().review.truth[100]?.length ?? 0) > 0",
        timeout=30_000,
    )
    truth = review.server.call("GET", f"/videos/{review.video}/ground-truths")["ground_truths"][0]["id"]
    wait_until_no_dialog(page)
    page.keyboard.press("7")
    page.wait_for_function("() => !tsr.store.get().review.layers.truth")
    # a place of a comparison shows it with any layers
    open_address(page, f"#/compare?a=truth:{truth}&b=run:{review.run}")
    page.locator(".matrix button").first.click()  # both agree, because this run is exact
    page.locator(".place").first.click()
    page.wait_for_function("() => tsr.store.get().review?.layers.truth", timeout=30_000)
    expect(page.locator(".place").first).to_be_hidden()
    _review(page, review)
    page.wait_for_function("() => (tsr.store.get().review.truth[100]?.length ?? 0) > 0", timeout=30_000)
    page.get_by_role("button", name="Ground truths").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete exact").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete", exact=True).click()
    page.wait_for_function("() => !(tsr.store.get().review.truth[100]?.length)", timeout=30_000)


def test_a_file_is_imported_as_a_run_and_opens(page: Page, review: ImportedRun) -> None:
    _review(page, review)
    page.keyboard.press("Shift+I")
    dialog = page.get_by_role("dialog")
    dialog.locator("[name=import-as][value=run]").check()
    _choose(page, "theirs.csv", SHIPPED[1].truth.read_bytes())
    dialog.get_by_role("button", name="Import", exact=True).click()
    expect(dialog.get_by_role("heading", name="Skipped")).to_be_visible(timeout=MAX_WORK_MS)
    dialog.get_by_role("button", name="Show the run").click()
    page.wait_for_function(
        "old => tsr.store.get().review?.run && tsr.store.get().review.run.id !== old", arg=review.run, timeout=30_000
    )
    assert page.evaluate("tsr.store.get().review.run.name") == "theirs"
    expect(page.get_by_role("button", name="Report a bug")).to_have_attribute("aria-disabled", "true")
    # somebody removes it: the page says so, also after a reload, and shows no other run in its place
    review.server.call("DELETE", f"/runs/{page.evaluate('tsr.store.get().review.run.id')}")
    gone = page.get_by_role("heading", name="This run no longer exists")
    expect(gone).to_be_visible()
    expect(page.get_by_label("Run", exact=True)).to_contain_text("no longer exists")
    page.reload()
    expect(gone).to_be_visible()
    assert page.evaluate("tsr.store.get().review.run") is None
    page.get_by_role("link", name="Open the newest run").click()
    page.wait_for_function("run => tsr.store.get().review?.run?.id === run", arg=review.run, timeout=30_000)
    expect(gone).to_be_hidden()


def test_a_broken_file_is_refused_with_file_line_and_rule(page: Page, review: ImportedRun) -> None:
    _review(page, review)
    page.get_by_role("button", name="Import annotations").click()
    dialog = page.get_by_role("dialog")
    dialog.locator("[name=import-as][value=truth]").check()
    lines = SHIPPED[1].truth.read_text().splitlines()
    lines[3] = lines[3].replace(lines[3].split(",")[2], "nan", 1)
    _choose(page, "broken.csv", "\n".join(lines).encode())
    dialog.get_by_role("button", name="Import", exact=True).click()
    refused = dialog.locator(".import-refused")
    expect(refused).to_contain_text("broken.csv, line 4", timeout=MAX_WORK_MS)
    expect(refused).to_contain_text("Nothing was imported")
    _choose(page, "unknown.bin", b"\x00\x01\x02")
    dialog.get_by_role("button", name="Import", exact=True).click()
    expect(refused).to_contain_text("unknown.bin", timeout=MAX_WORK_MS)
    # what a refusal advises can be set in the dialog
    picture = {"file_name": "1.jpg", "width": 99, "height": 99, "id": 1}
    sign = {"id": 1, "image_id": 1, "category_id": 1, "bbox": [1, 1, 20, 20]}
    coco = {"images": [picture], "annotations": [sign], "categories": [{"id": 1, "name": "stop"}]}
    _choose(page, "small.json", json.dumps(coco).encode())
    dialog.get_by_role("button", name="Import", exact=True).click()
    expect(refused).to_contain_text("first_frame=0", timeout=MAX_WORK_MS)
    expect(refused).to_contain_text("To set “First frame”, choose the format of the file above.")


def test_the_video_of_a_table_about_several_is_named(page: Page, review: ImportedRun) -> None:
    _review(page, review)
    page.get_by_role("button", name="Import annotations").click()
    dialog = page.get_by_role("dialog")
    dialog.locator("[name=import-as][value=truth]").check()
    rows = "".join(f"{name},{frame},1,10,10,50,50,stop\n" for name in ("left.mp4", "right.mp4") for frame in (0, 1))
    _choose(page, "several.csv", f"video,frame,track_id,x1,y1,x2,y2,class\n{rows}".encode())
    dialog.get_by_label("Format", exact=True).select_option("tracks-csv")
    task = dialog.get_by_label("Task", exact=True)
    expect(task).to_have_value("auto")
    _accessible(page)
    dialog.get_by_role("button", name="Import", exact=True).click()
    expect(dialog.locator(".import-refused")).to_contain_text("left.mp4, right.mp4", timeout=MAX_WORK_MS)
    task.fill("left.mp4")
    dialog.get_by_role("button", name="Import", exact=True).click()
    expect(dialog.locator(".import-done")).to_contain_text("1 track with 2 boxes", timeout=MAX_WORK_MS)
    expect(dialog).to_contain_text("names left.mp4")


def test_models_show_what_is_in_use_and_retraining_asks_for_corrections(page: Page, review: ImportedRun) -> None:
    page.get_by_role("link", name="Models").click()
    shipped = page.get_by_role("listitem").filter(has_text="Shipped")
    expect(shipped).to_contain_text("in use", timeout=30_000)
    expect(shipped).to_contain_text("Average precision")
    _accessible(page)
    page.get_by_role("button", name="Retrain", exact=True).click()
    dialog = page.get_by_role("dialog")
    reviews = dialog.get_by_role("list", name="Reviews to learn from").get_by_role("checkbox")
    expect(reviews.first).to_be_checked()  # those with corrections are
    for one in reviews.all():
        one.uncheck()
    expect(dialog.get_by_role("button", name="Retrain", exact=True)).to_be_disabled()
    expect(dialog.get_by_role("alert")).to_contain_text("Select a review or an export")
    _accessible(page)


def test_a_recording_is_made_listed_and_shown_beside_the_picture(page: Page, review: ImportedRun) -> None:
    _review(page, review)
    page.get_by_role("button", name="Record frames").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("First frame").fill("90")
    dialog.get_by_label("Last frame").fill("120")
    expect(dialog).to_contain_text("31 frames")
    dialog.get_by_role("button", name="Record", exact=True).click()
    beside = page.get_by_role("region", name="Recording")
    expect(beside).to_be_visible()
    page.wait_for_function(
        "() => tsr.store.get().outputs?.some(one => one.kind === 'recording' && one.state === 'complete')",
        timeout=MAX_WORK_MS,
    )
    beside.get_by_role("button", name="Close this view").click()
    expect(beside).to_have_count(0)
    page.get_by_role("link", name="Files").click()
    row = page.get_by_role("listitem").filter(has_text="Recording")
    expect(row).to_contain_text("frames 90 to 120")


def test_the_author_of_corrections_can_be_changed(page: Page, review: ImportedRun) -> None:
    _review(page, review)
    page.get_by_role("button", name="Preferences").click()
    page.get_by_label("Your name").fill("Ada <b>L")
    page.keyboard.press("Enter")
    wait_until_no_dialog(page)
    track = review.server.call("GET", f"/runs/{review.run}/tracks")["id"][0]
    open_address(page, f"#/review/{review.video}/{review.run}?frame=100&track=m{track}")
    page.wait_for_function("key => tsr.store.get().review.selected === key", arg=f"m{track}")
    page.locator("[data-operation=accept]").click()
    page.wait_for_function(
        "key => tsr.store.get().review.docs[key]?.review === 'accepted' && !tsr.store.get().review.unsaved.length",
        arg=f"m{track}",
        timeout=30_000,
    )
    annotation = review.server.call("GET", f"/runs/{review.run}/annotation?author=Ada%20%3Cb%3EL")
    assert annotation["undo"] is not None
