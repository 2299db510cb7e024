"""A library of many videos: run several at once, reorder waiting runs, show rows instead of cards."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import BrowserContext, Page, expect

from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Video
from sample_videos import SHIPPED
from tests.e2e.forked_server import ForkedServer
from tests.e2e.live_server import LiveServer
from tests.e2e.review_session import fresh_page, without_errors

NAMES = ("a.mp4", "b.mp4", "c.mp4", "d.mp4")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    """Four imported videos without a worker for runs."""
    home = tmp_path_factory.mktemp("home")
    database = Database(Settings(home=home).database)
    database.migrate()
    with database.write() as session:
        for name in NAMES:
            session.add(
                Video(
                    id=hashlib.sha256(name.encode()).hexdigest(),
                    name=name,
                    path=str(SHIPPED[0].video),
                    size=1,
                    state="ready",
                    frames=300,
                    warnings=[],
                )
            )
    database.close()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TSR_WORKERS", "0")
        with ForkedServer(home, sample=False) as running:
            yield running


@pytest.fixture
def page(server: LiveServer, window: BrowserContext) -> Iterator[Page]:
    with without_errors(fresh_page(window, server)) as page:
        page.goto(server.link())
        expect(page.get_by_role("heading", name="a.mp4")).to_be_visible()
        yield page


def waiting(server: LiveServer) -> list[str]:
    names = {one["id"]: one["name"] for one in server.call("GET", "/videos")["videos"]}
    return [names[run["video_id"]] for run in server.call("GET", "/run-queue")["runs"]]


def test_chosen_videos_are_run_with_the_parameters_of_the_last_run(server: LiveServer, page: Page) -> None:
    expect(page.locator(".welcome")).to_be_hidden()
    page.get_by_label("Order of the videos").select_option("name")
    page.get_by_role("checkbox", name="Choose a.mp4").focus()
    page.keyboard.press("Space")
    page.get_by_role("checkbox", name="Choose c.mp4").click(modifiers=["Shift"])
    expect(page.get_by_text("3 videos chosen")).to_be_visible()
    page.get_by_role("button", name="Run the engine on 3").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_text("Parameters", exact=True).click()
    dialog.get_by_label("Search parameters").fill("tau")
    dialog.get_by_label("tau", exact=True).fill("25")
    dialog.get_by_role("button", name="Start the runs").click()
    expect(page.get_by_text("3 runs are started.")).to_be_visible()
    expect(page.locator(".library-chosen")).to_be_hidden()
    assert waiting(server) == ["a.mp4", "b.mp4", "c.mp4"]
    assert [run["parameters"] for run in server.call("GET", "/run-queue")["runs"]] == [{"tau": 25}] * 3
    # the next run begins with the same parameters, and says so
    page.get_by_role("button", name="Run the engine on d.mp4").click()
    expect(dialog.get_by_text("Parameters: 1 change")).to_be_visible()
    dialog.get_by_text("Parameters: 1 change").click()
    expect(dialog.get_by_label("tau", exact=True)).to_have_value("25")
    dialog.get_by_role("button", name="Use the preset alone").click()
    expect(dialog.get_by_text("Parameters", exact=True)).to_be_visible()
    dialog.get_by_role("button", name="Start the run").click()
    expect(page.get_by_text("The run was started.")).to_be_visible()
    run = server.call("GET", "/run-queue")["runs"][3]
    assert run["parameters"] == {}
    # the dialog gives way to the notice, whose button opens the run
    expect(dialog).to_be_hidden()
    page.locator(".toast").get_by_role("button", name="Open").click()
    page.wait_for_function("run => location.hash.includes(run)", arg=run["id"])


def test_runs_that_wait_are_put_in_order_by_keyboard_and_by_drag(server: LiveServer, page: Page) -> None:
    for name in NAMES[len(waiting(server)) :]:  # none if the previous test has started a run of each
        server.call("POST", f"/videos/{hashlib.sha256(name.encode()).hexdigest()}/runs", {})
    page.get_by_role("button", name="Run queue").click()
    rows = page.get_by_role("dialog").locator(".line-run")
    expect(rows.locator(".line-name")).to_have_text(["a.mp4", "b.mp4", "c.mp4", "d.mp4"])
    page.get_by_role("button", name="c.mp4: earlier").focus()
    page.keyboard.press("Alt+ArrowUp")
    expect(rows.locator(".line-name")).to_have_text(["a.mp4", "c.mp4", "b.mp4", "d.mp4"])
    page.keyboard.press("Enter")
    expect(rows.locator(".line-name")).to_have_text(["c.mp4", "a.mp4", "b.mp4", "d.mp4"])
    expect(page.get_by_role("button", name="c.mp4: earlier")).to_be_focused()
    rows.nth(3).drag_to(rows.nth(1), target_position={"x": 60, "y": 3})
    expect(rows.locator(".line-name")).to_have_text(["c.mp4", "d.mp4", "a.mp4", "b.mp4"])
    rows.nth(0).drag_to(rows.nth(3), target_position={"x": 60, "y": 36})
    expect(rows.locator(".line-name")).to_have_text(["d.mp4", "a.mp4", "b.mp4", "c.mp4"])
    assert waiting(server) == ["d.mp4", "a.mp4", "b.mp4", "c.mp4"]
    page.get_by_role("button", name="Cancel the run of a.mp4").click()
    expect(rows.locator(".line-name")).to_have_text(["d.mp4", "b.mp4", "c.mp4"])


def test_rows_stand_for_cards_and_are_remembered(page: Page) -> None:
    cards = page.locator(".card")
    wide = cards.first.bounding_box()
    page.get_by_role("button", name="Show rows").click()
    row = cards.first.bounding_box()
    assert wide is not None
    assert row is not None
    assert row["width"] > 2 * wide["width"]
    assert row["height"] < wide["height"] / 2
    page.reload()
    expect(page.get_by_role("button", name="Show cards")).to_be_visible()
    expect(page.locator(".cards-rows .card")).to_have_count(len(NAMES))
