"""The 3-D view in a real browser with software rendering: drawn, clicked, and a file where there is no WebGL."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api")

import cv2
import numpy as np
from playwright.sync_api import Page, WebSocket, expect

from tests.app.toy_home import ToyHome, make_home
from tests.e2e.browsers import open_browser
from tests.e2e.forked_server import ForkedServer
from tests.e2e.live_server import LiveServer

GL = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
MOUNT = """async ({webgl, frame}) => {
  const {createScene3dView} = await import('/static/js/views/scene3d/index.js');
  const {seek} = await import('/static/js/store/actions/review.js');
  const app = {store: tsr.store, api: {base: '/api'}, signal: new AbortController().signal};
  const view = createScene3dView(app, webgl ? {} : {webgl: () => false});
  const place = document.createElement('div');
  place.style.cssText = 'position:fixed;inset:0;z-index:99;background:#fff';
  place.append(view.element);
  document.body.append(place);
  tsr.store.subscribe(() => view.update(tsr.store.get()));
  tsr.store.dispatch((state) => seek(state, frame));
  view.update(tsr.store.get());
}"""

SEEK = """async (frame) => {
  const {seek} = await import('/static/js/store/actions/review.js');
  tsr.store.dispatch((state) => seek(state, frame));
}"""


@pytest.fixture(scope="module")
def toy(tmp_path_factory: pytest.TempPathFactory) -> ToyHome:
    home = make_home(tmp_path_factory.mktemp("scene3d"))
    home.evidence.close()
    home.database.close()
    return home


@pytest.fixture(scope="module")
def server(toy: ToyHome) -> Iterator[LiveServer]:
    (toy.settings.home / "token").write_text("t" * 24)
    with ForkedServer(toy.settings.home, roots=(toy.video.parent,), sample=False) as running:
        yield running


@pytest.fixture
def page(server: LiveServer, toy: ToyHome) -> Iterator[Page]:
    with open_browser(GL) as browser:
        page = browser.new_page(viewport={"width": 900, "height": 600})
        wrong: list[str] = []
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("console", lambda said: wrong.append(said.text) if "Content Security Policy" in said.text else None)
        page.on(
            "request",
            lambda asked: None if asked.url.startswith((server.base, "data:", "blob:")) else wrong.append(asked.url),
        )
        page.goto(f"{server.link()}#/review/{toy.video_id}/{toy.run_id}")
        expect(page.locator(".picture-stage")).to_have_attribute("data-shown", "0", timeout=30_000)
        yield page
        assert wrong == []


def picture(page: Page) -> np.ndarray:
    """The frame with the scene as it is on the screen, BGR."""
    shot = page.locator(".scene3d-frame").screenshot(timeout=60_000)
    return cv2.imdecode(np.frombuffer(shot, np.uint8), cv2.IMREAD_COLOR)


def block(shot: np.ndarray) -> tuple[int, int] | None:
    """A point well inside an area with the colour of the most frequent class."""
    blue, green, red = (shot[..., i].astype(int) for i in range(3))
    like = (abs(blue - 233) < 45) & (abs(green - 180) < 45) & (abs(red - 86) < 50)
    like[:, int(shot.shape[1] * 0.66) :] = False  # the panel with the legend
    inner = cv2.erode(like.astype(np.uint8), np.ones((5, 5), np.uint8))
    places = np.argwhere(inner)
    return None if not len(places) else (int(places[len(places) // 2][1]), int(places[len(places) // 2][0]))


def test_the_scene_is_drawn_and_a_click_on_a_block_selects_its_track(page: Page) -> None:
    page.evaluate(MOUNT, {"webgl": True, "frame": 30})
    expect(page.locator(".scene3d-frame")).to_be_visible(timeout=30_000)
    end, found = time.monotonic() + 120, None
    while found is None:
        assert time.monotonic() < end, "no block was drawn"
        page.wait_for_timeout(500)
        found = block(picture(page))
    # Without a graphics card pictures are drawn once, not four times; the canvas of the scene is the last one.
    inside = next(frame for frame in page.frames if "/viser/" in frame.url)
    context = inside.evaluate(
        "[...document.querySelectorAll('canvas')].pop().getContext('webgl2').getContextAttributes()"
    )
    assert not context["antialias"]
    assert not context["preserveDrawingBuffer"]
    frame = page.locator(".scene3d-frame").bounding_box()
    assert frame is not None
    while page.evaluate("tsr.store.get().review.selected") is None:
        assert time.monotonic() < end, "the click selected nothing"
        found = block(picture(page)) or found
        page.mouse.move(frame["x"] + found[0], frame["y"] + found[1])
        page.wait_for_timeout(300)
        page.mouse.click(frame["x"] + found[0], frame["y"] + found[1])
        page.wait_for_timeout(1500)
    assert page.evaluate("tsr.store.get().review.selected").startswith("m")
    page.get_by_role("button", name="Metric drive").click()
    # The panel is a bar until it is clicked; viser's notice about drawing by software is not shown, ours is.
    expect(page.locator(".scene3d-notice")).to_contain_text("No graphics card")
    expect(page.frame_locator(".scene3d-frame").get_by_text("Software WebGL")).to_have_count(0)
    assert inside.evaluate("Number(new URL(location.href).searchParams.get('fixedDpr'))") < 1
    page.frame_locator(".scene3d-frame").locator("[data-dock-group][data-dock-collapsed]").first.click()
    expect(page.frame_locator(".scene3d-frame").get_by_text("Assumed: the camera sees 60°")).to_be_visible(
        timeout=60_000
    )


def test_the_scene_connects_again_after_the_server_was_away(page: Page, server: LiveServer) -> None:
    opened: list[WebSocket] = []
    page.on("websocket", lambda socket: opened.append(socket))
    page.evaluate(MOUNT, {"webgl": True, "frame": 30})
    end = time.monotonic() + 120
    while not opened:
        assert time.monotonic() < end, "no socket was opened"
        page.wait_for_timeout(200)
    server.stop()
    notice = page.locator(".scene3d-notice")
    page.evaluate(SEEK, 31)
    expect(notice).to_contain_text("cannot be reached")
    heard: list[object] = []
    page.on("websocket", lambda again: again.on("framereceived", lambda frame: heard.append(frame)))
    server.start(int(server.base.rpartition(":")[2]))
    while not heard:
        assert time.monotonic() < end, "the scene stays cut"
        page.wait_for_timeout(200)
    expect(notice).to_be_empty(timeout=60_000)


def test_without_webgl_the_scene_is_offered_as_a_file(page: Page) -> None:
    page.evaluate(MOUNT, {"webgl": False, "frame": 30})
    expect(page.get_by_role("heading", name="Without WebGL")).to_be_visible()
    page.get_by_role("button", name="Save the scene as a file").click()
    link = page.locator(".scene3d-notice a")
    expect(link).to_be_visible(timeout=90_000)
    with page.expect_download(timeout=30_000) as waited:
        link.click()
    assert waited.value.suggested_filename.endswith("_Run_1_volume.html")
    text = Path(waited.value.path()).read_text(encoding="utf-8")
    assert "__VISER_EMBED_DATA__" in text
