"""Scenes of the review tool: how a script brings a page to each screen and dialog."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Any, NamedTuple

from playwright.sync_api import Page, Route

from tests.e2e.interception import intercept
from tests.e2e.screenshot_views import SHOWN

DRAWN = [100, 120, 180, 200]


class Scene(NamedTuple):
    """One picture: its name and what brings the page there."""

    name: str
    go: Callable[[Page, dict[str, Any]], None]


QUIET = """() => [...document.images].every((one) => {
    const {top, bottom} = one.getBoundingClientRect();
    return one.complete || bottom <= 0 || top >= innerHeight || !one.checkVisibility();
  })
  && document.getAnimations().every((one) => one.playState !== 'running'
    || one.effect?.getComputedTiming().iterations === Infinity)"""
"""Whether nothing is loading or moving any more, except waiting views without an end."""


def quiet(page: Page) -> None:
    """Wait until the screen is stable, counted in frames of the browser and not in seconds, to suit slow machines."""
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))")
    page.wait_for_function(QUIET)


def _open(page: Page, dialog: dict[str, Any]) -> None:
    page.evaluate(
        "async dialog => { const page = await import('/static/js/store/actions/page.js');"
        " tsr.store.dispatch(state => page.openDialog(state, dialog)); }",
        dialog,
    )
    page.locator("dialog[open]").wait_for()
    quiet(page)


def _close(page: Page) -> None:
    """Close the open dialog, if any."""
    if page.locator("dialog[open]").count():
        page.keyboard.press("Escape")
        page.locator("dialog[open]").wait_for(state="detached")


def _address(page: Page, hash_: str) -> None:
    _close(page)
    page.evaluate("hash => { location.hash = hash }", hash_)


def _library(page: Page, _: dict[str, Any]) -> None:
    _address(page, "#/")
    page.locator(".card").first.wait_for()
    quiet(page)


def _review(page: Page, facts: dict[str, Any]) -> None:
    _address(page, f"#/review/{facts['video']}/{facts['run']}?frame={facts['frame']}&track={facts['track']}")
    page.wait_for_function(
        "facts => { const r = tsr.store.get().review; return r !== null && r.shown === facts.frame"
        " && r.selected === facts.track && r.overlays[r.frame] && r.laneOf[Number(facts.track.slice(1))]; }",
        arg=facts,
    )
    quiet(page)


def _tab(name: str) -> Callable[[Page, dict[str, Any]], None]:
    def go(page: Page, facts: dict[str, Any]) -> None:
        _review(page, facts)
        tab = page.get_by_role("tab", name=name)
        if tab.count():  # where there is room both stand side by side
            tab.click()
        quiet(page)

    return go


def _compare(page: Page, facts: dict[str, Any]) -> None:
    _address(page, f"#/compare?a=truth%3A{facts['truth']}&b=run%3A{facts['run']}")
    page.locator(".figures-table button").first.click()
    quiet(page)


def _truth(page: Page, facts: dict[str, Any]) -> None:
    """A place of the comparison, opened: close to the pair, the sign of the ground truth chosen."""
    _compare(page, facts)
    page.locator(".figures-table tr", has_text="Localisation error").get_by_role("button").first.click()
    page.locator(".place-error").first.click()  # the places of the number before have none
    page.locator(".truth-words:not(:empty)").wait_for()
    page.wait_for_function("() => (r => r.shown === r.frame && r.overlays[r.frame])(tsr.store.get().review)")
    quiet(page)


def _no_match(page: Page, facts: dict[str, Any]) -> None:
    _library(page, facts)
    page.get_by_role("searchbox", name="Search videos").fill("no such drive")
    page.locator(".library-notice .empty").wait_for()
    quiet(page)


def _offline(page: Page, facts: dict[str, Any]) -> None:
    _review(page, facts)
    page.evaluate(
        "async () => { const page = await import('/static/js/store/actions/page.js'); tsr.store.dispatch(state =>"
        " page.showBanner(page.setConnection(state, 'offline'), {id: 'offline', tone: 'warning',"
        " text: 'The server cannot be reached. Your changes are kept in this page.'})); }"
    )
    page.locator(".banner").wait_for()
    quiet(page)


def _conflict(facts: dict[str, Any]) -> dict[str, Any]:
    doc = {"key": facts["track"], "revision": 4, "class_id": 2, "review": "accepted", "not_a_sign": False}
    doc |= {"segments": [{"track": 1, "first": 4, "last": 90}], "keys": {}, "notes": [], "gone": False}
    doc |= {"merged_into": None}
    who = {facts["track"]: {"author": "Ann", "time": "2026-01-02T03:04:05+00:00", "name": "set_review", "frame": 4}}
    mine = {**doc, "class_id": 5, "review": "open"}
    return {"saved": [doc], "mine": [mine], "moved": [], "lost": [], "others": who}


def _broken(page: Page, _: dict[str, Any]) -> None:
    _address(page, f"#/compare?a=run%3A{'0' * 32}&b=run%3A{'1' * 32}")
    page.locator(".empty-error").wait_for()


def _screen(name: str) -> Callable[[Page, dict[str, Any]], None]:
    def go(page: Page, _: dict[str, Any]) -> None:
        _address(page, f"#/{name}")
        page.locator(".made, .model, .empty-actions").first.wait_for()
        quiet(page)

    return go


def _labels(page: Page, _: dict[str, Any]) -> None:
    _address(page, "#/labels")
    page.locator(".label-rows .label-row").first.wait_for()
    quiet(page)


def _over(kind: str, data: Callable[[dict[str, Any]], dict[str, Any]]) -> Callable[[Page, dict[str, Any]], None]:
    """A dialog over the review screen, which is opened unless it is there already."""

    def go(page: Page, facts: dict[str, Any]) -> None:
        _close(page)
        if page.evaluate("tsr.store.get().route.screen !== 'review' || tsr.store.get().review === null"):
            _review(page, facts)
        _open(page, {"kind": kind, "data": data(facts)})

    return go


def _merge(page: Page, facts: dict[str, Any]) -> None:
    """The two tracks that share most frames, about to be merged."""
    tracks = page.evaluate("tsr.store.get().review.tracks")
    spans = {f"m{i}": (a, b) for i, a, b in zip(tracks["id"], tracks["first"], tracks["last"], strict=True)}

    def shared(pair: tuple[str, str]) -> int:
        firsts, lasts = zip(*(spans[key] for key in pair), strict=True)
        return int(min(lasts) - max(firsts))

    pair = max(combinations(spans, 2), key=shared)
    _over("merge", lambda _: {"marked": [*pair]})(page, facts)


def _retrained(page: Page, facts: dict[str, Any]) -> None:
    """A version as it is after a retraining, which would take minutes: the server's list, with one more."""
    before = {"ap50": 0.7123, "recall_at_0.1": 0.81, "mean_eq7": 0.131, "signs_right": 0.9, "pictures": 64, "signs": 11}
    now = before | {"ap50": 0.7841, "recall_at_0.1": 0.835, "mean_eq7": 0.1345}
    version: dict[str, Any] = {
        "id": "0" * 32,
        "name": "Evening drives",
        "state": "complete",
        "error": None,
        "parent_id": None,
    }
    version |= {"stage": "", "done": 0, "total": None, "active": False, "models": {}}
    version |= {"created": "2026-01-05T09:00:00Z", "finished": "2026-01-05T09:07:00Z"}
    version["lineage"] = {
        "asked": {"exports": [{"name": "corrections.zip"}], "folders": {}, "seed": 4},
        "parts": ["detector", "classifier"],
        "exports": [{"names": ["country_road.mp4"], "videos": ["0" * 64], "runs": [{"edit_revision": 41}]}],
        "used": {"frames": 212, "signs": 24, "videos": ["country_road.mp4"]},
        "held_out": {"by": "sign", "signs": ["a", "b", "c"]},
    }
    version["figures"] = {
        "corrections": {"new": now, "parent": before},
        "remembered": {"new": {"crops_kept": 0.9912}, "parent": {"crops_kept": 0.9912}},
        "worse": ["Held-out corrections: localisation error rose from 0.131 to 0.1345."],
    }

    def answer(route: Route) -> None:
        listed = route.fetch()
        known = listed.json()
        route.fulfill(response=listed, json=known | {"models": [version, *known["models"]]})

    intercept(page, "**/api/models", answer)
    _screen("models")(page, facts)
    page.get_by_role("heading", name="Evening drives").wait_for()
    page.unroute("**/api/models")
    quiet(page)


def _split(page: Page, facts: dict[str, Any]) -> None:
    _over("export", lambda facts: {"runs": [facts["run"]]})(page, facts)
    page.get_by_label("Split into").check()
    quiet(page)


def _refused(page: Page, facts: dict[str, Any]) -> None:
    _over("import", lambda facts: {"video": facts["video"], "as": "truth"})(page, facts)
    broken = b"frame,track_id,x1,y1,x2,y2,class_id\n4,1,10,10,5,20,14\n"
    page.locator("#import-file").set_input_files(
        {"name": "broken.csv", "mimeType": "text/csv", "buffer": broken}  # type: ignore[arg-type]
    )
    page.get_by_role("button", name="Import", exact=True).click()
    page.locator(".import-refused:visible").wait_for()


def _beside(kind: str, ready: str) -> Callable[[Page, dict[str, Any]], None]:
    def go(page: Page, facts: dict[str, Any]) -> None:
        _review(page, facts)
        if page.locator(".beside:visible").count():
            page.get_by_role("button", name="Close this view").click()
        page.locator(f"[data-operation={kind}-view]").click()
        page.locator(f".beside {ready}").first.wait_for()
        quiet(page)

    return go


def _with_review(show: Callable[[Page], None]) -> Callable[[Page, dict[str, Any]], None]:
    def go(page: Page, facts: dict[str, Any]) -> None:
        _review(page, facts)
        if page.locator(".beside:visible").count():
            page.get_by_role("button", name="Close this view").click()
        show(page)

    return go


SCENES = (
    Scene("library", _library),
    Scene("library-no-match", _no_match),
    Scene("review-queue", _tab("Queue")),
    Scene("review-inspector", _tab("Inspector")),
    Scene("runs", _over("run", lambda facts: {"video": facts["video"]})),
    Scene("add-video", _over("add-video", lambda _: {})),
    Scene("relabel", _over("relabel", lambda facts: {"key": facts["track"], "frame": facts["frame"]})),
    Scene("drawn-box", _over("relabel", lambda facts: {"draft": {"key": "h1", "frame": facts["frame"], "box": DRAWN}})),
    Scene("judge", _over("bulk-review", lambda _: {})),
    Scene("note", _over("note", lambda facts: {"key": facts["track"], "frame": facts["frame"]})),
    Scene("what-if", _over("whatif", lambda facts: {"run": facts["run"]})),
    Scene("compare-choose", _over("compare", lambda facts: {"video": facts["video"], "run": facts["run"]})),
    Scene("second-run", _over("second", lambda _: {})),
    Scene("conflict", _over("conflict", _conflict)),
    Scene("help", _over("help", lambda _: {})),
    Scene("palette", _over("palette", lambda _: {})),
    Scene("merge", _merge),
    Scene("export", _split),
    Scene("import", _over("import", lambda facts: {"video": facts["video"]})),
    Scene("import-refused", _refused),
    Scene("ground-truths", _over("ground-truths", lambda facts: {"video": facts["video"]})),
    Scene("record", _over("record", lambda _: {})),
    Scene("report-bug", _over("bundle", lambda _: {})),
    Scene("open-bug-bundle", _over("import-bundle", lambda _: {})),
    Scene("retrain", _over("retrain", lambda _: {})),
    Scene("preferences", _over("settings", lambda _: {})),
    Scene("review-recording", _beside("recording", ".empty")),
    Scene("files", _screen("files")),
    Scene("models", _retrained),
    Scene("labels", _labels),
    Scene("compare", _compare),
    Scene("review-truth", _truth),
    Scene("compare-error", _broken),
    Scene("offline", _offline),  # leaves the page offline, so it is the last
)
VIEWS = tuple(Scene(name, _with_review(show)) for name, show in SHOWN.items())
"""Scenes that are only for people, because they take a while."""
