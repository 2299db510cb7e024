"""Several files at once into the library: each has its own progress, end and error."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import BrowserContext, Page, Route, expect

from sample_videos import SHIPPED
from tests.e2e.forked_server import ForkedServer
from tests.e2e.interception import intercept
from tests.e2e.live_server import LiveServer
from tests.e2e.review_session import fresh_page

UPLOADS = re.compile(r"/api/uploads/")
DROP = """files => {
  const carried = new DataTransfer();
  for (const {name, text} of files) carried.items.add(new File([text], name));
  for (const kind of ['dragenter', 'dragover', 'drop']) {
    const event = new DragEvent(kind, {dataTransfer: carried, bubbles: true, cancelable: true});
    document.querySelector('.library').dispatchEvent(event);
  }
}"""


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveServer]:
    with ForkedServer(tmp_path_factory.mktemp("files"), sample=False) as running:
        yield running


@pytest.fixture
def page(server: LiveServer, window: BrowserContext) -> Page:
    page = fresh_page(window, server)
    page.goto(server.link())
    page.wait_for_function("() => globalThis.tsr?.store.get().videos !== null")
    return page


class UploadGate:
    """Uploads wait here until the test releases them."""

    def __init__(self, page: Page) -> None:
        self.held: list[Route] = []
        self._open = False
        intercept(page, UPLOADS, lambda route: self._come(route))

    def _come(self, route: Route) -> None:
        if self._open:
            route.continue_()
        else:
            self.held.append(route)

    def let_go(self) -> None:
        """Release present and future uploads."""
        self._open = True
        for route in self.held:
            route.continue_()


def wait_for_progress(page: Page, name: str) -> None:
    """Each file has a row with a progress of its own."""
    expect(page.get_by_role("progressbar", name=f"Upload of {name}")).to_have_count(1)


def test_the_input_takes_several_and_a_bad_one_does_not_stop_the_others(page: Page, tmp_path: Path) -> None:
    chosen = []
    for at, shipped in enumerate(SHIPPED[:2]):
        clip = tmp_path / f"drive {at}.mp4"
        clip.write_bytes(shipped.video.read_bytes() + b"\0" * (16 + at))
        chosen.append(clip)
    wrong = tmp_path / "broken.mp4"
    wrong.write_text("this is no video")
    gate = UploadGate(page)
    page.get_by_label("Video files to upload").set_input_files([chosen[0], wrong, chosen[1]])
    for name in ("drive 0.mp4", "broken.mp4", "drive 1.mp4"):
        wait_for_progress(page, name)
    while not gate.held:
        page.wait_for_timeout(20)
    page.wait_for_timeout(300)
    assert len(gate.held) == 1, "one after the other"
    gate.let_go()
    for name in ("drive 0.mp4", "drive 1.mp4"):
        expect(page.get_by_role("heading", name=name)).to_be_visible()
        expect(page.get_by_role("progressbar", name=f"Upload of {name}")).to_have_count(0)
    said = page.locator(".upload-failed, .card", has_text="broken.mp4").first
    expect(said.locator(".upload-words, .card-message-bad").first).to_be_visible()
    assert len(said.locator(".upload-words, .card-message-bad").first.inner_text()) > 20


def test_dropped_files_have_a_row_each_and_one_that_waits_can_be_taken_back(page: Page) -> None:
    gate = UploadGate(page)
    page.evaluate(DROP, [{"name": f"part {at}.mp4", "text": f"no video {at}"} for at in range(3)])
    for at in range(3):
        wait_for_progress(page, f"part {at}.mp4")
    waits = page.locator(".upload", has_text="part 1.mp4")
    expect(waits).to_contain_text("Waits")
    waits.get_by_role("button", name="Cancel").click()
    expect(waits).to_have_count(0)
    gate.let_go()
    for at in (0, 2):
        expect(
            page.locator(".upload-failed, .card-message-bad", has_text=re.compile(".{20,}")).nth(at // 2)
        ).to_be_visible()
    sent = page.evaluate("() => performance.getEntriesByType('resource').map(({name}) => name)")
    assert not any("part%201" in address for address in sent), "what was taken back is never sent"


def test_an_upload_goes_on_while_another_screen_is_open(page: Page) -> None:
    gate = UploadGate(page)
    page.evaluate(
        DROP, [{"name": f"away {at}.mp4", "text": f"no video, sent from another screen {at}"} for at in (0, 1)]
    )
    wait_for_progress(page, "away 1.mp4")
    page.evaluate("() => { location.hash = '#/files'; }")
    expect(page.get_by_role("heading", name="Files", exact=True)).to_be_visible()
    gate.let_go()
    for at in (0, 1):
        expect(page.locator(".toast", has_text=f"away {at}.mp4 is")).to_be_visible()
    page.evaluate("() => { location.hash = '#/'; }")
    for at in (0, 1):
        expect(page.locator(".upload-failed, .card", has_text=f"away {at}.mp4")).to_be_visible()
