"""A person corrects a clip in a real browser: by mouse, by keyboard, over reloads, over a killed server."""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, Route, sync_playwright

from sample_videos import SHIPPED
from tests.e2e.live_server import LiveServer
from tests.e2e.review_desk import (
    PATIENCE,
    Desk,
    box_of,
    centre,
    choose_label,
    drag,
    edited,
    next_long_track,
    on_screen,
    saved,
    state,
    tracked,
    wait,
    zoom_in,
)
from tests.e2e.screenshots import CHROMIUM, FLAGS

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not CHROMIUM.is_file(), reason=f"{CHROMIUM} is not installed"),
]
REAL = "clips/SH4_70b651.mp4"
FRAMES = 150
"""So much of the clip is tracked: enough for every operation, and soon done."""


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    data = os.environ.get("TSR_DATA")
    clip = Path(data).resolve() / REAL if data and (Path(data) / REAL).is_file() else SHIPPED[0].video
    home = tmp_path_factory.mktemp("walk")
    roots = tmp_path_factory.mktemp("clips")
    shutil.copyfile(clip, roots / "clip.mp4")
    with LiveServer(home, roots=(roots,), sample=False) as server, sync_playwright() as playwright:
        video = str(server.add_video(roots / "clip.mp4")["id"])
        run = tracked(server, video, {"stop": FRAMES})
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield Desk(server, browser, video, run)
        browser.close()


@pytest.fixture
def page(desk: Desk) -> Iterator[Page]:
    page = desk.page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    yield page
    page.context.close()
    assert errors == []


def choose(page: Page, key: str) -> None:
    """Select a track wherever the cursor is."""
    page.evaluate("(k) => window.tsr.store.dispatch((s) => ({...s, review: {...s.review, selected: k}}))", key)


def meeting(desk: Desk, page: Page, place: int) -> tuple[Page, str]:
    """Another page that hears nothing of what others do, and the track that both have selected."""
    other = desk.page(deaf=True)
    key = "m" + str(state(page)["tracks"]["id"][place])
    for each in (page, other):
        choose(each, key)
    return other, key


RECOUNTED = """async (track) => {
  const { documentLane } = await import('/static/js/model/track_lane.js');
  const lane = window.tsr.store.get().review.laneOf[track];
  const segments = [{ track, first: 0, last: lane.frame.at(-2) }];
  const again = documentLane(`m${track}`, { key: `m${track}`, segments }, { [track]: lane }).lane;
  const share = (one, i, id) => one.votes[i][one.classes.indexOf(id)];
  const apart = (votes, i) => lane.classes.map((id, c) => Math.abs(votes[c] - share(again, i, id)));
  return Math.max(...lane.votes.slice(0, -1).flatMap((votes, i) => votes === null ? [] : apart(votes, i)));
}"""
"""How far the votes of a track without its last frame, counted anew on the page, are from the engine's own."""


def test_the_walk_by_mouse_and_keys(desk: Desk, page: Page) -> None:
    first = next_long_track(page)
    key = first["selected"]
    page.keyboard.press("v")
    wait(page, lambda s: s["frame"] == first["frame"] + 10 and s["shown"] == s["frame"] and s["overlay"])
    page.keyboard.press("f")
    page.keyboard.press("d")
    now = wait(page, lambda s: s["frame"] == first["frame"] + 10 and s["shown"] == s["frame"])
    box = box_of(now, key)

    # zoom in on it, move it, pull a corner
    page.mouse.move(*on_screen(page, *centre(box)))
    for _ in range(3):
        zoom_in(page)
    to = (centre(box)[0] + 6, centre(box)[1] + 4)
    moved = edited(page, lambda: drag(page, centre(box), to))["docs"][key]["keys"][str(now["frame"])]["box"]
    assert moved == pytest.approx([box[0] + 6, box[1] + 4, box[2] + 6, box[3] + 4], abs=1.5)
    pull = (moved[2] + 5, moved[3] + 7)
    pulled = edited(page, lambda: drag(page, (moved[2], moved[3]), pull))["docs"][key]["keys"][str(now["frame"])]["box"]
    assert pulled[:2] == pytest.approx(moved[:2], abs=0.2)
    assert pulled[2:] == pytest.approx([moved[2] + 5, moved[3] + 7], abs=1.5)

    # Escape takes a drag back
    before = saved(page)
    page.mouse.move(*on_screen(page, *centre(pulled)))
    page.mouse.down()
    page.mouse.move(*on_screen(page, centre(pulled)[0] + 20, centre(pulled)[1]), steps=3)
    page.keyboard.press("Escape")
    page.mouse.up()
    assert saved(page)["docs"] == before["docs"]

    # a box in the hand holds its frame: no key steps, plays or undoes below it
    page.mouse.move(*on_screen(page, *centre(pulled)))
    page.mouse.down()
    page.mouse.move(*on_screen(page, centre(pulled)[0] + 3, centre(pulled)[1]), steps=3)
    for pressed in ("f", " ", "Control+z", "Delete"):
        page.keyboard.press(pressed)
    page.mouse.move(*on_screen(page, *centre(pulled)), steps=3)
    held = state(page)
    assert (held["frame"], held["docs"]) == (now["frame"], before["docs"])
    assert page.evaluate("tsr.store.get().review.playing") is False
    page.keyboard.press("Escape")
    page.mouse.up()
    assert saved(page)["docs"] == before["docs"]

    # relabel by typing, whole track
    page.keyboard.press("l")
    choose_label(page, "keep right")
    assert wait(page, lambda s: s["docs"].get(key, {}).get("class_id") == 38 and s["unsaved"] == 0)

    # correct a second frame, interpolate between the two
    page.keyboard.press("v")
    wait(page, lambda s: s["frame"] == now["frame"] + 10 and s["shown"] == s["frame"] and s["overlay"])
    assert str(now["frame"] + 10) in edited(page, lambda: page.keyboard.press("k"))["docs"][key]["keys"]
    page.keyboard.press("d")
    assert edited(page, lambda: page.keyboard.press("i"))["docs"][key]["keys"][str(now["frame"])]["interpolate"] is True

    # occluded, out of sight and back
    assert (
        edited(page, lambda: page.keyboard.press("q"))["docs"][key]["keys"][str(now["frame"] + 9)]["occluded"] is True
    )
    assert edited(page, lambda: page.keyboard.press("o"))["docs"][key]["keys"][str(now["frame"] + 9)]["outside"] is True
    assert (
        edited(page, lambda: page.keyboard.press("o"))["docs"][key]["keys"][str(now["frame"] + 9)]["outside"] is False
    )

    # split here, merge again
    split = edited(page, lambda: page.keyboard.press("Alt+m"))
    later = next(k for k in split["docs"] if k.startswith("h") and not split["docs"][k]["gone"])
    span = split["docs"][later]["segments"][0]
    page.get_by_role("tab", name="Inspector").click()
    page.locator(".inspector-votes", has_text="These frames alone:").wait_for()
    frames = page.evaluate(f"window.tsr.store.get().review.laneOf[{span['track']}].frame")
    own = sum(span["first"] <= frame <= span["last"] for frame in frames)
    assert 0 < own < len(frames)
    crops = page.locator(".inspector-section", has_text="Crops")
    assert crops.locator(".muted").first.text_content() == f"{own} frames"
    assert page.evaluate(RECOUNTED, span["track"]) < 1e-3
    page.get_by_role("tab", name="Queue").click()
    page.evaluate(
        "([a, b]) => window.tsr.store.dispatch((s) => ({...s, review: {...s.review, selected: a}}))", [key, later]
    )
    page.keyboard.press("m")
    wait(page, lambda s: s["mode"] == "merge" and s["marked"] == [key])
    page.mouse.click(*on_screen(page, *centre(split["docs"][later]["keys"][str(now["frame"] + 9)]["box"])))
    wait(page, lambda s: s["marked"] == [key, later])
    merged = edited(page, lambda: page.keyboard.press("m"))
    assert merged["docs"][later]["merged_into"] == key

    # a box that is drawn and not labelled leaves nothing behind; labelled it is a new track
    page.keyboard.press("0")
    for label in (None, "stop"):
        page.keyboard.press("n")
        wait(page, lambda s: s["mode"] == "draw")
        drag(page, (100, 120), (160, 175))
        if label is None:
            page.locator("dialog[open] input:focus").wait_for()
            page.keyboard.press("Escape")
            page.locator("dialog[open]").wait_for(state="detached")
            assert saved(page)["docs"] == merged["docs"]
        else:
            choose_label(page, label)
    drawn = wait(page, lambda s: s["unsaved"] == 0 and s["docs"].get(s["selected"], {}).get("class_id") == 14)
    new = drawn["selected"]
    assert drawn["docs"][new]["class_id"] == 14
    assert next(iter(drawn["docs"][new]["keys"].values()))["box"] == pytest.approx([100, 120, 160, 175], abs=3)
    assert edited(page, lambda: page.keyboard.press("Shift+Delete"))["docs"][new]["gone"] is True

    # everything is on the server, and a reload brings the very same back
    assert desk.documents() == saved(page)["docs"]
    page.reload()
    again = wait(page, lambda s: s["shown"] == s["frame"] and len(s["docs"]) == len(merged["docs"]) + 1)
    assert again["docs"] == desk.documents()
    assert again["frame"] == now["frame"] + 9

    # back to the beginning, and forth again
    final = again["docs"]
    undone = 0
    while state(page)["undo"]:
        step = state(page)["undo"]["op_id"]
        page.keyboard.press("Control+z")
        wait(page, lambda s, step=step: s["unsaved"] == 0 and (s["undo"] or {}).get("op_id") != step)
        undone += 1
    assert undone >= 10
    bare = desk.documents()
    assert bare[key]["keys"] == {}
    assert bare[key]["class_id"] is None
    while state(page)["redo"]:
        step = state(page)["redo"]["op_id"]
        page.keyboard.press("Control+Shift+z")
        wait(page, lambda s, step=step: s["unsaved"] == 0 and (s["redo"] or {}).get("op_id") != step)

    def plain(docs: dict[str, Any]) -> dict[str, Any]:
        return {k: {**d, "revision": 0} for k, d in docs.items()}

    assert plain(desk.documents()) == plain(final)


def test_keyboard_alone(desk: Desk, page: Page) -> None:
    page.keyboard.press("j")
    now = wait(page, lambda s: s["selected"] is not None and s["shown"] == s["frame"] and s["overlay"])
    key = now["selected"]
    for _ in range(60):  # to the picture with Tab alone
        if page.evaluate("document.activeElement && document.activeElement.classList.contains('picture-stage')"):
            break
        page.keyboard.press("Tab")
    else:
        raise AssertionError("Tab never reaches the picture")
    assert page.evaluate("document.activeElement.matches(':focus-visible')")
    choose(page, key)
    before = desk.documents().get(key, {}).get("revision", 0)
    for nudge in ("ArrowRight", "Shift+ArrowDown", "Alt+ArrowRight"):
        page.keyboard.press(nudge)
    wait(page, lambda s: s["unsaved"] == 0 and s["docs"].get(key, {}).get("revision", 0) >= before + 3)
    judged = edited(page, lambda: page.keyboard.press("a"))
    assert judged["docs"][key]["review"] == "accepted"
    # Tab leaves the picture behind its last track: no trap
    page.locator(".picture-stage").focus()
    for _ in range(12):
        page.keyboard.press("Tab")
    assert not page.evaluate("document.activeElement.classList.contains('picture-stage')")
    page.keyboard.press("F1")
    page.locator("dialog[open]").wait_for()
    page.keyboard.press("Escape")
    assert page.locator("dialog[open]").count() == 0


def test_a_reload_in_the_middle_of_a_drag_changes_nothing(desk: Desk, page: Page) -> None:
    page.keyboard.press("j")
    now = wait(page, lambda s: s["selected"] is not None and s["shown"] == s["frame"] and s["overlay"])
    before = desk.documents()
    x, y = centre(box_of(now, now["selected"])) if now["selected"].startswith("m") else (100, 100)
    page.mouse.move(*on_screen(page, x, y))
    page.mouse.down()
    page.mouse.move(*on_screen(page, x + 30, y + 20), steps=4)
    page.reload()
    page.mouse.up()
    wait(page, lambda s: s["shown"] == s["frame"] and s["tracks"] is not None)
    assert desk.documents() == before
    assert state(page)["drag"] is None


def test_one_verdict_on_all_shown_tracks(desk: Desk, page: Page) -> None:
    before = {key: doc["review"] for key, doc in desk.documents().items()}
    page.get_by_role("button", name="Judge all …").click()
    dialog = page.get_by_role("dialog")
    judged = dialog.get_by_role("button", name=re.compile(r"^Accept \d+ tracks?$"))
    words = judged.inner_text().split()
    assert int(words[1]) > 1
    dialog.get_by_label("With a doubt of at most, %").fill("0")
    assert int(judged.inner_text().split()[1]) < int(words[1])
    dialog.get_by_label("With a doubt of at most, %").fill("")
    edited(page, judged.click)
    after = {key: doc["review"] for key, doc in desk.documents().items()}
    changed = {key for key, review in after.items() if review != before.get(key, "open")}
    assert len(changed) == int(words[1])
    assert {after[key] for key in changed} == {"accepted"}
    edited(page, lambda: page.keyboard.press("Control+z"))
    undone = {key: doc["review"] for key, doc in desk.documents().items()}
    assert all(undone[key] == before.get(key, "open") for key in undone)


def test_two_pages_on_one_track(desk: Desk, page: Page) -> None:
    other, key = meeting(desk, page, 0)
    mine = edited(page, lambda: page.keyboard.press("w"))["docs"][key]["review"]
    other.keyboard.press("Shift+x")
    dialog = other.locator("dialog[open]")
    dialog.wait_for()
    assert desk.documents()[key]["review"] == mine  # nothing was overwritten
    for meant_for_the_picture in ("Space", "Enter", "f", "a"):
        other.keyboard.press(meant_for_the_picture)
    assert state(other)["unsaved"] == 1
    assert dialog.is_visible()
    dialog.get_by_role("button", name="Keep mine").click()
    end = time.monotonic() + PATIENCE
    while not desk.documents()[key]["not_a_sign"] and time.monotonic() < end:
        other.wait_for_timeout(100)
    both = desk.documents()[key]
    assert (both["review"], both["not_a_sign"]) == (mine, True)
    # and the other choice: what the first page has saved stands
    wait(page, lambda s: s["docs"][key]["not_a_sign"])  # the first page has heard of it
    choose(page, key)  # a verdict has moved on to the next track
    theirs = edited(page, lambda: page.keyboard.press("x"))["docs"][key]["review"]
    other.keyboard.press("Shift+x")
    dialog.wait_for()
    dialog.get_by_role("button", name="Take the saved version").click()
    wait(other, lambda s: s["unsaved"] == 0)
    assert desk.documents()[key]["review"] == theirs
    assert desk.documents()[key]["not_a_sign"] is True
    other.context.close()


def test_two_boxes_of_one_frame_are_seen_before_one_is_chosen(desk: Desk, page: Page) -> None:
    other, key = meeting(desk, page, -1)
    frame = state(page)["tracks"]["first"][-1]
    boxes = []
    for each, (right, down) in ((page, (6, 4)), (other, (-5, 6))):
        each.keyboard.press("t")
        now = wait(each, lambda s: s["frame"] == frame and s["shown"] == frame and s["overlay"])
        x, y = centre(box_of(now, key))
        drag(each, (x, y), (x + right, y + down))
        boxes.append(wait(each, lambda s: str(frame) in s["docs"].get(key, {}).get("keys", {}))["docs"][key]["keys"])
        if each is page:
            saved(page)
    dialog = other.locator("dialog[open]")
    for whose, keys in zip(("saved", "mine"), boxes, strict=True):
        box = keys[str(frame)]["box"]
        drawn = dialog.locator(f".two-versions-{whose}")
        drawn.wait_for()
        found = [float(drawn.get_attribute(name) or "nan") for name in ("x", "y", "width", "height")]
        assert found == pytest.approx([box[0], box[1], box[2] - box[0], box[3] - box[1]])
    assert dialog.get_by_text(f"Frame {frame}", exact=True).count() >= 1
    dialog.get_by_role("button", name="Keep mine").click()
    wait(other, lambda s: s["unsaved"] == 0)
    assert desk.documents()[key]["keys"][str(frame)]["box"] == boxes[1][str(frame)]["box"]
    other.context.close()


def test_an_edit_of_a_track_that_another_page_has_deleted(desk: Desk, page: Page) -> None:
    other, key = meeting(desk, page, 1)
    assert edited(page, lambda: page.keyboard.press("Shift+Delete"))["docs"][key]["gone"]
    other.keyboard.press("Shift+x")
    dialog = other.locator("dialog[open]")
    dialog.get_by_text("was deleted: “Keep mine” restores it").wait_for()
    assert dialog.get_by_role("row", name="State").get_by_role("cell").all_inner_texts() == ["deleted", "not reviewed"]
    dialog.get_by_role("button", name="Keep mine").click()
    wait(other, lambda s: s["unsaved"] == 0 and not s["docs"][key]["gone"])
    assert (desk.documents()[key]["gone"], desk.documents()[key]["not_a_sign"]) == (False, True)
    other.context.close()
    # what is deleted is listed, and comes back from there
    wait(page, lambda s: s["docs"][key]["not_a_sign"])
    choose(page, key)
    assert edited(page, lambda: page.keyboard.press("Shift+Delete"))["docs"][key]["gone"]
    page.get_by_role("button", name=re.compile("deleted tracks?, show")).click()
    rows = page.get_by_role("list", name="Deleted tracks").get_by_role("listitem")
    row = rows.filter(has=page.get_by_role("button", name=f"Restore track #{key[1:]}", exact=True))
    assert "not a sign" in row.inner_text()
    row.get_by_text(re.compile("^deleted by .+ · ")).wait_for()
    assert row.locator("img").evaluate("async image => { await image.decode(); return image.naturalWidth; }") > 0
    back = edited(page, lambda: row.get_by_role("button", name="Restore").click())
    assert (back["docs"][key]["gone"], back["selected"]) == (False, key)
    row.wait_for(state="detached")
    page.keyboard.press("Escape")
    page.locator("dialog[open]").wait_for(state="detached")


@pytest.mark.parametrize(("status", "code"), [(507, "storage_full"), (503, "busy")])
def test_a_full_disk_or_a_locked_database_keeps_the_edit(desk: Desk, page: Page, status: int, code: str) -> None:
    key = "m" + str(state(page)["tracks"]["id"][-1])
    before = desk.documents().get(key, {"not_a_sign": False})["not_a_sign"]
    answer = {"error": {"code": code, "message": "The disk is full. Make room.", "field": None, "details": None}}
    edits = re.compile(r"/api/runs/[0-9a-f]+/edits$")

    def refuse(route: Route) -> None:
        if route.request.method == "POST":
            route.fulfill(status=status, json=answer)
        else:
            route.fallback()

    page.route(edits, refuse)
    choose(page, key)
    page.keyboard.press("Shift+x")
    banner = page.locator(".banner").filter(has_text="The disk is full. Make room.")
    banner.first.wait_for()
    assert state(page)["unsaved"] == 1
    assert state(page)["docs"][key]["not_a_sign"] is not before  # the page shows what was done
    assert desk.documents().get(key, {"not_a_sign": False})["not_a_sign"] is before
    page.unroute(edits)  # somebody has made room
    wait(page, lambda s: s["unsaved"] == 0)
    assert desk.documents()[key]["not_a_sign"] is not before
    banner.wait_for(state="detached")


def test_a_killed_server_loses_nothing(desk: Desk, page: Page) -> None:
    page.keyboard.press("j")
    key = wait(page, lambda s: s["selected"] is not None)["selected"]
    port = int(desk.server.base.rsplit(":", 1)[1])
    count = len(desk.server.call("GET", f"/runs/{desk.run}/edits")["edits"])
    before = desk.documents().get(key, {"not_a_sign": False})["not_a_sign"]
    desk.server.kill()
    choose(page, key)
    page.keyboard.press("Shift+x")
    wait(page, lambda s: s["unsaved"] == 1)
    page.locator(".banner").first.wait_for()
    page.locator(".saved").filter(has_text="Offline, 1 to save").wait_for()
    desk.server.start(port)
    wait(page, lambda s: s["unsaved"] == 0)
    edits = desk.server.call("GET", f"/runs/{desk.run}/edits")["edits"]
    assert len(edits) == count + 1  # it arrived, once
    assert edits[-1]["name"] == "set_not_a_sign"
    assert desk.documents()[key]["not_a_sign"] is not before
    page.locator(".banner").wait_for(state="detached")
