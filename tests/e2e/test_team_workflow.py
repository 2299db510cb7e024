"""A team in a real browser: sign-in, assignments, hand-in, return, authors of changes, sign-out."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Browser, Page, expect

from tests.e2e.review_session import ReviewSession, open_address, state, wait_for, without_errors
from tests.forked_program import ForkedProgram

LAST_SIGN_IN = re.compile(r"/sign-in#?$")


def people(home: Path, *words: str) -> str:
    """Run ``tsr people`` beside the running server; returns its output."""
    said = home / "people.txt"
    assert (
        ForkedProgram("tests.e2e.forked_server:run_to_file", [str(said), "people", *words, "--home", str(home)]).wait(
            300
        )
        == 0
    )
    return said.read_text()


def signed_in(browser: Browser, link: str) -> Page:
    """The library of a person who opens a sign-in link, in a separate browser."""
    page = browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
    page.goto(link)
    expect(page.locator(".card")).to_have_count(1)
    assert "tsr_" not in page.url
    return page


def test_a_team_works_on_a_video(review: ReviewSession) -> None:
    home = review.server.home
    alone = review.page()
    expect(alone.get_by_role("link", name="Team")).to_be_hidden()
    links = {
        name: json.loads(people(home, "add", name, "--role", role, "--url", review.server.base, "--json"))
        for name, role in (("Adam", "admin"), ("Rolf", "reviewer"), ("Anna", "annotator"), ("Vera", "viewer"))
    }
    # the single user must sign in from now on
    expect(alone.locator(".banner-error")).to_contain_text("signed out")
    alone.get_by_role("button", name="Sign in").click()
    expect(alone.get_by_label("Your token")).to_be_visible()
    late = review.browser.new_page()
    late.route("**/sign_in.js", lambda route: route.abort())
    late.goto(f"{review.server.base}/sign-in")
    late.get_by_label("Your token").fill("tsr_early")
    late.keyboard.press("Enter")
    expect(late.get_by_role("button", name="Sign in")).to_be_disabled()
    assert "tsr_early" not in late.url
    late.close()
    alone.get_by_label("Your token").fill("tsr_wrong")
    alone.get_by_role("button", name="Sign in").click()
    expect(alone.get_by_role("alert")).to_contain_text("wrong or has been revoked")
    alone.get_by_label("Your token").fill(links["Adam"]["token"])
    alone.get_by_role("button", name="Sign in").click()
    expect(alone.get_by_role("link", name="Adam")).to_be_visible()
    wait_for(alone, lambda s: s["run"] == review.run)  # back at the same place
    alone.context.close()

    with (
        without_errors(signed_in(review.browser, links["Rolf"]["link"])) as rolf,
        without_errors(signed_in(review.browser, links["Anna"]["link"])) as anna,
    ):
        rolf.get_by_role("button", name="Assign drive.mp4").click()
        rolf.get_by_label("To", exact=True).select_option("Anna")
        rolf.get_by_label("Instructions").fill("The far signs first.")
        rolf.get_by_role("button", name="Assign", exact=True).click()
        expect(rolf.locator(".card-assigned")).to_contain_text("Anna: To do")

        anna.get_by_role("region", name="My work").get_by_role("link").click()
        strip = anna.get_by_role("region", name="Assignment")
        expect(strip).to_contain_text("“The far signs first.”")
        wait_for(anna, lambda s: s["tracks"] is not None and s["overlay"] is not None)
        key = f"m{state(anna)['tracks']['id'][0]}"
        open_address(anna, f"#/review/{review.video}/{review.run}?track={key}")
        wait_for(anna, lambda s: s["selected"] == key)
        anna.keyboard.press("w")
        wait_for(anna, lambda s: s["docs"].get(key, {}).get("review") == "needs_work" and s["unsaved"] == 0)
        open_address(anna, f"#/review/{review.video}/{review.run}?track={key}&frame=0")
        wait_for(anna, lambda s: s["selected"] == key)
        anna.get_by_role("tab", name="Inspector").click()
        anna.locator(".inspector-history summary").click()
        newest = anna.locator(".history li").first
        expect(newest).to_contain_text("Anna")
        expect(newest).to_contain_text("→ needs work")
        compare, saved = (anna.locator(one).bounding_box() for one in (".topbar-chooser > :last-child", ".saved"))
        assert compare
        assert saved
        assert compare["x"] + compare["width"] <= saved["x"]
        strip.get_by_role("button", name="Hand in").click()
        expect(strip).to_contain_text("In review")

        expect(rolf.get_by_role("region", name="My work")).to_contain_text("To review")  # the page is notified
        rolf.keyboard.press("Alt+Shift+J")
        theirs = rolf.get_by_role("region", name="Assignment")
        expect(theirs).to_contain_text("Work of Anna")
        wait_for(rolf, lambda s: s["tracks"] is not None)
        theirs.get_by_role("button", name="Return …").click()
        rolf.get_by_label("What to do again").fill("Track 1 lacks a box.")
        rolf.get_by_role("button", name="Return", exact=True).click()
        expect(strip).to_contain_text("“Track 1 lacks a box.”")
        strip.get_by_role("button", name="Hand in").click()
        expect(strip).to_contain_text("In review")
        theirs.get_by_role("button", name="Done").click()
        expect(strip).to_be_hidden()

        rolf.get_by_role("link", name="Models").click()
        expect(rolf.get_by_role("listitem").filter(has_text="Shipped")).to_be_visible()
        expect(rolf.get_by_role("button", name="Retrain")).to_be_hidden()
        rolf.get_by_role("link", name="Team").click()
        expect(rolf.locator(".team-table")).to_contain_text("annotator")
        rolf.get_by_role("link", name="Anna").click()
        expect(rolf.locator(".activity li").first).to_contain_text("drive.mp4")

        # a viewer sees everything and changes nothing
        with without_errors(signed_in(review.browser, links["Vera"]["link"])) as vera:
            open_address(vera, f"#/review/{review.video}/{review.run}?track={key}")
            wait_for(vera, lambda s: s["selected"] == key and s["docs"].get(key, {}).get("review") == "needs_work")
            vera.keyboard.press("x")
            expect(vera.locator(".toast")).to_contain_text("You are a viewer here")
            assert state(vera)["docs"][key]["review"] == "needs_work"

        people(home, "revoke", "Anna")
        expect(anna.locator(".banner-error")).to_contain_text("signed out")
        expect(anna.locator(".banner")).to_have_count(1)  # the server is reachable
        rolf.get_by_role("button", name="Sign out").click()
        rolf.wait_for_url(LAST_SIGN_IN)
        rolf.goto(f"{review.server.base}/#/team")
        expect(rolf.get_by_label("Your token")).to_be_visible()
