"""Retraining by mouse in a real browser on a real server with workers: export, retrain, use, run again, compare, roll
back. A toy drive of small pictures and the fastest part keep it short.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Browser, Page, expect

from app.edits.documents import Segment, TrackDoc
from app.storage.models import TrackDocument
from tests.app.toy_home import ToyHome, make_home
from tests.e2e.forked_server import ForkedServer
from tests.e2e.review_session import go_back, without_errors

pytestmark = pytest.mark.timeout(900)
MAX_WORK_MS = 300_000
"""Patience with work of the server, ms: the machine may be busy."""
LIMIT_50 = 2


def accept_all(home: ToyHome) -> None:
    """Label the engine's tracks as limits of 50 and accept them."""
    with home.reader() as reader, home.database.write() as session:
        for track in reader.tracks():
            if track.confirmed:
                piece = Segment(track=track.track_id, first=track.first_frame, last=track.last_frame)
                document = TrackDoc(
                    key=f"m{track.track_id}", revision=1, class_id=LIMIT_50, review="accepted", segments=(piece,)
                )
                content = document.model_dump(mode="json")
                session.add(TrackDocument(run_id=home.run_id, key=document.key, revision=1, document=content))


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> ToyHome:
    home = make_home(tmp_path_factory.mktemp("retraining"))
    accept_all(home)
    home.evidence.close()
    home.database.close()
    return home


@pytest.fixture
def page(home: ToyHome, browser: Browser) -> Iterator[Page]:
    roots = (home.video.parent,)
    with (
        ForkedServer(home.settings.home, roots, sample=False) as server,
        without_errors(browser.new_page(viewport={"width": 1280, "height": 720})) as page,
    ):
        page.goto(f"{server.link()}#/review/{home.video_id}/{home.run_id}")
        expect(page.locator(".picture-stage")).to_have_attribute("data-shown", "0", timeout=MAX_WORK_MS)
        yield page


def test_the_loop_by_clicks(page: Page) -> None:
    dialog = page.get_by_role("dialog")
    page.get_by_role("button", name="Export annotations").click()
    dialog.get_by_label("Format", exact=True).select_option("cvat-video")
    dialog.get_by_label("File name").fill("corrections")
    dialog.get_by_role("button", name="Export", exact=True).click()
    expect(dialog.get_by_role("link", name="Download")).to_be_visible(timeout=MAX_WORK_MS)
    dialog.get_by_role("button", name="Close", exact=True).last.click()
    expect(dialog).to_be_hidden()

    page.get_by_role("link", name="Models").click()
    page.get_by_role("button", name="Retrain").click()
    # the current review is the default training data; files are offered
    expect(dialog.get_by_role("list", name="Reviews to learn from")).to_contain_text("2 accepted")
    expect(dialog.get_by_role("checkbox", name="drive.mp4")).to_be_checked()
    dialog.get_by_text("Exported files").click()
    expect(dialog.get_by_label("corrections.zip")).not_to_be_checked()
    for part in ("Detector", "Spatial prior", "Weight of the prior", "Classifier"):
        dialog.locator(".kinds label").filter(has_text=part).first.get_by_role("checkbox").uncheck()
    dialog.get_by_label("Name", exact=True).fill("Mine")
    dialog.get_by_role("button", name="Retrain").click()
    mine = page.get_by_role("listitem", name="Mine")
    expect(page.get_by_text("Mine is being made.")).to_be_visible()
    expect(mine.get_by_text("ready")).to_be_visible(timeout=MAX_WORK_MS)
    expect(mine.locator(".origin")).to_contain_text("Reviewsdrive.mp4")
    expect(mine.locator(".origin")).to_contain_text("Start of the online detector")
    expect(mine.locator(".origin")).to_contain_text("a trial version trained without")
    expect(mine.get_by_text("in use")).to_be_hidden()

    mine.get_by_role("button", name="Promote Mine").click()
    dialog.get_by_role("button", name="Promote", exact=True).click()
    expect(mine.get_by_text("in use")).to_be_visible(timeout=MAX_WORK_MS)

    go_back(page)
    page.get_by_role("button", name="Runs").click()
    expect(dialog.locator(".run-models")).to_contain_text("Mine")
    dialog.get_by_label("Name", exact=True).fill("Second")
    dialog.get_by_label("Last frame").fill("30")
    dialog.get_by_role("button", name="Start the run").click()
    expect(dialog).to_be_hidden()
    page.get_by_role("button", name="Runs").click()
    second = dialog.locator(".run-item").filter(has_text="Second")
    expect(second.locator(".run-badge")).to_have_text("complete", timeout=MAX_WORK_MS, ignore_case=True)
    expect(second.locator(".run-changes")).to_contain_text("Models: Mine")
    expect(page.locator("select option").filter(has_text="Second")).to_contain_text("· Mine")
    dialog.get_by_role("button", name="Close", exact=True).last.click()
    expect(dialog).to_be_hidden()

    page.get_by_role("button", name="Compare").click()
    expect(dialog.locator("#compare-a option").filter(has_text="Corrections of Run 1")).to_have_count(1)  # they load
    names = dialog.locator("#compare-a option").all_inner_texts()
    dialog.locator("#compare-a").select_option(label=next(name for name in names if "Corrections of Run 1" in name))
    dialog.locator("#compare-b").select_option(label=next(name for name in names if name.startswith("Second")))
    dialog.get_by_role("button", name="Compare").click()
    expect(page.get_by_role("heading", name="Compare", exact=True)).to_be_visible(timeout=MAX_WORK_MS)
    expect(page.get_by_text("Recall").first).to_be_visible(timeout=MAX_WORK_MS)
    expect(page.get_by_role("region", name="Candidate")).to_contain_text("Models: Mine")

    page.get_by_role("link", name="Models").click()
    page.get_by_role("button", name="Roll back").click()
    expect(page.get_by_role("listitem", name="Shipped").get_by_text("in use")).to_be_visible(timeout=MAX_WORK_MS)
    expect(mine.get_by_text("in use")).to_be_hidden()
