"""The picture on screen is the frame named by the page: burnt-in numbers are read from screenshots."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("playwright.sync_api")

from PIL import Image
from playwright.sync_api import Browser, Page

from tests.e2e.forked_server import ForkedServer
from tests.e2e.live_server import LiveServer
from tests.e2e.review_session import MAX_WAIT_S, open_address, without_errors
from tests.io import video_corpus

KINDS = (
    *("constant", "variable", "b_frames", "edit_list", "rotated_90", "rotated_180", "rotated_270"),
    *("m2ts", "raw_h264", "gif", "untimed_start"),
)
# One device pixel for each pixel of the picture; its upper left corner 60 pixels inside the stage, on a whole pixel.
ONE_TO_ONE = """async () => {
  const stage = document.querySelector('.picture-stage').getBoundingClientRect();
  const actions = await import('/static/js/store/actions/review.js');
  tsr.store.dispatch(state => actions.setViewport(state, {zoom: 1, x: stage.width / 2 - 60, y: stage.height / 2 - 60}));
}"""
# At the end of every frame of the browser: what the canvas shows, what the state says, whether anything lies over it.
WATCH = """async () => {
  const [shot, over] = ['.picture-shot', '.picture-layers'].map(name => document.querySelector(name));
  const seen = [];
  const look = () => {
    const {review} = tsr.store.get();
    const {data} = shot.getContext('2d').getImageData(60, 60, 96, 32);
    let code = 0;
    for (let bit = 0; bit < 12; bit++) {
      const at = ((Math.floor(bit / 6) * 16 + 8) * 96 + (bit % 6) * 16 + 8) * 4;
      if (data[at] + data[at + 1] + data[at + 2] > 384) code |= 1 << bit;
    }
    const ink = over.getContext('2d').getImageData(60, 60 + 46, 96, 1).data;
    let x = 0;
    while (x < 96 && ink[x * 4 + 3] === 0) x++;
    seen.push({code, x: x < 96 ? x : null, frame: review.frame, shown: review.shown});
    return review.playing;
  };
  const actions = await import('/static/js/store/actions/review.js');
  tsr.store.dispatch(state => actions.setPlaying(state, true));
  await new Promise(done => {
    const step = () => setTimeout(() => (look() ? requestAnimationFrame(step) : done()));
    requestAnimationFrame(step);
  });
  return seen;
}"""


@pytest.fixture(scope="module")
def server(
    tmp_path_factory: pytest.TempPathFactory, files: dict[str, video_corpus.CorpusVideo]
) -> Iterator[LiveServer]:
    roots = next(iter(files.values())).path.parent
    with ForkedServer(tmp_path_factory.mktemp("home"), roots=(roots,), sample=False) as running:
        yield running


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, video_corpus.CorpusVideo]:
    folder = tmp_path_factory.mktemp("videos")
    made = {
        name: video_corpus.make(video_corpus.RECIPES[name], folder, name)
        for name in (*KINDS, "wide_pixels")
        if name != "edit_list"
    }
    made["edit_list"] = video_corpus.with_edit_list(made["b_frames"], folder / "edit_list.mp4", 12, 30)
    return made


@pytest.fixture(scope="module")
def page(server: LiveServer, browser: Browser) -> Iterator[Page]:
    with without_errors(browser.new_page(viewport={"width": 1280, "height": 720})) as page:
        page.set_default_timeout(1000 * MAX_WAIT_S)
        page.goto(server.link())
        page.wait_for_function("() => globalThis.tsr?.store.get().session")
        yield page


def add(server: LiveServer, made: video_corpus.CorpusVideo) -> str:
    """Import a file; its id as soon as it is ready."""
    video = server.add_video(made.path)
    assert video["frames"] == len(made.codes)
    return str(video["id"])


def show(page: Page, video: str) -> None:
    """Open it one to one, nothing drawn over it."""
    open_address(page, f"#/review/{video}/-")
    page.wait_for_function(
        "id => { const r = tsr.store.get().review; return r?.video.id === id && r.timebase && r.shown === r.frame }",
        arg=video,
    )
    page.wait_for_function("() => tsr.store.get().review.viewport.zoom > 0")
    page.evaluate(ONE_TO_ONE)
    page.wait_for_function("() => tsr.store.get().review.viewport.zoom === 1")
    page.evaluate(
        "() => tsr.store.dispatch(state => ({...state, review: {...state.review,"
        " layers: Object.fromEntries(Object.keys(state.review.layers).map(name => [name, name === 'truth']))}}))"
    )


def on_screen(page: Page, frame: int) -> int:
    """The number in the picture on screen once the page says that it shows a frame."""
    page.wait_for_function(
        "frame => document.querySelector('.picture-stage').dataset.shown === String(frame)", arg=frame
    )
    facts: dict[str, Any] = page.evaluate(
        "() => { const place = document.querySelector('.picture-stage').getBoundingClientRect();"
        " const {x, y} = tsr.store.get().review.viewport;"
        " return {left: place.x + place.width / 2 - x, top: place.y + place.height / 2 - y}; }"
    )
    clip = {"x": round(facts["left"]), "y": round(facts["top"]), "width": video_corpus.WIDTH, "height": 32}
    picture = np.asarray(Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB"))
    return video_corpus.read_code(picture)


@pytest.mark.parametrize("kind", KINDS)
def test_the_picture_on_screen_is_the_frame_that_the_page_names(
    page: Page, server: LiveServer, files: dict[str, video_corpus.CorpusVideo], kind: str
) -> None:
    made = files[kind]
    show(page, add(server, made))
    page.locator(".picture-stage").focus()
    last = len(made.codes) - 1
    read = {0: on_screen(page, 0)}
    frame = 0
    for key, by in (("f", 1), ("f", 1), ("v", 10), ("d", -1), ("v", 10), ("c", -10), ("f", 1)):
        page.keyboard.press(key)
        frame += by
        read[frame] = on_screen(page, frame)
    page.keyboard.press("End")
    read[last] = on_screen(page, last)
    page.keyboard.press("d")
    read[last - 1] = on_screen(page, last - 1)
    assert read == {frame: made.codes[frame] for frame in read}


@pytest.mark.parametrize("kind", ["variable", "b_frames", "m2ts"])
def test_while_it_plays_overlays_lie_on_their_own_picture_only(
    page: Page, server: LiveServer, files: dict[str, video_corpus.CorpusVideo], kind: str
) -> None:
    made = files[kind]
    video = add(server, made)
    rows = [f"{k},1,{20 + k}.0,40.0,{32 + k}.0,54.0,14,1.0,0" for k in range(len(made.codes))]
    truth = "\n".join(["frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore", *rows, ""])
    server.call("PUT", f"/videos/{video}/ground-truths/moving", body=truth.encode(), type_="text/csv")
    open_address(page, "#/")
    page.wait_for_function("() => tsr.store.get().review === null")
    show(page, video)
    page.wait_for_function("() => tsr.store.get().review.truth[40]?.length === 1")
    seen = page.evaluate(WATCH)
    assert {one["shown"] for one in seen} >= {0, len(made.codes) - 1}
    wrong = [one for one in seen if one["code"] != one["shown"]]
    assert wrong == []
    # the box moves by one pixel a frame, so its position identifies its frame
    marked = [one for one in seen if one["x"] is not None]
    offsets = [one["x"] - one["code"] for one in marked]
    assert max(offsets) - min(offsets) <= 1, seen
    assert len(marked) >= 0.95 * len(seen)  # nearly every picture has its overlay


def test_pixels_that_are_not_square_are_shown_so_and_boxes_lie_where_the_mouse_drew_them(
    page: Page, server: LiveServer, files: dict[str, video_corpus.CorpusVideo]
) -> None:
    """96x64 pixels of ratio 4:3 are shown as 128x64; boxes are stored in pixels of 96x64."""
    made = files["wide_pixels"]
    show(page, add(server, made))
    page.keyboard.press("0")  # the whole picture
    page.wait_for_function("() => tsr.store.get().review.viewport.zoom > 1")
    view = page.evaluate(
        "() => { const place = document.querySelector('.picture-stage').getBoundingClientRect();"
        " const {zoom, x, y, stretch} = tsr.store.get().review.viewport;"
        " return {left: place.x + place.width / 2 - x * zoom * stretch, top: place.y + place.height / 2 - y * zoom,"
        " across: zoom * stretch, down: zoom, width: place.width, height: place.height}; }"
    )
    assert view["across"] == pytest.approx(view["down"] * 4 / 3)
    assert 96 * view["across"] <= view["width"] + 1
    assert 64 * view["down"] <= view["height"] + 1
    clip = {"x": view["left"], "y": view["top"], "width": 96 * view["across"], "height": 64 * view["down"]}
    shown = Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB")
    assert video_corpus.read_code(np.asarray(shown.resize((96, 64), Image.Resampling.BOX))) == made.codes[0]
    # drawn, then undone
    page.evaluate(
        "async () => { const actions = await import('/static/js/store/actions/review.js');"
        " tsr.store.dispatch(state => actions.setMode(state, 'draw')); }"
    )
    corners = [(view["left"] + x * view["across"], view["top"] + y * view["down"]) for x, y in ((30, 20), (72, 50))]
    page.mouse.move(*corners[0])
    page.mouse.down()
    page.mouse.move(*corners[1], steps=4)
    box = page.evaluate("() => tsr.store.get().review.drag.box")
    page.keyboard.press("Escape")
    page.mouse.up()
    assert box == pytest.approx([30, 20, 72, 50], abs=1 / view["down"] + 0.06)
