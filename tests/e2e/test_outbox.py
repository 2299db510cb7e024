"""Edits that are not saved yet, in a real browser: over a reload, with a clock that is set back, from an older page."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, sync_playwright

from sample_videos import SHIPPED
from tests.e2e.live_server import LiveServer
from tests.e2e.review_desk import Desk, state, tracked, wait
from tests.e2e.screenshots import CHROMIUM, FLAGS

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not CHROMIUM.is_file(), reason=f"{CHROMIUM} is not installed"),
]


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    roots = tmp_path_factory.mktemp("clips")
    shutil.copyfile(SHIPPED[0].video, roots / "drive.mp4")
    with LiveServer(tmp_path_factory.mktemp("home"), roots=(roots,), sample=False) as server, sync_playwright() as play:
        video = str(server.add_video(roots / "drive.mp4")["id"])
        run = tracked(server, video, {"stop": 120})
        browser = play.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield Desk(server, browser, video, run)
        browser.close()


@pytest.fixture
def page(desk: Desk) -> Iterator[Page]:
    page = desk.page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("dialog", lambda dialog: dialog.accept())
    yield page
    page.context.close()
    assert errors == []


def to_a_box(page: Page) -> tuple[str, str]:
    """Select the first track of the queue, so that the arrows move its box; its key and frame."""
    page.keyboard.press("j")
    now = wait(page, lambda s: s["selected"] is not None and s["shown"] == s["frame"] and s["overlay"])
    page.locator(".picture-stage").focus()
    page.evaluate(CHOOSE, now["selected"])
    return now["selected"], str(now["frame"])


def comes_back(desk: Desk, page: Page, key: str, at: str, box: list[float]) -> None:
    """The page that was loaded anew saves what the old one showed."""
    again = wait(page, lambda s: key in s["docs"] and s["unsaved"] == 0 and s["tracks"] is not None)
    assert again["docs"][key]["keys"][at]["box"] == box
    assert desk.documents()[key]["keys"][at]["box"] == pytest.approx(box)


CHOOSE = "(key) => tsr.store.dispatch((s) => ({...s, review: {...s.review, selected: key}}))"


def test_a_reload_right_after_a_burst_of_edits_loses_none(desk: Desk, page: Page) -> None:
    key, at = to_a_box(page)
    page.keyboard.press("ArrowLeft")
    start = state(page)["docs"][key]["keys"][at]["box"]
    for _ in range(20):
        page.keyboard.press("ArrowLeft")
    box = state(page)["docs"][key]["keys"][at]["box"]
    assert box[0] == pytest.approx(start[0] - 20)
    page.reload()
    comes_back(desk, page, key, at, box)


def test_edits_of_an_earlier_visit_are_sent_in_their_order_after_the_clock_was_set_back(desk: Desk, page: Page) -> None:
    key, at = to_a_box(page)
    edits = re.compile(r"/api/runs/.*/edits$")
    page.route(edits, lambda route: route.abort())
    for turn in range(3):
        page.evaluate("(days) => { const now = Date.now; Date.now = () => now() - days * 86400000; }", turn)
        page.keyboard.press("ArrowLeft")
        wait(page, lambda s, turn=turn: s["unsaved"] == turn + 1)
    box = state(page)["docs"][key]["keys"][at]["box"]
    page.reload()
    page.unroute(edits)
    comes_back(desk, page, key, at, box)


OLD_OUTBOX = """(kept) => new Promise((resolve, reject) => {
  const request = indexedDB.open('tsr-review', 1);
  request.onupgradeneeded = () => request.result.createObjectStore('outbox', { keyPath: 'op_id' });
  request.onerror = () => reject(request.error);
  request.onsuccess = () => {
    const db = request.result;
    const transaction = db.transaction('outbox', 'readwrite');
    for (const one of kept) transaction.objectStore('outbox').put(one);
    transaction.oncomplete = () => {
      globalThis.old = db;
      resolve();
    };
  };
})"""
"""The browser's database as a page of version 1 has left it; it stays open."""
OUTBOX = """async ([act, ...given]) => {
  const { createOutbox } = await import('/static/js/editing/outbox.js');
  globalThis.outbox ??= createOutbox();
  return outbox[act](...given).catch((thrown) => String(thrown));
}"""
BURST = """async ([one, two, three]) => {
  const { createOutbox } = await import('/static/js/editing/outbox.js');
  const outbox = createOutbox();
  const puts = [one, two, { ...one, seen: { m1: 9 } }, three].map((edit) => outbox.put(edit));
  await Promise.all([...puts, outbox.remove(three.op_id)]);
}"""
"""Changed, and acknowledged, before the database has said that it holds them."""


def test_the_outbox_takes_over_what_an_older_one_holds_and_counts_on(desk: Desk) -> None:
    page = desk.browser.new_context().new_page()
    page.goto(desk.server.link())  # the library: the page has not opened its outbox yet

    def outbox(act: str, *given: Any) -> Any:
        return page.evaluate(OUTBOX, [act, *given])

    def edit(op_id: str, **more: Any) -> dict[str, Any]:
        return {"op_id": op_id, "run": "r", "author": "ann", "command": {"name": "undo"}, "seen": {}, **more}

    kept = [edit("c", order=30), edit("a", order=10), edit("b", order=20, seen={"m1": 4}), edit("z", order=5, run="s")]
    page.evaluate(OLD_OUTBOX, kept)
    assert "older version" in outbox("load", "r"), "a page of the older version is still open"
    page.evaluate("old.close()")
    assert outbox("load", "r") == [edit("a"), edit("b", seen={"m1": 4}), edit("c")]
    assert outbox("load", "s") == [edit("z", run="s")]
    outbox("put", edit("A"))
    outbox("put", edit("b", seen={"m1": 5}))  # what is changed keeps its place
    outbox("remove", "a")
    page.evaluate("globalThis.outbox = undefined")  # as after a reload
    assert outbox("load", "r") == [edit("b", seen={"m1": 5}), edit("c"), edit("A")]
    page.evaluate(BURST, [edit("e", run="t"), edit("d", run="t"), edit("f", run="t")])
    assert outbox("load", "t") == [edit("e", run="t", seen={"m1": 9}), edit("d", run="t")]
    page.context.close()
