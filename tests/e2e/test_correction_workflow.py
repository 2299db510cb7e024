"""A person corrects a clip in a real browser: by mouse, by keyboard, over reloads."""

from __future__ import annotations

import re
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, expect

from tests.e2e.interception import intercept
from tests.e2e.review_session import (
    ReviewSession,
    centre,
    choose_label,
    drag,
    edit_and_save,
    engine_box,
    go_back,
    open_address,
    open_long_track,
    reload_review,
    screen_point,
    select_track,
    state,
    wait_for,
    wait_until_no_dialog,
    wait_until_saved,
    zoom_in,
)


def test_the_walk_by_mouse_and_keys(review: ReviewSession, page: Page) -> None:
    first = open_long_track(page)
    key = first["selected"]
    page.keyboard.press("v")
    wait_for(page, lambda s: s["frame"] == first["frame"] + 10 and s["shown"] == s["frame"] and s["overlay"])
    page.keyboard.press("f")
    page.keyboard.press("d")
    now = wait_for(page, lambda s: s["frame"] == first["frame"] + 10 and s["shown"] == s["frame"])
    box = engine_box(now, key)

    # zoom in on it, move it, pull a corner
    page.mouse.move(*screen_point(page, *centre(box)))
    for _ in range(3):
        zoom_in(page)
    to = (centre(box)[0] + 6, centre(box)[1] + 4)
    moved = edit_and_save(page, lambda: drag(page, centre(box), to))["docs"][key]["keys"][str(now["frame"])]["box"]
    assert moved == pytest.approx([box[0] + 6, box[1] + 4, box[2] + 6, box[3] + 4], abs=1.5)
    pull = (moved[2] + 5, moved[3] + 7)
    pulled = edit_and_save(page, lambda: drag(page, (moved[2], moved[3]), pull))["docs"][key]["keys"][
        str(now["frame"])
    ]["box"]
    assert pulled[:2] == pytest.approx(moved[:2], abs=0.2)
    assert pulled[2:] == pytest.approx([moved[2] + 5, moved[3] + 7], abs=1.5)

    # Escape cancels a drag
    before = wait_until_saved(page)
    page.mouse.move(*screen_point(page, *centre(pulled)))
    page.mouse.down()
    page.mouse.move(*screen_point(page, centre(pulled)[0] + 20, centre(pulled)[1]), steps=3)
    page.keyboard.press("Escape")
    page.mouse.up()
    assert wait_until_saved(page)["docs"] == before["docs"]

    # during a drag no key steps, plays or undoes
    page.mouse.move(*screen_point(page, *centre(pulled)))
    page.mouse.down()
    page.mouse.move(*screen_point(page, centre(pulled)[0] + 3, centre(pulled)[1]), steps=3)
    for pressed in ("f", " ", "Control+z", "Delete"):
        page.keyboard.press(pressed)
    page.mouse.move(*screen_point(page, *centre(pulled)), steps=3)
    held = state(page)
    assert (held["frame"], held["docs"]) == (now["frame"], before["docs"])
    assert page.evaluate("tsr.store.get().review.playing") is False
    page.keyboard.press("Escape")
    page.mouse.up()
    assert wait_until_saved(page)["docs"] == before["docs"]

    # relabel by typing, whole track
    page.keyboard.press("l")
    choose_label(page, "keep right")
    assert wait_for(page, lambda s: s["docs"].get(key, {}).get("class_id") == 38 and s["unsaved"] == 0)

    # the current label is offered first, then the engine's
    page.keyboard.press("l")
    page.locator("dialog[open] input:focus").wait_for()
    offered = page.locator("dialog[open] .label")
    assert "keep right" in offered.nth(0).inner_text()
    read = offered.nth(1).get_attribute("id")
    assert "%" in offered.nth(1).inner_text()
    page.keyboard.press("ArrowRight")
    restored = edit_and_save(page, lambda: page.keyboard.press("Enter"))
    assert f"label-{restored['docs'][key]['class_id']}" == read
    assert edit_and_save(page, lambda: page.keyboard.press("Control+z"))["docs"][key]["class_id"] == 38

    # correct a second frame, interpolate between the two
    page.keyboard.press("v")
    wait_for(page, lambda s: s["frame"] == now["frame"] + 10 and s["shown"] == s["frame"] and s["overlay"])
    assert str(now["frame"] + 10) in edit_and_save(page, lambda: page.keyboard.press("k"))["docs"][key]["keys"]
    page.keyboard.press("d")
    assert (
        edit_and_save(page, lambda: page.keyboard.press("i"))["docs"][key]["keys"][str(now["frame"])]["interpolate"]
        is True
    )

    # occluded, outside and back
    assert (
        edit_and_save(page, lambda: page.keyboard.press("q"))["docs"][key]["keys"][str(now["frame"] + 9)]["occluded"]
        is True
    )
    assert (
        edit_and_save(page, lambda: page.keyboard.press("o"))["docs"][key]["keys"][str(now["frame"] + 9)]["outside"]
        is True
    )
    assert (
        edit_and_save(page, lambda: page.keyboard.press("o"))["docs"][key]["keys"][str(now["frame"] + 9)]["outside"]
        is False
    )

    # split here, merge again
    split = edit_and_save(page, lambda: page.keyboard.press("Alt+m"))
    later = next(k for k in split["docs"] if k.startswith("h") and not split["docs"][k]["gone"])
    span = split["docs"][later]["segments"][0]
    page.get_by_role("tab", name="Inspector").click()
    page.locator(".inspector-votes", has_text="These frames alone:").wait_for()
    frames = page.evaluate(f"window.tsr.store.get().review.laneOf[{span['track']}].frame")
    own = sum(span["first"] <= frame <= span["last"] for frame in frames)
    assert 0 < own < len(frames)
    crops = page.locator(".inspector-section", has_text="Crops")
    assert crops.locator(".muted").first.text_content() == f"{own} frames"
    page.get_by_role("tab", name="Queue").click()
    select_track(page, key)
    page.keyboard.press("m")
    wait_for(page, lambda s: s["mode"] == "merge" and s["marked"] == [key])
    page.mouse.click(*screen_point(page, *centre(split["docs"][later]["keys"][str(now["frame"] + 9)]["box"])))
    wait_for(page, lambda s: s["marked"] == [key, later])
    merged = edit_and_save(page, lambda: page.keyboard.press("m"))
    assert merged["docs"][later]["merged_into"] == key

    # a drawn box becomes a track only with a label
    page.keyboard.press("0")
    for label in (None, "stop"):
        page.keyboard.press("n")
        wait_for(page, lambda s: s["mode"] == "draw")
        drag(page, (100, 120), (160, 175))
        if label is None:
            page.locator("dialog[open] input:focus").wait_for()
            page.keyboard.press("Escape")
            wait_until_no_dialog(page)
            assert wait_until_saved(page)["docs"] == merged["docs"]
        else:
            choose_label(page, label)
    drawn = wait_for(page, lambda s: s["unsaved"] == 0 and s["docs"].get(s["selected"], {}).get("class_id") == 14)
    new = drawn["selected"]
    assert drawn["docs"][new]["class_id"] == 14
    assert next(iter(drawn["docs"][new]["keys"].values()))["box"] == pytest.approx([100, 120, 160, 175], abs=3)
    assert edit_and_save(page, lambda: page.keyboard.press("Shift+Delete"))["docs"][new]["gone"] is True

    # everything is on the server, and a reload shows the same
    assert review.documents() == wait_until_saved(page)["docs"]
    again = reload_review(page)
    assert again["docs"] == review.documents()
    assert again["frame"] == now["frame"] + 9

    # undo to the beginning, and redo
    final = again["docs"]
    undone = 0
    while state(page)["undo"]:
        step = state(page)["undo"]["op_id"]
        page.keyboard.press("Control+z")
        wait_for(page, lambda s, step=step: s["unsaved"] == 0 and (s["undo"] or {}).get("op_id") != step)
        undone += 1
    assert undone >= 10
    bare = review.documents()
    assert bare[key]["keys"] == {}
    assert bare[key]["class_id"] is None
    while state(page)["redo"]:
        step = state(page)["redo"]["op_id"]
        page.keyboard.press("Control+Shift+z")
        wait_for(page, lambda s, step=step: s["unsaved"] == 0 and (s["redo"] or {}).get("op_id") != step)

    def plain(docs: dict[str, Any]) -> dict[str, Any]:
        return {k: {**d, "revision": 0} for k, d in docs.items()}

    assert plain(review.documents()) == plain(final)


RECOUNTED = """async ([run, track]) => {
  const { documentLane } = await import('/static/js/model/track_lane.js');
  const lane = await (await fetch(`/api/runs/${run}/tracks/${track}`)).json();
  const segments = [{ track, first: 0, last: lane.frame.at(-2) }];
  const again = documentLane(`m${track}`, { key: `m${track}`, segments }, { [track]: lane }).lane;
  const share = (i, id) => again.votes[i][again.classes.indexOf(id)] ?? 0; // what no frame was read as is not told
  const apart = (votes, i) => lane.classes.map((id, c) => Math.abs(votes[c] - share(i, id)));
  const all = lane.votes.slice(0, -1).flatMap((votes, i) => votes === null ? [] : apart(votes, i));
  return { classes: again.classes.length, apart: Math.max(...all) };
}"""
"""How far the votes of a track without its last frame, counted anew on the page, are from the engine's own."""


def test_the_votes_of_a_part_are_counted_as_the_engine_counts_them(review: ReviewSession, page: Page) -> None:
    found = [page.evaluate(RECOUNTED, [review.run, track]) for track in state(page)["tracks"]["id"]]
    assert max(one["classes"] for one in found) > 1, "no track of this clip was read as more than one class"
    assert all(one["apart"] < 1e-3 for one in found), found


def test_a_correction_works_by_keyboard_alone(review: ReviewSession, page: Page) -> None:
    page.keyboard.press("j")
    now = wait_for(page, lambda s: s["selected"] is not None and s["shown"] == s["frame"] and s["overlay"])
    key = now["selected"]
    for _ in range(60):  # to the picture with Tab alone
        if page.evaluate("document.activeElement && document.activeElement.classList.contains('picture-stage')"):
            break
        page.keyboard.press("Tab")
    else:
        raise AssertionError("Tab never reaches the picture")
    assert page.evaluate("document.activeElement.matches(':focus-visible')")
    select_track(page, key)
    before = review.documents().get(key, {}).get("revision", 0)
    # in one task: on a busy machine two could be a second apart, which makes two edits
    page.evaluate(
        """() => { for (const key of [{key: 'ArrowRight'}, {key: 'ArrowDown', shiftKey: true}]) {
        document.activeElement.dispatchEvent(new KeyboardEvent('keydown', {...key, bubbles: true, cancelable: true}));
        } }"""
    )
    page.keyboard.press("Alt+ArrowRight")
    # successive moves are one edit, a resize is another
    wait_for(page, lambda s: s["unsaved"] == 0 and s["docs"].get(key, {}).get("revision", 0) == before + 2)
    judged = edit_and_save(page, lambda: page.keyboard.press("a"))
    assert judged["docs"][key]["review"] == "accepted"
    edit_and_save(page, lambda: page.keyboard.press("Control+z"))
    # Tab leaves the picture after its last track: no keyboard trap
    page.locator(".picture-stage").focus()
    for _ in range(12):
        page.keyboard.press("Tab")
    assert not page.evaluate("document.activeElement.classList.contains('picture-stage')")
    page.keyboard.press("F1")
    page.locator("dialog[open]").wait_for()
    page.keyboard.press("Escape")
    wait_until_no_dialog(page)


def test_a_reload_in_the_middle_of_a_drag_changes_nothing(review: ReviewSession, page: Page) -> None:
    page.keyboard.press("j")
    now = wait_for(page, lambda s: s["selected"] is not None and s["shown"] == s["frame"] and s["overlay"])
    before = review.documents()
    x, y = centre(engine_box(now, now["selected"])) if now["selected"].startswith("m") else (100, 100)
    page.mouse.move(*screen_point(page, x, y))
    page.mouse.down()
    page.mouse.move(*screen_point(page, x + 30, y + 20), steps=4)
    reload_review(page)
    page.mouse.up()
    assert review.documents() == before
    assert state(page)["drag"] is None


def test_one_verdict_on_all_shown_tracks(review: ReviewSession, page: Page) -> None:
    before = {key: doc["review"] for key, doc in review.documents().items()}
    page.get_by_role("button", name="Bulk review …").click()
    dialog = page.get_by_role("dialog")
    judged = dialog.get_by_role("button", name=re.compile(r"^Accept \d+ tracks?$"))
    words = judged.inner_text().split()
    assert int(words[1]) > 1
    dialog.get_by_label("Maximum uncertainty, %").fill("0")
    assert int(judged.inner_text().split()[1]) < int(words[1])
    dialog.get_by_label("Maximum uncertainty, %").fill("")
    edit_and_save(page, judged.click)
    after = {key: doc["review"] for key, doc in review.documents().items()}
    changed = {key for key, verdict in after.items() if verdict != before.get(key, "open")}
    assert len(changed) == int(words[1])
    assert {after[key] for key in changed} == {"accepted"}
    edit_and_save(page, lambda: page.keyboard.press("Control+z"))
    undone = {key: doc["review"] for key, doc in review.documents().items()}
    assert all(undone[key] == before.get(key, "open") for key in undone)


def test_the_end_of_the_queue_leads_to_the_next_video(review: ReviewSession, page: Page) -> None:
    page.get_by_role("button", name="Bulk review …").click()
    edit_and_save(
        page, page.get_by_role("dialog").get_by_role("button", name=re.compile(r"^Accept \d+ tracks?$")).click
    )
    end = page.locator(".queue-end")
    expect(end.get_by_role("status")).to_have_text(
        "All tracks of this video are reviewed. No other video has an open track."
    )
    expect(end.get_by_role("button")).to_be_hidden()
    known = review.server.call("GET", "/videos")["videos"]
    other = {**known[0], "id": "a" * 64, "name": "next drive.mp4", "review": {"tracks": 12, "reviewed": 5}}
    intercept(page, re.compile(r"/api/videos$"), lambda route: route.fulfill(json={"videos": [*known, other]}))
    open_address(page, "#/")
    expect(page.get_by_role("heading", name="next drive.mp4")).to_be_visible()
    go_back(page)
    expect(end).to_contain_text("All tracks of this video are reviewed. 1 other video has 7 open tracks.")
    expect(end.get_by_role("button", name="Next video")).to_have_attribute(
        "title", "Next video with open tracks (Alt+J)"
    )
    page.locator(".picture-stage").focus()
    page.keyboard.press("Alt+j")
    page.wait_for_url(re.compile(f"#/review/{'a' * 64}/"))
    page.unroute(re.compile(r"/api/videos$"))
    open_address(page, f"#/review/{review.video}/{review.run}")
    wait_for(page, lambda s: s["run"] == review.run and s["undo"] is not None)
    edit_and_save(page, lambda: page.keyboard.press("Control+z"))
