"""The page is usable without a mouse, without colours and with hostile text. On a real server."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, expect

from sample_videos import SHIPPED
from tests.e2e.review_session import (
    ReviewSession,
    choose_label,
    edit_and_save,
    open_address,
    open_session,
    select_long_track,
    state,
    wait_for,
    wait_until_no_dialog,
    wait_until_saved,
)
from tests.e2e.scenes import SCENES, quiet
from tests.e2e.screenshots import AXE_SCRIPT, MAX_SCENE_MS, serious_violations

MARKUP = '<img src=x onerror="globalThis.hacked=1"><b>bold</b>'
NAME = "<b>drive&amp;<img src=x>.mp4"
THEME = """async (theme) => { const page = await import('/static/js/store/actions/page.js');
  tsr.store.dispatch((state) => page.setTheme(state, theme)); }"""
FOCUSED = """() => { const one = document.activeElement; const style = getComputedStyle(one);
  const place = one.getBoundingClientRect();
  const words = one.getAttribute('aria-label') || one.textContent.slice(0, 30);
  return {what: one.tagName + '.' + one.className + ' ' + words,
    page: one === document.body, stage: one.classList.contains('picture-stage'),
    seen: place.width > 0 && place.height > 0 && one.matches(':focus-visible')
      && ((style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) > 0) || style.boxShadow !== 'none')}; }"""


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ReviewSession]:
    with open_session(tmp_path_factory, SHIPPED[0].video, 120, NAME, MARKUP[:100]) as review:
        yield review


def to_picture(page: Page) -> None:
    """With Tab alone."""
    for _ in range(80):
        if page.evaluate(FOCUSED)["stage"]:
            return
        page.keyboard.press("Tab")
    raise AssertionError("Tab never reaches the picture")


def tab_to_track(page: Page, key: str) -> None:
    """With Tab, from track to track of the frame."""
    page.keyboard.press("Escape")  # nothing is selected: begin with the leftmost
    wait_for(page, lambda s: s["selected"] is None)
    for _ in range(20):
        page.keyboard.press("Tab")
        if state(page)["selected"] == key:
            return
    raise AssertionError(f"Tab never reaches {key}")


def test_the_whole_correction_without_a_mouse(review: ReviewSession, page: Page) -> None:
    to_picture(page)
    assert page.evaluate(FOCUSED)["seen"]
    now = select_long_track(page)
    key = now["selected"]
    start_at = now["tracks"]["first"][now["tracks"]["id"].index(int(key[1:]))]
    assert now["frame"] > start_at  # it opens at the clearest frame of the sign
    page.keyboard.press("b")
    now = wait_for(page, lambda s: s["frame"] == start_at and s["shown"] == s["frame"])
    page.keyboard.press("v")
    now = wait_for(page, lambda s: s["frame"] == now["frame"] + 10 and s["shown"] == s["frame"] and s["overlay"])
    at = str(now["frame"])
    start = next(list(t["box"]) for t in now["overlay"]["tracks"] if f"m{t['id']}" == key)
    # move and resize
    page.keyboard.press("Shift+ArrowRight")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Alt+ArrowRight")
    box = wait_until_saved(page)["docs"][key]["keys"][at]["box"]
    assert box == pytest.approx([start[0] + 10, start[1] + 1, start[2] + 11, start[3] + 1], abs=0.1)
    # relabel with type-ahead; the focus comes back to the picture
    page.keyboard.press("l")
    choose_label(page, "keep right")
    wait_for(page, lambda s: s["docs"][key]["class_id"] == 38 and s["unsaved"] == 0)
    assert page.evaluate(FOCUSED)["stage"]
    # another key frame, interpolation, occlusion
    page.keyboard.press("f")
    page.keyboard.press("f")
    now = wait_for(page, lambda s: s["frame"] == int(at) + 2 and s["shown"] == s["frame"])
    page.keyboard.press("k")
    page.keyboard.press("d")
    assert edit_and_save(page, lambda: page.keyboard.press("i"))["docs"][key]["keys"][at]["interpolate"] is True
    assert (
        edit_and_save(page, lambda: page.keyboard.press("q"))["docs"][key]["keys"][str(int(at) + 1)]["occluded"] is True
    )
    # split, and merge again by marking both with Enter
    split = edit_and_save(page, lambda: page.keyboard.press("Alt+m"))
    later = next(k for k, d in split["docs"].items() if k.startswith("h") and not d["gone"])
    tab_to_track(page, later)
    page.keyboard.press("m")
    wait_for(page, lambda s: s["mode"] == "merge" and s["marked"] == [later])
    page.keyboard.press("d")  # the earlier half ends one frame before
    wait_for(page, lambda s: s["frame"] == int(at) and s["shown"] == s["frame"])
    for _ in range(20):
        page.keyboard.press("Tab")
        if state(page)["selected"] == key:
            break
        if not page.evaluate(FOCUSED)["stage"]:
            to_picture(page)
    page.keyboard.press("Enter")
    wait_for(page, lambda s: s["marked"] == [later, key])
    assert edit_and_save(page, lambda: page.keyboard.press("m"))["docs"][key]["merged_into"] == later
    page.keyboard.press("Control+z")
    wait_for(page, lambda s: s["unsaved"] == 0 and not s["docs"][key]["gone"])
    # draw a new track in the middle of the view, and delete it
    new = edit_and_save(page, lambda: page.keyboard.press("Shift+n"))["selected"]
    assert new.startswith("h")
    assert edit_and_save(page, lambda: page.keyboard.press("Shift+Delete"))["docs"][new]["gone"] is True
    # verdict by key; the page shows the server's state
    tab_to_track(page, key)
    final = edit_and_save(page, lambda: page.keyboard.press("a"))
    assert final["docs"][key]["review"] == "accepted"
    assert final["docs"] == review.documents()


def test_focus_is_always_visible_and_never_trapped(page: Page) -> None:
    page.keyboard.press("Escape")
    seen = []
    for _ in range(200):
        page.keyboard.press("Tab")
        now = page.evaluate(FOCUSED)
        seen.append(now)
        if now["page"] and len(seen) > 5:
            break
    else:
        raise AssertionError(f"Tab does not come round: {[one['what'] for one in seen[-5:]]}")
    assert any(one["stage"] for one in seen)
    assert [one["what"] for one in seen if not one["page"] and not one["seen"]] == []
    for key in ("F1", "Shift+w"):
        page.locator(".picture-stage").focus()
        page.keyboard.press(key)
        page.locator("dialog[open]").wait_for()
        for _ in range(25):
            page.keyboard.press("Tab")
            assert page.evaluate(
                "() => document.activeElement === document.body || !!document.activeElement.closest('dialog')"
            )
        page.keyboard.press("Escape")
        wait_until_no_dialog(page)
        assert page.evaluate(FOCUSED)["stage"]  # back at the same place


def test_every_key_stands_in_the_tooltip_of_something_in_sight(page: Page) -> None:
    """Tab, Enter and arrows have mouse equivalents in the picture: clicks select and mark, drags move and resize."""
    wait_for(page, lambda s: s["shown"] == s["frame"])
    quiet(page)  # some buttons are there with the tracks, once they are drawn
    missing = page.evaluate(
        """async () => {
          const { allOperations } = await import('/static/js/operations/registry.js');
          const titles = [...document.querySelectorAll('button[title], input[title]')].filter((one) => {
            const place = one.getBoundingClientRect();
            const top = document.elementFromPoint(place.x + place.width / 2, place.y + place.height / 2);
            return top !== null && (one === top || one.contains(top));
          }).map((one) => one.title);
          const now = tsr.store.get();
          return allOperations().filter(({available}) => available(now))
            .filter(({keys}) => keys.length > 0 && !/^(Shift\\+)?Tab$|^Enter$|Arrow/.test(keys[0]))
            .filter(({keys}) => !titles.some((title) => title.includes(`(${keys[0]})`)))
            .map(({id, keys}) => `${id} (${keys[0]})`);
        }"""
    )
    assert missing == []


def test_a_mouse_on_the_toolbar_leaves_the_keys_to_the_picture(page: Page) -> None:
    at = wait_for(page, lambda s: s["shown"] == s["frame"])["frame"]
    for button in (page.locator("[data-operation=next-frame]"), page.locator(".legend-item").first):
        button.click()
        assert page.evaluate(FOCUSED)["stage"]
    wait_for(page, lambda s: s["frame"] == at + 1)
    page.keyboard.press("Space")  # plays, and does not press the last button once more
    page.wait_for_function("at => window.tsr.store.get().review.frame > at + 2", arg=at)
    page.keyboard.press("Space")
    page.wait_for_function("() => !window.tsr.store.get().review.playing")
    page.locator(".legend-item").first.click()


def test_a_choice_by_mouse_leaves_the_keys_to_the_picture_and_one_by_keys_does_not(page: Page) -> None:
    speed = page.get_by_label("Playing speed")
    # a native list cannot be opened without a screen: send the browser's events of a choice
    speed.dispatch_event("mousedown")
    speed.focus()
    speed.select_option(index=1)
    assert page.evaluate(FOCUSED)["stage"]
    speed.focus()
    page.keyboard.press("ArrowUp")
    speed.select_option(index=2)
    assert not page.evaluate(FOCUSED)["stage"]
    speed.select_option("1")


def test_a_button_that_is_enabled_is_readable_at_once(page: Page) -> None:
    """Its text colour changes at once; an animated background would leave grey below white for a while."""
    moving = page.evaluate(
        """() => {
          const button = document.createElement('button');
          button.className = 'btn btn-primary';
          button.disabled = true;
          document.body.append(button);
          const before = getComputedStyle(button).backgroundColor;
          button.disabled = false;
          const after = getComputedStyle(button).backgroundColor;
          const moving = button.getAnimations().length;
          button.remove();
          return [before === after, moving];
        }"""
    )
    assert moving == [False, 0]


def test_the_end_of_a_dialog_does_not_close_the_next_one(page: Page) -> None:
    page.evaluate(
        """async () => {
          const page = await import('/static/js/store/actions/page.js');
          const open = (kind) => tsr.store.dispatch((state) => page.openDialog(state, {kind, data: {}}));
          open('help');
          await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
          document.querySelector('dialog[open]').close();  // as Escape does; its event comes before the next drawing
          open('settings');
        }"""
    )
    expect(page.locator("dialog.dialog-settings")).to_be_visible()
    page.keyboard.press("Escape")
    wait_until_no_dialog(page)
    assert page.evaluate("() => tsr.store.get().dialog") is None


@pytest.mark.skipif(not AXE_SCRIPT.is_file(), reason="axe-core is not installed: npm install --no-package-lock")
def test_axe_finds_nothing_serious_on_any_screen_in_either_theme(review: ReviewSession) -> None:
    """Every rule in light; in dark those about colours, since nothing else differs."""
    tracks = review.server.call("GET", f"/runs/{review.run}/tracks")
    at = max(range(len(tracks["id"])), key=lambda i: tracks["frames"][i])
    lane = review.server.call("GET", f"/runs/{review.run}/tracks/{tracks['id'][at]}")
    rows = ["frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore"]  # a sign with boxes slightly to the right
    for frame, (x1, y1, x2, y2) in zip(lane["frame"], lane["box"], strict=True):
        aside = (x2 - x1) / 3
        rows.append(f"{frame},1,{x1 + aside},{y1},{x2 + aside},{y2},{tracks['class_id'][at]},1,0")
    truth = "\n".join(rows).encode()
    facts: dict[str, Any] = {
        "video": review.video,
        "run": review.run,
        "truth": review.server.call("PUT", f"/videos/{review.video}/ground-truths/one", body=truth, type_="text/csv")[
            "id"
        ],
        "track": f"m{tracks['id'][at]}",
        "frame": (tracks["first"][at] + tracks["last"][at]) // 2,
    }
    context = review.browser.new_context(viewport={"width": 1280, "height": 720})
    page = context.new_page()
    page.set_default_timeout(MAX_SCENE_MS)
    page.goto(review.server.link())
    page.wait_for_function("() => globalThis.tsr?.store.get().videos !== null && tsr.store.get().session !== null")
    found = []
    for scene in SCENES:
        for theme, rules in (("light", ()), ("dark", ("color-contrast", "link-in-text-block"))):
            page.evaluate(THEME, theme)
            if theme == "light":
                scene.go(page, facts)
            quiet(page)
            assert page.locator("html").get_attribute("data-theme") == theme
            found += [f"{scene.name}, {theme}: {problem}" for problem in serious_violations(page, rules)]
    context.close()
    assert found == []


def test_markup_in_names_and_notes_is_text(review: ReviewSession, page: Page) -> None:
    page.keyboard.press("j")
    key = wait_for(page, lambda s: s["selected"] is not None)["selected"]
    page.keyboard.press("p")
    page.locator("dialog[open]").wait_for()
    page.keyboard.type(MARKUP)
    page.keyboard.press("Control+Enter")
    noted = wait_for(page, lambda s: s["unsaved"] == 0 and len(s["docs"].get(key, {"notes": []})["notes"]) == 1)
    assert noted["docs"][key]["notes"][0]["text"] == MARKUP
    page.get_by_role("tab", name="Inspector").click()
    expect(page.locator(".note-text")).to_have_text(MARKUP)
    open_address(page, "#/")
    expect(page.get_by_role("heading", name=NAME)).to_be_visible()
    page.get_by_role("button", name=f"of {NAME}").first.click()
    expect(page.get_by_role("dialog")).to_contain_text(MARKUP[:40])
    assert page.evaluate("() => globalThis.hacked === undefined && !document.querySelector('img[src=x]')")
    assert page.locator("b").count() == 0


def test_a_wrong_link_or_no_token_says_what_to_do(review: ReviewSession) -> None:
    context = review.browser.new_context()
    page = context.new_page()
    page.goto(f"{review.server.base}/login/wrong")
    expect(page.get_by_role("heading", name="This link has been used")).to_be_visible()
    assert "tsr review" in page.inner_text("body")
    assert context.cookies() == []
    refused = context.request.get(f"{review.server.base}/login/wrong", headers={"Accept": "application/json"})
    assert (refused.status, refused.json()["error"]["code"]) == (401, "unauthorised")
    page.goto(f"{review.server.base}/")
    expect(page.locator("body")).to_contain_text("tsr review")
    api = context.request.get(f"{review.server.base}/api/videos", headers={"Authorization": "Bearer wrong"})
    assert api.status == 401
    assert NAME not in api.text()
    context.close()


def test_tracks_are_marked_for_a_merge_in_the_queue(review: ReviewSession, page: Page) -> None:
    page.keyboard.press("j")
    first = wait_for(page, lambda s: s["selected"] is not None and s["shown"] == s["frame"])["selected"]
    page.keyboard.press("m")
    wait_for(page, lambda s: s["mode"] == "merge" and s["marked"] == [first])
    page.keyboard.press("m")
    expect(page.get_by_text("Mark a second track first")).to_be_visible()
    expect(page.locator(".queue-marked")).to_have_count(1)
    other = page.locator(".queue-row:not(.queue-marked)").first
    second = other.get_attribute("data-key")
    other.click()
    assert wait_for(page, lambda s: len(s["marked"]) == 2)["marked"] == [first, second]
    expect(page.locator(".queue-marked")).to_have_count(2)
    page.keyboard.press("Escape")
    wait_for(page, lambda s: s["mode"] == "select" and s["marked"] == [])
