"""Second opinions in a real browser: assigned, answered without the first answer, reported with intervals."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import expect

from tests.e2e.review_session import ReviewSession, open_address, state, wait_for, without_errors
from tests.e2e.test_team_workflow import people, signed_in


def test_a_second_opinion_is_asked_for_given_and_counted(review: ReviewSession) -> None:
    home = review.server.home
    links = {
        name: json.loads(people(home, "add", name, "--role", role, "--url", review.server.base, "--json"))["link"]
        for name, role in (("Adam", "admin"), ("Rolf", "reviewer"), ("Anna", "annotator"))
    }
    with (
        without_errors(signed_in(review.browser, links["Rolf"])) as rolf,
        without_errors(signed_in(review.browser, links["Anna"])) as anna,
    ):
        open_address(rolf, f"#/review/{review.video}/{review.run}")
        wait_for(rolf, lambda s: s["tracks"] is not None and s["overlay"] is not None)
        key = f"m{state(rolf)['tracks']['id'][0]}"
        open_address(rolf, f"#/review/{review.video}/{review.run}?track={key}")
        wait_for(rolf, lambda s: s["selected"] == key)
        rolf.keyboard.press("a")
        wait_for(rolf, lambda s: s["docs"].get(key, {}).get("review") == "accepted" and s["unsaved"] == 0)

        rolf.get_by_role("link", name="Team").click()
        region = rolf.get_by_role("region", name="Second opinions")
        expect(region).to_contain_text("No accepted track has a second opinion")
        region.get_by_label("Person").select_option("Anna")
        region.get_by_label("Share of the accepted tracks").fill("100")
        region.get_by_role("button", name="Assign").click()
        expect(rolf.get_by_role("region", name="Second opinions")).to_contain_text("1 open")
        expect(rolf.get_by_role("status", name="Notices")).to_contain_text("1 track is assigned to Anna.")

        anna.get_by_role("link", name="Anna").click()
        mine = anna.get_by_role("region", name="Second opinion")
        expect(mine).to_contain_text("1 sign left")
        expect(mine.get_by_role("img", name="The sign")).to_be_visible()
        anna.wait_for_function("() => document.querySelector('.second-opinion-picture').naturalWidth > 0")
        mine.get_by_label("Label of the sign").fill("unicorn")
        mine.get_by_role("button", name="Confirm").click()
        expect(mine.get_by_role("alert")).to_contain_text("Choose one of the labels")
        mine.get_by_role("button", name="No sign").click()
        expect(mine).to_contain_text("every sign that was assigned to you")

        rolf.reload()
        told = rolf.get_by_role("region", name="Second opinions")
        expect(told).to_contain_text("0 of 1 track: 0 % (0 % to 79.3 %)")
        expect(told.get_by_role("list", name="Tracks in dispute")).to_contain_text("Anna: no sign")
        told.get_by_role("list", name="Tracks in dispute").get_by_role("link").click()
        wait_for(rolf, lambda s: s["selected"] == key)
