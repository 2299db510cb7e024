"""Overlays and controls beside the picture: layers, the camera's focus, another tau."""

from __future__ import annotations

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Page, expect

from tests.e2e.review_session import ReviewSession, choose_label, drag, open_address, reload_review, state, wait_for

YELLOW = """focus => { const {review} = tsr.store.get(); const canvas = document.querySelector('.picture-layers');
  const view = review.viewport, ratio = canvas.width / canvas.clientWidth, size = Math.round(14 * ratio);
  const x = (focus.x * review.video.width - view.x) * view.zoom + canvas.clientWidth / 2;
  const y = (focus.y * review.video.height - view.y) * view.zoom + canvas.clientHeight / 2;
  const {data} = canvas.getContext('2d').getImageData(x * ratio - size / 2, y * ratio - size / 2, size, size);
  let found = 0;
  for (let i = 0; i < data.length; i += 4) found += data[i] > 180 && data[i + 1] > 160 && data[i + 2] < 130;
  return found; }"""
"""Pixels in the colour of predictions around the focus of expansion."""


def test_layers_are_as_they_were_left_and_playing_begins_anew_at_the_end(review: ReviewSession, page: Page) -> None:
    shown = "Object.entries(tsr.store.get().review.layers).filter(([, on]) => on).map(([name]) => name)"
    before = page.evaluate(shown)
    page.keyboard.press("7")
    page.keyboard.press("2")
    expected = [name for name in [*before, "truth"] if name != "predictions"]
    assert sorted(page.evaluate(shown)) == sorted(expected)
    reload_review(page)
    assert sorted(page.evaluate(shown)) == sorted(expected)
    page.keyboard.press("End")
    last = wait_for(page, lambda s: s["frame"] > 0 and s["shown"] == s["frame"])["frame"]
    page.keyboard.press("Space")
    wait_for(page, lambda s: 0 < s["frame"] < last)
    page.keyboard.press("Space")


def test_where_the_camera_looks_is_drawn_for_a_predicted_sign(review: ReviewSession, page: Page) -> None:
    focus = review.server.call("GET", f"/runs/{review.run}")["summary"]["focus"]
    assert focus["named"] is False
    tracks = review.server.call("GET", f"/runs/{review.run}/tracks")
    lanes = [review.server.call("GET", f"/runs/{review.run}/tracks/{track}") for track in tracks["id"]]
    seen, unseen = (
        next((lane["id"], lane["frame"][i]) for lane in lanes for i in range(5, len(lane["frame"])) if test(lane, i))
        for test in (lambda lane, i: lane["source"][i] == 0, lambda lane, i: lane["source"][i] == 1)
    )
    for (track, frame), drawn in ((unseen, True), (seen, False)):
        open_address(page, f"#/review/{review.video}/{review.run}?frame={frame}&track=m{track}")
        wait_for(
            page, lambda s, f=frame, t=f"m{track}": s["shown"] == f and s["selected"] == t and s["overlay"] is not None
        )  # type: ignore[misc]
        if drawn:
            page.wait_for_function(f"focus => ({YELLOW})(focus) > 10", arg=focus)
        else:
            page.wait_for_function(f"focus => ({YELLOW})(focus) === 0", arg=focus)
    page.get_by_role("tab", name="Inspector").click()
    page.get_by_text("Run: parameters and models").click()
    expect(page.locator(".inspector-run")).to_contain_text(f"{focus['y']:.3f} of the height, estimated from the drive")


def test_another_tau_leads_from_track_to_track_that_it_would_change(review: ReviewSession, page: Page) -> None:
    page.keyboard.press("j")
    wait_for(page, lambda s: s["selected"] is not None and s["shown"] == s["frame"])
    reported = page.locator(".lanes-drive-flips")
    slider = page.get_by_role("slider", name="tau, the threshold of the gate")
    expect(reported).to_be_hidden()
    slider.press("Home")
    for _ in range(12):
        slider.press("PageDown")
    tau = float(page.evaluate("tsr.store.get().review.tau"))
    found = review.server.call("GET", f"/runs/{review.run}/flips?tau={tau}")
    places = sorted((track["frame"], track["id"]) for track in found["tracks"])
    assert found["to_confident"] == 0 < found["to_rejected"]
    assert len(places) > 1
    expect(reported).to_have_text(f"Drive: {found['to_rejected']:,} verdicts flip in {len(places)} tracks")
    seen = []
    for _ in places:
        now = state(page)
        before = (now["selected"], now["frame"])
        reported.click()
        now = wait_for(page, lambda s, b=before: (s["selected"], s["frame"]) != b and s["shown"] == s["frame"])  # type: ignore[misc]
        seen.append(now["frame"])
    assert sorted(seen) == [frame for frame, _ in places]
    expect(page.locator(".lanes-flipping")).to_be_visible()
    page.get_by_role("button", name="Reset").click()
    expect(reported).to_be_hidden()


def test_there_is_no_tau_to_reset_before_one_was_dragged(page: Page) -> None:
    page.keyboard.press("n")
    wait_for(page, lambda s: s["mode"] == "draw")
    drag(page, (100, 120), (160, 175))
    choose_label(page, "stop")
    wait_for(page, lambda s: (s["selected"] or "").startswith("h") and s["unsaved"] == 0)
    expect(page.get_by_text("the engine has no values of it")).to_be_visible()
    expect(page.get_by_role("button", name="Reset")).to_be_hidden()
