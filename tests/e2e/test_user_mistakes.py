"""A person's mistakes in a real browser change nothing unintended and lose nothing."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, expect

from sample_videos import SHIPPED
from tests.e2e.interception import intercept
from tests.e2e.review_session import (
    ReviewSession,
    go_back,
    import_tracks,
    open_address,
    open_session,
    reload_review,
    state,
    wait_for,
    wait_until_no_dialog,
    wait_until_saved,
)

FRAMES = 120
MAX_WORK_MS = 240_000
"""Patience with the engine on a slow machine, ms."""


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ReviewSession]:
    with open_session(tmp_path_factory, SHIPPED[0].video, FRAMES, run="First") as review:
        yield review


@pytest.fixture(scope="module")
def other(review: ReviewSession) -> str:
    """Another run of the same video, an imported one: its first track has the same name."""
    run = import_tracks(review.server, review.video, SHIPPED[0].truth.read_bytes(), "Second")
    return str(run["id"])


def select(page: Page, place: int) -> str:
    """Select a track and go to its clearest frame; returns its key."""
    key = "m" + str(state(page)["tracks"]["id"][place])
    page.evaluate(
        """async (key) => { const { openTrack } = await import('/static/js/operations/navigate.js');
           openTrack({ store: tsr.store }, key); }""",
        key,
    )
    wait_for(page, lambda s: s["selected"] == key and s["shown"] == s["frame"] and s["overlay"])
    return key


def test_a_dialog_does_not_outlive_the_run_that_it_asks_about(review: ReviewSession, other: str, page: Page) -> None:
    before = review.documents()
    open_address(page, f"#/review/{review.video}/{other}?frame=0")
    wait_for(page, lambda s: s["run"] == other and s["tracks"] is not None and s["shown"] == s["frame"])
    select(page, 0)
    page.keyboard.press("l")
    page.locator("dialog[open] input:focus").wait_for()
    go_back(page)
    wait_for(page, lambda s: s["run"] == review.run and s["tracks"] is not None)
    wait_until_no_dialog(page)
    page.keyboard.type("give")
    page.keyboard.press("Enter")
    wait_until_saved(page)
    assert review.documents() == before


def test_a_dialog_stays_where_only_the_frame_changes(page: Page) -> None:
    key = select(page, 0)
    page.keyboard.press("l")
    page.locator("dialog[open] input:focus").wait_for()
    place = page.evaluate("location.hash.split('?')[0]")
    open_address(page, f"{place}?frame=1&track={key}")
    wait_for(page, lambda s: s["frame"] == 1 and s["selected"] == key)
    expect(page.locator("dialog[open]")).to_have_count(1)


def test_what_is_typed_before_a_dialog_is_drawn_is_typed_into_it(page: Page) -> None:
    key = select(page, 0)
    page.evaluate("globalThis.requestAnimationFrame = (draw) => setTimeout(draw, 3000)")  # a slow page
    page.keyboard.type("lstop")  # T, O and P are commands of the picture
    page.keyboard.press("Enter")
    wait_for(page, lambda s: s["unsaved"] == 0 and s["docs"].get(key, {}).get("class_id") == 14)
    wait_until_no_dialog(page)
    page.keyboard.press("Control+z")
    wait_for(page, lambda s: s["unsaved"] == 0 and s["docs"][key]["class_id"] is None)


@pytest.mark.parametrize("field", ["Search tracks", "Frame"])
def test_undo_in_a_field_takes_back_what_was_typed_not_what_was_corrected(page: Page, field: str) -> None:
    key = select(page, 0)
    page.keyboard.press("w")
    wait_until_saved(page)
    made = wait_for(page, lambda s: (s["undo"] or {}).get("keys") == [key])["undo"]["op_id"]
    text = page.get_by_role("searchbox" if field.startswith("Search") else "textbox", name=field, exact=True)
    text.focus()
    page.keyboard.type("12")
    for keys in ("Control+y", "Control+Shift+z", "Control+z"):
        page.keyboard.press(keys)
    page.keyboard.press("Control+s")  # without text: the page's undo
    expect(page.get_by_text("Everything is saved.")).to_be_visible()
    now = wait_until_saved(page)
    assert now["undo"]["op_id"] == made
    assert now["docs"][key]["review"] == "needs_work"
    page.locator(".picture-stage").focus()
    page.keyboard.press("Control+z")
    wait_for(page, lambda s: s["unsaved"] == 0 and s["docs"][key]["review"] == "open")


def test_a_half_written_note_stays_with_its_track(review: ReviewSession, page: Page) -> None:
    page.get_by_role("tab", name="Inspector").click()
    first = select(page, 0)
    note = page.get_by_role("textbox", name="Note on the current frame")
    note.fill("of the first")
    second = select(page, 1)
    expect(note).to_have_value("")
    note.fill("of the second")
    pin = page.get_by_role("button", name="Pin to track")
    expect(pin).to_contain_text(f"#{second[1:]}, frame {state(page)['frame']}")
    page.locator(".picture-stage").focus()
    select(page, 0)
    expect(note).to_have_value("of the first")
    page.wait_for_url(re.compile(f"track={first}$"))  # the URL is updated a moment later
    assert reload_review(page)["selected"] == first
    expect(note).to_have_value("of the first")
    # the dialog continues with it, and Escape keeps it
    page.keyboard.press("p")
    asked = page.locator("dialog textarea")
    expect(asked).to_have_value("of the first")
    asked.press("End")
    page.keyboard.type(" one")
    page.keyboard.press("Escape")
    wait_until_no_dialog(page)
    expect(note).to_have_value("of the first one")
    pin.click()
    now = wait_for(page, lambda s: s["unsaved"] == 0 and first in s["docs"])
    assert [one["text"] for one in now["docs"][first]["notes"]] == ["of the first one"]
    expect(note).to_have_value("")
    select(page, 1)
    expect(note).to_have_value("of the second")
    assert review.documents().get(second, {"notes": []})["notes"] == []


def test_what_m_marks_is_named(page: Page) -> None:
    first = select(page, 0)
    hint = page.locator(".picture-hint")
    page.keyboard.press("m")
    expect(hint).to_contain_text(f"Track #{first[1:]} is marked")
    row = page.locator(f"#queue-{first}")
    expect(row).to_contain_text("to merge")
    row.click()  # already marked: unmark
    expect(hint).to_have_text("Click the tracks to merge, then press M. Escape ends.")
    expect(row).not_to_contain_text("to merge")
    row.click()
    expect(page.locator(".queue-marked")).to_have_count(1)
    other = page.locator(".queue-row:not(.queue-marked)").first
    second = str(other.get_attribute("data-key"))
    other.click()
    expect(hint).to_contain_text(f"Tracks #{first[1:]}, #{second[1:]} are marked")
    page.keyboard.press("Escape")


def test_a_replay_that_lacks_pixels_says_so_before_and_after(page: Page) -> None:
    page.keyboard.press("Shift+w")
    dialog = page.locator("dialog[open]")
    dialog.get_by_label("Search parameters").fill("search_radius")
    field = dialog.get_by_label("search_radius", exact=True)
    field.fill("40")
    expect(dialog.get_by_text("not exact")).to_have_count(0)
    field.fill("100")
    expect(dialog.locator("[id$=search_radius-warning]")).to_contain_text("stored pixels up to 40 px")
    dialog.get_by_role("button", name="Replay").click()
    reported = re.compile(r"Not exact: [\d,]+ pixels? in \d+ frames?")
    expect(dialog.locator(".whatif-result")).to_contain_text(reported, timeout=MAX_WORK_MS)
    dialog.get_by_role("link", name="Compare in figures").click()
    expect(page.get_by_role("region", name="Candidate")).to_contain_text(reported)
    expect(page.get_by_role("region", name="Reference")).not_to_contain_text(reported)
    go_back(page)
    page.get_by_role("button", name="Runs").click()
    item = page.locator("dialog[open] .run-item").filter(has_text="search_radius = 100")
    expect(item).to_contain_text(reported)


def test_an_empty_review_says_what_became_of_its_run(page: Page) -> None:
    shown = """([state, error]) => tsr.store.dispatch((s) => ({...s, review: {...s.review, selected: null, docs: {},
        tracks: {...s.review.tracks, id: []}, run: {...s.review.run, state, error}}}))"""
    places = page.locator(".no-tracks")
    page.evaluate(shown, ["complete", None])
    expect(places).to_have_text(["The run has found no sign. N draws a track by hand."] * 2, use_inner_text=True)
    page.evaluate(shown, ["failed", "Frame 7 cannot be decoded."])
    expect(places).to_contain_text(["The run failed: Frame 7 cannot be decoded."] * 2)
    intercept(page, "**/resume", lambda route: route.abort())
    with page.expect_request("**/resume") as asked:
        page.get_by_role("button", name="Resume the run").last.click()
    assert asked.value.url.split("/")[-2] == state(page)["run"]
    page.evaluate("() => tsr.store.dispatch((s) => ({...s, review: {...s.review, run: null, tracks: null}}))")
    expect(places).to_contain_text(["No run yet: start one with “Runs”."] * 2)
    expect(page.locator(".queue-counts")).to_have_text("")
    page.get_by_role("button", name="Run the engine").first.click()
    expect(page.locator("dialog[open]").get_by_role("heading", name="Runs", exact=True)).to_be_visible()


def test_a_deleted_track_comes_back_by_its_notice_which_goes_with_the_next_edit(page: Page) -> None:
    first = select(page, 0)
    page.keyboard.press("Shift+Delete")
    notice = page.locator(".toast").filter(has_text=f"Track #{first[1:]} is deleted")
    notice.hover()  # it stays under the pointer
    box, picture = notice.bounding_box(), page.locator(".picture-stage").bounding_box()
    assert box is not None
    assert picture is not None
    for low, size in (("x", "width"), ("y", "height")):
        assert picture[low] <= box[low]
        assert box[low] + box[size] <= picture[low] + picture[size]
    notice.get_by_role("button", name="Undo").click()
    wait_for(page, lambda s: s["unsaved"] == 0 and not s["docs"][first]["gone"])
    expect(notice).to_have_count(0)
    undone = page.locator(".toast").filter(has_text="Undone: track deleted")
    undone.hover()
    select(page, 1)
    expect(undone).to_be_visible()  # navigation is not an edit
    page.keyboard.press("w")
    expect(undone).to_have_count(0)
    wait_until_saved(page)
    page.keyboard.press("Control+z")


def test_a_notice_does_not_follow_to_another_screen_but_a_failure_does(page: Page) -> None:
    say = """async ([text, tone]) => { const { toast } = await import('/static/js/core/toast.js');
        toast(text, {tone}); }"""
    page.evaluate(say, ["Just done.", "good"])
    page.evaluate(say, ["It went wrong.", "bad"])
    expect(page.locator(".toast")).to_have_count(2)
    page.get_by_role("link", name="Library", exact=True).click()
    expect(page.locator(".toast")).to_have_text(["It went wrong."])
    page.evaluate(say, ["The run was removed.", "good"])
    bar, notice = page.locator(".topbar").bounding_box(), page.locator(".toast").first.bounding_box()
    assert bar is not None
    assert notice is not None
    assert notice["y"] < bar["y"] + bar["height"]


def test_the_layer_of_the_second_run_asks_which_one(other: str, page: Page) -> None:
    layer = "() => tsr.store.get().review.layers.second"
    chip = page.locator(".legend-item", has_text="Second run")
    expect(chip).to_have_attribute("aria-pressed", "false")
    page.keyboard.press("8")
    dialog = page.locator("dialog[open]")
    dialog.get_by_role("radio", name="Second ·").check()
    page.keyboard.press("Enter")
    expect(dialog).to_have_count(0)
    wait_for(page, lambda s: s["second"] == other)
    assert page.evaluate(layer) is True
    expect(chip).to_have_attribute("aria-pressed", "true")
    expect(chip).to_have_attribute("title", re.compile(r"^Second run: Second · .* \(8\)$"))
    expect(chip).to_contain_text(re.compile(r"[1-9]$"))
    page.locator(".picture-stage").focus()
    page.keyboard.press("8")  # now there is something to hide
    expect(dialog).to_have_count(0)
    assert page.evaluate(layer) is False
    page.get_by_role("button", name="Choose the second run").click()
    dialog.get_by_role("radio", name="None").check()
    dialog.get_by_role("button", name="Show").click()
    wait_for(page, lambda s: s["second"] is None)
