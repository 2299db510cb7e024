"""A recording in the served viewer: it opens at the right frame, both sides follow each other, and nothing leaves the
server.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page

from app.recordings.viewer import ViewerFiles
from tests.app.toy_home import ToyHome, make_home
from tests.e2e.browsers import open_browser
from tests.e2e.forked_server import ForkedServer
from tests.e2e.live_server import LiveServer
from tests.e2e.screenshot_views import GRAPHICS
from tests.e2e.screenshots import FLAGS

pytestmark = pytest.mark.timeout(900)
MAX_WAIT_S = 120
"""How long a step may take, s: without a graphics card, a viewer on a busy machine shows a picture in seconds."""
# The view over the whole window, and all messages of the viewer's frame.
MOUNT = """async () => {
  globalThis.heard = [];
  addEventListener('message', ({data}) => heard.push(data));
  const {createRecordingView} = await import('/static/js/views/recording/index.js');
  const {signal} = new AbortController();
  const view = globalThis.view = createRecordingView({store: tsr.store, api: {base: '/api'}, signal});
  view.element.style.cssText = 'position: fixed; inset: 0; z-index: 1000; background: var(--surface-1, #fff)';
  document.body.append(view.element);
  view.update(tsr.store.get());
  tsr.store.subscribe(() => view.update(tsr.store.get()));
}"""
# The page's requests to the viewer, once it has carried them out.
COUNT = """() => {
  globalThis.controlled = 0;
  const {prototype} = wasm_bindgen.WebHandle, control = prototype.viewer_control;
  prototype.viewer_control = async function (...asked) {
    const answer = await control.apply(this, asked);
    globalThis.controlled++;
    return answer;
  };
}"""
ACT = "async ([name, value]) => tsr.store.dispatch((await import('/static/js/store/actions/review.js'))[name], value)"


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> ToyHome:
    home = make_home(tmp_path_factory.mktemp("toy"))
    viewer = ViewerFiles(tmp_path_factory.getbasetemp() / "rerun-viewer")  # tests/app/recordings shares this copy
    viewer.ensure()
    shutil.copytree(viewer.folder, home.settings.home / "cache" / viewer.folder.name)
    home.evidence.close()
    home.database.close()
    return home


@pytest.fixture(scope="module")
def server(home: ToyHome) -> Iterator[LiveServer]:
    with ForkedServer(home.settings.home, roots=(home.video.parent,), sample=False) as running:
        yield running


@pytest.fixture
def page(server: LiveServer, home: ToyHome) -> Iterator[Page]:
    with open_browser([*FLAGS, *GRAPHICS]) as browser:
        shown = browser.new_page(viewport={"width": 320, "height": 240})
        shown.goto(server.link())
        shown.goto(f"{server.base}/#/review/{home.video_id}/{home.run_id}?frame=20")
        wait_for(shown, "() => tsr.store.get().review?.run?.frames_done === 75 && tsr.store.get().review.timebase")
        yield shown


def wait_for(page: Page, question: str, seconds: float = MAX_WAIT_S) -> Any:
    """The answer to a query, as soon as there is one; the page's policy forbids Playwright's own function."""
    deadline = time.monotonic() + seconds
    while not (answer := page.evaluate(question)):
        assert time.monotonic() < deadline, (
            f"not within {seconds} s: {question}; heard {page.evaluate('globalThis.heard')}"
        )
        page.wait_for_timeout(100)
    return answer


def messages_of(page: Page, kind: str) -> list[dict[str, Any]]:
    return [message for message in page.evaluate("heard") if message.get("type") == kind]


def press(page: Page, key: str) -> None:
    """Press a key in the viewer, with the pointer over it."""
    page.locator(".recording-stage").hover()
    page.frame_locator(".recording-stage").locator("#viewer").press(key, timeout=MAX_WAIT_S * 1000)


def test_a_recording_opens_at_the_frame_and_both_sides_follow_each_other(page: Page, server: LiveServer) -> None:
    if not page.evaluate("() => document.createElement('canvas').getContext('webgl2') !== null"):
        pytest.skip("this browser has no WebGL 2, not even in software")
    requests: list[str] = []
    page.context.on("request", lambda request: requests.append(request.url))
    page.evaluate(MOUNT)
    page.evaluate(ACT, ["seek", 20])
    page.get_by_role("button", name="Record frames 0 to 74").click(timeout=60_000)
    wait_for(page, "() => heard.some(({type}) => type === 'opened' || type === 'failed')", 120)
    assert messages_of(page, "failed") == []
    wait_for(page, "() => document.querySelector('.recording-veil') === null")
    page.wait_for_timeout(1500)
    assert page.evaluate("() => document.activeElement.tagName") != "IFRAME", "the viewer has taken the keyboard"

    # The viewer has the page's position: one step leads to the next frame.
    press(page, "ArrowRight")
    wait_for(page, "() => tsr.store.get().review.frame === 21")
    viewer = next(frame for frame in page.frames if "viewer" in frame.url and frame != page.main_frame)
    viewer.evaluate(COUNT)
    page.evaluate(ACT, ["seek", 50])
    deadline = time.monotonic() + MAX_WAIT_S
    while viewer.evaluate("globalThis.controlled") == 0:  # an earlier key would apply to the old position
        assert time.monotonic() < deadline, "the viewer has not gone there"
        page.wait_for_timeout(100)
    press(page, "ArrowLeft")
    wait_for(page, "() => tsr.store.get().review.frame === 49")

    # A track selected on the page is selected in the viewer.
    key = wait_for(
        page, "() => { const t = tsr.store.get().review.tracks; return t?.id.length ? `m${t.id[0]}` : null; }"
    )
    page.evaluate(ACT, ["select", key])
    wait_for(page, "() => heard.some(({type, entity}) => type === 'selected' && entity !== null)")
    entity = next(m["entity"] for m in messages_of(page, "selected") if m["entity"])
    assert entity in ("/video/results", f"/tracks/{key}/state")
    assert messages_of(page, "refused") == []
    assert page.evaluate("() => tsr.store.get().review.selected") == key

    assert any("re_viewer_bg.wasm" in url for url in requests)
    outside = [url for url in requests if not url.startswith((server.base, "blob:", "data:"))]
    assert outside == [], "something was asked of another host"
    page.evaluate("view.destroy()")
    assert page.locator(".recording-stage").count() == 0


def test_without_webgl_the_file_is_offered(page: Page) -> None:
    page.context.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.evaluate(MOUNT)
    page.evaluate(ACT, ["seek", 20])
    wait_for(page, "() => document.querySelector('.recording .btn-primary, .recording-stage')", 60)
    offer = page.get_by_role("button", name="Record frames 0 to 74")
    if offer.count():
        offer.click(timeout=10_000)
    link = page.get_by_role("link", name="Download the recording")
    link.wait_for(timeout=90_000)
    assert "WebGL 2" in page.locator(".recording-body").inner_text()
    assert (
        page.context.request.get(f"{page.evaluate('location.origin')}{link.get_attribute('href')}").body()[:4]
        == b"RRF2"
    )
