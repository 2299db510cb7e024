"""Simulates an annotator who knows the ground truth: presses keys and drags boxes on the real page, and counts actions.

An action is a key press that is a command, a click, or a drag. The key that opens an input is one action; the name or
number typed there, with Enter, is another. Times are those of the page, without a person's time to think.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from benchmarks.review.faulty_runs import Case
from tsr_engine.json_shapes import JsonObject

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from tsr_engine.records import FloatArray

Proposals = list[tuple[int, list[float]]]
"""Pairs of frame and accepted box, px edges."""

_STATE = """() => { const r = tsr.store.get().review; return { frame: r.frame, shown: r.shown, selected: r.selected,
  unsaved: r.unsaved.length, mode: r.mode, dialog: tsr.store.get().dialog?.kind ?? null,
  following: r.following ? !['queued', 'running'].includes(r.following.state) : null,
  ready: r.shown === r.frame && Boolean(r.overlays[r.frame]),
  judged: Object.fromEntries(Object.values(r.docs).map((d) => [d.key, d.gone ? 'deleted' : d.review])),
  ends: Object.fromEntries(Object.values(r.docs).map((d) => [d.key, Math.max(...d.segments.map((part) => part.last))])),
  view: r.viewport }; }"""
_PROPOSED = "() => Object.entries(tsr.store.get().review.following.proposals).map(([k, p]) => [Number(k), p.box])"
_OPERATIONS = """async () => (await import('/static/js/operations/registry.js')).allOperations().map((one) => one.id)"""
_TIMEOUT_S = 600.0
"""Largest time of the page for one step on a busy machine, s; following may have to start a worker."""
_DRAG_PX_PER_FRAME = 3
"""Distance to drag the end of a bar for one frame, px, unless the page needs more."""


@dataclass(slots=True)
class Work:
    """The work on one track.

    Attributes:
        kind: fault of the track, see ``faulty_runs.KINDS``.
        actions: the actions, in order.
        seconds: time until the page was ready for the next track.
    """

    kind: str
    actions: list[str] = field(default_factory=list)
    seconds: float = 0.0


class SimulatedAnnotator:
    """Works through all tracks of one run.

    Args:
        page: the review screen, ready.
        cases: cases by the number of the run's track; missed signs have negative numbers.
        names: label id -> its name.
    """

    def __init__(self, page: Page, cases: dict[int, Case], names: dict[int, str]) -> None:
        self._page = page
        self._cases = cases
        self._names = names
        self._work = Work("")
        # Versions of the page differ in their operations, and in whether the end of a bar can be dragged.
        known = page.evaluate(_OPERATIONS)
        self._follows = "follow" in known
        self._accepts = "end-here" in known
        self._trims = page.locator(".lanes-end").count() == 1

    def work_through(self) -> list[Work]:
        """Work on all tracks of the queue, then on the missed signs; returns the work on each."""
        done: list[Work] = []
        left = {number for number in self._cases if number >= 0}
        if self._trims:  # this page opens the first track by itself
            self._wait_for_next(None)
        while left:
            self._work, began = Work(""), time.monotonic()
            now = self._state()
            if self._track_number(now["selected"]) not in left:
                self._key("j")
                now = self._wait_for_next(now["selected"])
            number = self._track_number(now["selected"])
            assert number is not None, "a run that was brought in has engine tracks alone"
            left.remove(number)
            self._correct(now["selected"], self._cases[number], last=not left)
            done.append(self._finished(self._cases[number].kind, began))
        for case in (case for number, case in self._cases.items() if number < 0):
            self._work, began = Work(""), time.monotonic()
            self._add_missed_sign(case)
            done.append(self._finished(case.kind, began))
        return done

    def extend_tracks_back(self) -> Iterator[tuple[int, Work, Proposals]]:
        """Follow each track back to its sign's first frame; yields its number, the work, and accepted boxes."""
        for _ in self._cases:
            self._work, began = Work(""), time.monotonic()
            before = self._state()["selected"]
            self._key("j")
            number = self._track_number(self._wait_for_next(before)["selected"])
            assert number is not None, "a run that was brought in has engine tracks alone"
            self._key(",")
            taken = self._accept_proposals()
            yield number, self._finished("late", began), taken

    def draw_missed(self, number: int) -> tuple[Work, Proposals]:
        """Draw a missed sign in the shown frame and follow it; returns the work and the accepted boxes."""
        self._work, began = Work(""), time.monotonic()
        frame = self._wait(lambda s: s["ready"])["frame"]
        self._draw_and_label(self._cases[number], frame)
        taken = self._accept_proposals()
        return self._finished("missed", began), taken

    # ------------------------------------------------------------------------------------------------- one track

    def _correct(self, key: str, case: Case, *, last: bool) -> None:
        if case.kind == "false":
            self._decide("x", key, last=last)
            return
        if "label" in case.faults and not self._accepts:
            self._key("l")
            self._label(case)
        if "box" in case.faults:
            self._go_to_frame(case.box_frame)
            self._drag(case.wrong_box, case.truth[case.box_frame])
        if "end" in case.faults:
            if self._trims:
                self._trim(key, case.last)
            elif self._accepts:
                self._go_to_frame(case.last)
                self._key("Alt+Delete")
            else:
                self._go_to_frame(case.last + 1)
                self._key("Delete")
        if "label" in case.faults and self._accepts:
            self._key("l")
            self._label(case, accepts=True)
            self._wait_for_verdict("accepted", key, last=last)
        else:
            self._decide("a", key, last=last)

    def _decide(self, letter: str, key: str, *, last: bool) -> None:
        self._key(letter)
        self._wait_for_verdict("accepted" if letter == "a" else "rejected", key, last=last)

    def _wait_for_next(self, before: str | None) -> JsonObject:
        """Wait until another track is selected and its frame is shown; returns the state."""
        return self._wait(lambda s: s["selected"] not in (None, before) and s["ready"])

    def _wait_for_verdict(self, wanted: str, key: str, *, last: bool) -> None:
        """Wait until a track has its verdict, and the page shows the next one."""
        self._wait(lambda s: s["judged"].get(key) == wanted and (last or (s["selected"] != key and s["ready"])))

    def _add_missed_sign(self, case: Case) -> None:
        """Draw a missed sign in its largest frame, then follow it, or set keyframes if the page cannot follow."""
        largest = case.box_frame
        self._go_to_frame(largest)
        key = self._draw_and_label(case, largest)
        if self._follows:
            self._accept_proposals()
        else:
            for frame in (case.first, case.last):
                if frame != largest:
                    self._go_to_frame(frame)
                    self._key("n")
                    self._page.keyboard.down("Shift")
                    self._drag_between(*_corners(case.truth[frame]))
                    self._page.keyboard.up("Shift")
        self._key("a")
        self._wait(lambda s: s["judged"].get(key) == "accepted")

    def _draw_and_label(self, case: Case, frame: int) -> str:
        """Draw a sign in the shown frame and label it; returns the new track."""
        before = self._state()["selected"]
        self._key("n")
        self._drag_between(*_corners(case.truth[frame]))
        self._label(case)
        return str(self._wait(lambda s: s["selected"] not in (None, before))["selected"])

    def _accept_proposals(self) -> Proposals:
        """Wait for all proposed boxes, and accept them."""
        self._wait(lambda s: s["following"] is True)
        proposed: Proposals = self._page.evaluate(_PROPOSED)
        self._key("Enter")
        self._wait(lambda s: s["following"] is None)
        return proposed

    def _label(self, case: Case, *, accepts: bool = False) -> None:
        """Type the name into the open dialog; ``accepts``: end with the key that also accepts the track."""
        page = self._page
        if case.label < 0:
            page.get_by_role("button", name="Not in the set").click()
            self._record_action("click 'Not in the set'")
        else:
            page.locator("dialog[open] input:focus").wait_for()
            page.keyboard.type(self._names[case.label])
            page.keyboard.press("Control+Enter" if accepts else "Enter")
            self._record_action("type the label and accept" if accepts else "type the label")
        self._wait(lambda s: s["dialog"] is None)

    # --------------------------------------------------------------------------------------------------- actions

    def _go_to_frame(self, frame: int) -> None:
        """Go to a frame with the fewest key presses: steps of one and ten frames, or the frame's number."""
        now = self._state()["frame"]
        tens, ones = steps_of(frame - now)
        if abs(tens) + abs(ones) <= 2:
            for letter, times in (("v" if tens > 0 else "c", abs(tens)), ("f" if ones > 0 else "d", abs(ones))):
                for _ in range(times):
                    self._key(letter)
        else:
            self._key("g")
            self._page.locator(".picture-frame:focus").wait_for()
            self._page.keyboard.press("Control+A")
            self._page.keyboard.type(str(frame))
            self._page.keyboard.press("Enter")
            self._page.locator(".picture").first.focus()
            self._record_action("type the frame")
        self._wait(lambda s: s["frame"] == frame and s["ready"])

    def _key(self, key: str) -> None:
        self._page.keyboard.press(key)
        self._record_action(key)

    def _drag(self, box: FloatArray, target: FloatArray) -> None:
        """Drag the middle of a box onto that of the target."""
        self._drag_between(_middle(box), _middle(target))

    def _trim(self, key: str, last: int) -> None:
        """Drag the end of the track's bar until the picture shows the new last frame."""
        handle = self._page.locator(".lanes-end")
        handle.wait_for()
        box = handle.bounding_box()
        assert box is not None
        at, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        mouse = self._page.mouse
        mouse.move(at, y)
        mouse.down()
        while (frame := self._state()["frame"]) != last:
            at += _DRAG_PX_PER_FRAME * (last - frame)
            mouse.move(at, y)
            self._page.evaluate("() => new Promise((done) => requestAnimationFrame(() => done()))")
        self._wait(lambda s: s["frame"] == last and s["ready"])
        mouse.up()
        self._record_action("drag the end")
        self._wait(lambda s: s["ends"].get(key) == last)

    def _drag_between(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        mouse = self._page.mouse
        mouse.move(*self._screen(*start))
        mouse.down()
        mouse.move(*self._screen(*end), steps=5)
        mouse.up()
        self._record_action("drag")

    def _record_action(self, action: str) -> None:
        self._work.actions.append(action)

    # ---------------------------------------------------------------------------------------------------- the page

    def _finished(self, kind: str, began: float) -> Work:
        self._wait(lambda s: s["unsaved"] == 0)
        self._work.kind, self._work.seconds = kind, time.monotonic() - began
        return self._work

    def _track_number(self, key: str | None) -> int | None:
        return int(key[1:]) if key is not None and key.startswith("m") else None

    def _screen(self, x: float, y: float) -> tuple[float, float]:
        view = self._state()["view"]
        stage = self._page.locator(".picture-stage").bounding_box()
        assert stage is not None
        return (
            stage["x"] + stage["width"] / 2 + (x - view["x"]) * view["zoom"],
            stage["y"] + stage["height"] / 2 + (y - view["y"]) * view["zoom"],
        )

    def _state(self) -> JsonObject:
        found: JsonObject = self._page.evaluate(_STATE)
        return found

    def _wait(self, holds: Callable[[JsonObject], bool]) -> JsonObject:
        end = time.monotonic() + _TIMEOUT_S
        while not holds(now := self._state()):
            if time.monotonic() > end:
                raise RuntimeError(f"The page did not go on after {self._work.actions}: {now}")
            self._page.wait_for_timeout(20)
        return now


def steps_of(way: int) -> tuple[int, int]:
    """Numbers of steps of ten and of one frame that cover a distance with the fewest presses."""
    tens = round(way / 10)
    return tens, way - 10 * tens


def _middle(box: FloatArray) -> tuple[float, float]:
    return (float(box[0]) + float(box[2])) / 2, (float(box[1]) + float(box[3])) / 2


def _corners(box: FloatArray) -> tuple[tuple[float, float], tuple[float, float]]:
    return (float(box[0]), float(box[1])), (float(box[2]), float(box[3]))
