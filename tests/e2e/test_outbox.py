"""Unsaved edits in a real browser: over a reload, with a clock set back, from an older page, with a full disk, over
a killed server.
"""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, Route, expect

from tests.e2e.interception import intercept
from tests.e2e.review_session import ReviewSession, open_address, select_track, state, wait_for, without_errors


@pytest.fixture
def page(review: ReviewSession) -> Iterator[Page]:
    with without_errors(review.page(shared=True)) as page:
        page.on("dialog", lambda dialog: dialog.accept())
        yield page


def to_a_box(page: Page) -> tuple[str, str]:
    """Select the first track of the queue, so that the arrows move its box; its key and frame."""
    page.keyboard.press("j")
    now = wait_for(page, lambda s: s["selected"] is not None and s["shown"] == s["frame"] and s["overlay"])
    page.locator(".picture-stage").focus()
    select_track(page, now["selected"])
    return now["selected"], str(now["frame"])


def comes_back(review: ReviewSession, page: Page, key: str, at: str, box: list[float]) -> None:
    """The reloaded page saves the edits that the old one showed."""
    again = wait_for(page, lambda s: key in s["docs"] and s["unsaved"] == 0 and s["tracks"] is not None)
    assert again["docs"][key]["keys"][at]["box"] == box
    assert review.documents()[key]["keys"][at]["box"] == pytest.approx(box)


def test_a_reload_right_after_a_burst_of_edits_loses_none(review: ReviewSession, page: Page) -> None:
    key, at = to_a_box(page)
    page.keyboard.press("ArrowLeft")
    start = state(page)["docs"][key]["keys"][at]["box"]
    for _ in range(20):
        page.keyboard.press("ArrowLeft")
    box = state(page)["docs"][key]["keys"][at]["box"]
    assert box[0] == pytest.approx(start[0] - 20)
    page.reload()
    comes_back(review, page, key, at, box)


def test_edits_of_an_earlier_visit_are_sent_in_their_order_after_the_clock_was_set_back(
    review: ReviewSession, page: Page
) -> None:
    key, at = to_a_box(page)
    edits = re.compile(r"/api/runs/.*/edits$")
    intercept(page, edits, lambda route: route.abort())
    for turn in range(3):
        page.evaluate("(days) => { const now = Date.now; Date.now = () => now() - days * 86400000; }", turn)
        page.keyboard.press("Alt+ArrowLeft" if turn == 1 else "ArrowLeft")  # successive moves would be one edit
        wait_for(page, lambda s, turn=turn: s["unsaved"] == turn + 1)
    box = state(page)["docs"][key]["keys"][at]["box"]
    # some are sent before the review is open, so their events arrive before the documents
    intercept(page, re.compile(r"/api/runs/.*/annotation"), lambda route: (time.sleep(0.5), route.continue_())[1])
    page.unroute(edits)
    page.reload()
    comes_back(review, page, key, at, box)


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
CUT_OFF = """async ([one, ...changes]) => {
  const { createOutbox } = await import('/static/js/editing/outbox.js');
  const outbox = createOutbox();
  await outbox.all(); // the database is open
  const complete = Object.getOwnPropertyDescriptor(IDBTransaction.prototype, 'oncomplete');
  Object.defineProperty(IDBTransaction.prototype, 'oncomplete', { set() {}, configurable: true });
  for (const edit of [one, ...changes]) void outbox.put(edit);
  await new Promise((done) => setTimeout(done));
  Object.defineProperty(IDBTransaction.prototype, 'oncomplete', complete);
}"""
"""Changed by a page that ends before the database has said anything."""


def test_the_outbox_takes_over_what_an_older_one_holds_and_counts_on(review: ReviewSession) -> None:
    page = review.browser.new_context().new_page()
    page.route("**/js/main.js", lambda route: route.abort())  # current pages do not open its outbox
    page.goto(review.server.link())

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
    outbox("put", edit("b", seen={"m1": 5}))  # a changed edit keeps its place
    outbox("remove", "a")
    page.evaluate("globalThis.outbox = undefined")  # as after a reload
    assert outbox("load", "r") == [edit("b", seen={"m1": 5}), edit("c"), edit("A")]
    page.evaluate(BURST, [edit("e", run="t"), edit("d", run="t"), edit("f", run="t")])
    assert outbox("load", "t") == [edit("e", run="t", seen={"m1": 9}), edit("d", run="t")]
    page.evaluate(
        CUT_OFF, [edit("h", run="u"), edit("i", run="u"), *(edit("h", run="u", seen={"m1": n}) for n in (1, 2))]
    )
    assert outbox("load", "u") == [edit("h", run="u", seen={"m1": 2}), edit("i", run="u")]
    outbox("put", edit("h", run="u", seen={"m1": 3}))
    assert outbox("load", "u") == [edit("h", run="u", seen={"m1": 3}), edit("i", run="u")]
    outbox("remove", "h")
    page.evaluate("globalThis.outbox = undefined")
    assert outbox("load", "u") == [edit("i", run="u")]
    page.context.close()


@pytest.mark.parametrize(("status", "code"), [(507, "storage_full"), (503, "busy")])
def test_a_full_disk_or_a_locked_database_keeps_the_edit(
    review: ReviewSession, page: Page, status: int, code: str
) -> None:
    key = "m" + str(state(page)["tracks"]["id"][-1])
    before = review.documents().get(key, {}).get("ignore", False)
    answer = {"error": {"code": code, "message": "The disk is full. Make room.", "field": None, "details": None}}
    edits = re.compile(r"/api/runs/[0-9a-f]+/edits$")

    def refuse(route: Route) -> None:
        if route.request.method == "POST":
            route.fulfill(status=status, json=answer)
        else:
            route.fallback()

    intercept(page, edits, refuse)
    select_track(page, key)
    page.keyboard.press("u")
    banner = page.locator(".banner").filter(has_text="The disk is full. Make room.")
    banner.first.wait_for()
    assert state(page)["unsaved"] == 1
    assert state(page)["docs"][key].get("ignore", False) is not before  # the page shows the edit
    assert review.documents().get(key, {}).get("ignore", False) is before
    page.unroute(edits)  # the disk has room again
    wait_for(page, lambda s: s["unsaved"] == 0)
    assert review.documents()[key].get("ignore", False) is not before
    banner.wait_for(state="detached")


def test_a_killed_server_loses_nothing(review: ReviewSession, page: Page) -> None:
    page.keyboard.press("j")
    key = wait_for(page, lambda s: s["selected"] is not None)["selected"]
    port = int(review.server.base.rsplit(":", 1)[1])
    count = len(review.server.call("GET", f"/runs/{review.run}/edits")["edits"])
    before = review.documents().get(key, {}).get("ignore", False)
    review.server.kill()
    select_track(page, key)
    page.keyboard.press("u")
    wait_for(page, lambda s: s["unsaved"] == 1)
    page.locator(".banner").first.wait_for()
    page.locator(".saved").filter(has_text="Offline, 1 to save").wait_for()
    review.server.start(port)
    wait_for(page, lambda s: s["unsaved"] == 0)
    edits = review.server.call("GET", f"/runs/{review.run}/edits")["edits"]
    assert len(edits) == count + 1  # it arrived, once
    assert edits[-1]["name"] == "ignore"
    assert review.documents()[key].get("ignore", False) is not before
    expect(page.locator(".banner")).to_have_count(0)


def test_undo_without_a_server_is_about_what_was_done_before_it(review: ReviewSession, page: Page) -> None:
    key, at = to_a_box(page)
    before = state(page)["docs"].get(key)
    port = int(review.server.base.rsplit(":", 1)[1])
    review.server.kill()
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Control+z")
    expect(page.locator(".toast").filter(has_text=f"Undone: box corrected in frame {at}")).to_be_visible()
    now = state(page)["docs"][key]
    assert now["keys"].get(at) == (before or {"keys": {}})["keys"].get(at)
    page.keyboard.press("p")
    page.locator("dialog textarea").fill("not to be lost")
    page.keyboard.press("Control+Enter")
    wait_for(page, lambda s: s["unsaved"] == 3)
    review.server.start(port)
    wait_for(page, lambda s: s["unsaved"] == 0)
    there = review.documents()[key]
    assert there["keys"].get(at) == (before or {"keys": {}})["keys"].get(at)
    assert [note["text"] for note in there["notes"]][-1] == "not to be lost"


def test_a_review_that_was_left_is_saved_from_the_library(review: ReviewSession, page: Page) -> None:
    key, at = to_a_box(page)
    edits = re.compile(r"/api/runs/.*/edits$")
    intercept(page, edits, lambda route: route.abort())
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("w")
    wait_for(page, lambda s: s["unsaved"] == 2)
    box = state(page)["docs"][key]["keys"][at]["box"]
    open_address(page, "#/")
    left = page.locator(".saved").filter(has_text="Saving 2")
    left.wait_for()
    page.reload()
    left.wait_for()  # still on the library: no page opens the run
    page.unroute(edits)
    page.locator(".saved").filter(has_text="Saving").wait_for(state="hidden")  # neither 2 nor 1
    assert review.documents()[key]["keys"][at]["box"] == pytest.approx(box)
    assert review.documents()[key]["review"] == "needs_work"
