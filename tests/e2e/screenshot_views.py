"""Screens drawn by other programs: the recording in the Rerun viewer, and viser's views.

They use WebGL in software and do not signal when they are drawn, so the script waits until they are stable.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import cv2
import numpy as np

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from tests.e2e.live_server import LiveServer

__all__ = ["GRAPHICS", "SHOWN", "record"]

GRAPHICS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
"""Flags of Chromium: WebGL without a graphics card."""
_MAX_WAIT_S = 150.0
"""How long the first picture of a view may take on a slow machine, s."""
_POLL_MS = 1500
"""Time between two looks at it, ms."""


def record(server: LiveServer, run: str, first: int, stop: int, track: str) -> None:
    """Make a recording of some frames for the viewer.

    Raises:
        RuntimeError: it was not ready in time.
    """
    order = {"first": first, "stop": stop, "name": "Around the sign", "frame": (first + stop) // 2, "track": track}
    made = server.call("POST", f"/runs/{run}/recordings", order)
    end = time.monotonic() + _MAX_WAIT_S
    while (state := server.call("GET", f"/outputs/{made['id']}")["state"]) != "complete":
        if state == "failed" or time.monotonic() > end:
            raise RuntimeError(f"The recording was not made: it is {state}.")
        time.sleep(0.3)


def _seen(page: Page, frame: str) -> np.ndarray:
    shot = page.locator(frame).first.screenshot(timeout=60_000)
    picture: np.ndarray | None = cv2.imdecode(np.frombuffer(shot, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return picture


def _drawn(page: Page, frame: str) -> None:
    """Wait until a view shows a stable picture with many colours."""
    end, before = time.monotonic() + _MAX_WAIT_S, None
    while time.monotonic() < end:
        now = _seen(page, frame)
        colours = len(np.unique((now // 16).reshape(-1, 3), axis=0))
        if before is not None and colours > 60 and before.shape == now.shape and cv2.absdiff(before, now).mean() < 0.5:
            return
        before = now
        page.wait_for_timeout(_POLL_MS)
    raise RuntimeError(f"{frame} was not drawn in {_MAX_WAIT_S:.0f} s")


def _recording(page: Page) -> None:
    page.locator("[data-operation=recording-view]").click()
    page.locator(".recording iframe").first.wait_for()
    page.wait_for_function("() => document.querySelector('.recording-veil') === null", timeout=_MAX_WAIT_S * 1000)
    _drawn(page, ".recording iframe")


def _scene3d(name: str) -> Callable[[Page], None]:
    def go(page: Page) -> None:
        page.locator("[data-operation=scene3d-view]").click()
        page.get_by_role("button", name=name).click()
        page.locator(".scene3d-frame").wait_for()
        _drawn(page, ".scene3d-frame")

    return go


SHOWN = {
    "view-recording": _recording,
    "view-volume": _scene3d("Space-time volume"),
    "view-prior": _scene3d("Spatial prior"),
    "view-drive": _scene3d("Metric drive"),
}
"""Name of the picture -> what shows it beside the open review screen."""
