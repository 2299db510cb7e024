"""The moving picture of README: ``python -m tests.e2e.moving_picture --out docs/pictures/review.webp``.

A server tracks the sample drive, and a script works on it in a real browser: the drive plays, the most uncertain track
is explained and accepted, the label of the next one is confirmed in the dialog, and a sign is followed from one box.
Each step waits until the page shows its result, so that no picture is incomplete.
"""

from __future__ import annotations

import argparse
import io
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from sample_videos import SHIPPED
from tests.e2e.chromium import CHROMIUM, ENVIRONMENT
from tests.e2e.live_server import LiveServer
from tests.e2e.review_session import centre, edit_and_save, engine_box, screen_point, state, wait_for, zoom_in
from tests.e2e.scenes import quiet
from tests.e2e.screenshots import FLAGS

SIZE = (1280, 720)
"""Size of the page, px."""
WIDTH = 1024
"""Size of the picture, px."""
QUALITY = 64
MAX_BYTES = 1_500_000
STRIDE = 2
"""Frames of the drive from one picture to the next while it plays."""
PLAYED = range(70, 111, STRIDE)
NOTCHES = 2
"""Of the wheel."""
SHOWN = (31, 7, 20)
"""Labels of the first three tracks of the queue: wild animals, speed limit 100, curve to the right. All are right."""
CONFIRMED = "100"
"""What is typed to find the label of the second one."""
PROPOSED = """() => Object.keys(tsr.store.get().review.following.proposals).map(Number).sort((a, b) => a - b)"""
"""Frames of the proposed boxes."""
QUICK, LETTER, LOOK, READ = 80, 160, 900, 1800
"""Display times of a picture, ms: during playback, while a word is typed, of a step, of something to read."""


class Animation:
    """Pictures of a page, each with its display time."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._pictures: list[Image.Image] = []
        self._times: list[int] = []

    def take(self, stays: int) -> None:
        """Take a picture once the page is quiet."""
        quiet(self._page)
        shot = Image.open(io.BytesIO(self._page.screenshot())).convert("RGB")
        height = round(shot.height * WIDTH / shot.width)
        self._pictures.append(shot.resize((WIDTH, height), Image.Resampling.LANCZOS))
        self._times.append(stays)

    def save(self, path: Path) -> int:
        """Write an animated WebP that repeats forever.

        Returns:
            Its size in bytes.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        first, *others = self._pictures
        first.save(path, save_all=True, append_images=others, duration=self._times, loop=0, quality=QUALITY, method=6)
        return path.stat().st_size


def record(page: Page, facts: dict[str, Any], out: Path) -> int:
    """Walk through the review screen and take the pictures.

    Args:
        page: signed in.
        facts: ids of ``video`` and ``run``.
        out: the file to write.

    Returns:
        Its size in bytes.
    """
    animation = Animation(page)
    page.evaluate(f"location.hash = '#/review/{facts['video']}/{facts['run']}?frame={PLAYED.start}'")
    _settled(page)
    for frame in PLAYED:
        _seek(page, frame)
        animation.take(QUICK)

    _next_in_queue(page)
    _require_label(page, SHOWN[0])
    animation.take(READ)
    _zoom_in(page, animation)
    page.get_by_role("tab", name="Inspector").click()
    animation.take(READ)
    page.get_by_role("tab", name="Queue").click()
    _judge(page, "a")
    animation.take(READ)

    _require_label(page, SHOWN[1])
    page.keyboard.press("l")
    page.locator("dialog[open] input:focus").wait_for()
    for letter in CONFIRMED:
        page.keyboard.type(letter)
        animation.take(LETTER)
    animation.take(LOOK)
    edit_and_save(page, lambda: page.keyboard.press("Enter"))
    _judge(page, "a")
    animation.take(READ)

    _require_label(page, SHOWN[2])
    page.keyboard.press("t")
    page.wait_for_function("() => tsr.store.get().review.following?.state === 'complete'", timeout=120_000)
    for frame in page.evaluate(PROPOSED)[::STRIDE]:
        _seek(page, frame)
        animation.take(QUICK)
    edit_and_save(page, lambda: page.keyboard.press("Enter"))
    _judge(page, "a")
    animation.take(READ)
    return animation.save(out)


def _next_in_queue(page: Page) -> None:
    page.keyboard.press("j")
    _settled(page, lambda s: s["selected"] is not None)


def _require_label(page: Page, label: int) -> None:
    """Stop if the engine gives another label to the selected track: the verdict would be wrong."""
    now = state(page)
    found = now["tracks"]["class_id"][now["tracks"]["id"].index(int(now["selected"].removeprefix("m")))]
    if found != label:
        raise SystemExit(f"The queue has changed: the track has label {found}, not {label}. See SHOWN.")


def _judge(page: Page, key: str) -> None:
    """Press the key of a verdict; the page opens the next undecided track."""
    before = state(page)["selected"]
    edit_and_save(page, lambda: page.keyboard.press(key))
    _settled(page, lambda s: s["selected"] != before)


def _zoom_in(page: Page, animation: Animation) -> None:
    now = state(page)
    page.mouse.move(*screen_point(page, *centre(engine_box(now, now["selected"]))))
    for _ in range(NOTCHES):
        zoom_in(page)
        animation.take(LETTER)
    page.mouse.move(0, 0)
    animation.take(READ)


def _seek(page: Page, frame: int) -> None:
    page.evaluate("(k) => tsr.store.dispatch((s) => ({...s, review: {...s.review, frame: k}}))", frame)
    _settled(page, lambda s: bool(s["frame"] == frame))


def _settled(page: Page, holds: Callable[[dict[str, Any]], bool] = lambda _: True) -> dict[str, Any]:
    return wait_for(page, lambda s: s["tracks"] and s["overlay"] and s["shown"] == s["frame"] and holds(s))


def main(arguments: list[str] | None = None) -> None:
    """Make the picture."""
    parser = argparse.ArgumentParser(prog="python -m tests.e2e.moving_picture", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="the WebP file")
    parser.add_argument("--home", type=Path, help="data folder that is kept, so that the sample drive runs only once")
    chosen = parser.parse_args(arguments)
    if chosen.home is not None:
        chosen.home.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as own, LiveServer(chosen.home or Path(own)) as server, sync_playwright() as playwright:
        video = server.wait_for_run(SHIPPED[0].video.name, timeout=1200)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS, env=ENVIRONMENT)
        page = browser.new_context(viewport={"width": SIZE[0], "height": SIZE[1]}, color_scheme="light").new_page()
        page.goto(server.link())
        size = record(page, {"video": video["id"], "run": video["latest_run"]}, chosen.out)
        browser.close()
    if size > MAX_BYTES:
        raise SystemExit(f"{chosen.out} has {size} bytes, more than {MAX_BYTES}: lower QUALITY, or film less.")
    print(f"{chosen.out}: {size} bytes")


if __name__ == "__main__":
    main()
