"""Measures the frame rate of the space-time volume in headless Chromium with software rendering, while it is turned.

::

    python benchmarks/timing/scene3d.py                  # 500 tracks of 25 boxes
    python benchmarks/timing/scene3d.py --as-viser # viser's original page: four samples per pixel, every picture copied

On a busy machine, use the processor time per picture, not the rate.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import time
from pathlib import Path

import numpy as np
import viser
from playwright.sync_api import Page, sync_playwright

from app.scene3d.data import DetectionPoints, Scene3dData, Sign
from app.scene3d.page import PLAIN
from app.scene3d.scenes.base import SceneContext
from app.scene3d.scenes.volume import VolumeScene
from app.scene3d.view import configure_server, place_viewers
from app.scene3d.view_state import ViewState
from benchmarks.timing.processes import child_processes, processor_seconds
from tsr_engine.json_shapes import JsonObject

GL = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
_COUNT = """(() => {
  window.drawn = 0;
  window.pictures = 0;
  for (const name of ['drawElements', 'drawArrays', 'drawElementsInstanced', 'drawArraysInstanced']) {
    const given = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...rest) { window.drawn += 1; return given.apply(this, rest); };
  }
  let before = 0;
  const tick = () => {
    if (window.drawn !== before) [window.pictures, before] = [window.pictures + 1, window.drawn];
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
})()"""


def main() -> None:
    """Print one JSON line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--tracks", type=int, default=500)
    parser.add_argument("--seconds", type=float, default=15.0, help="time to turn the scene")
    parser.add_argument("--as-viser", action="store_true", help="without our script for software rendering")
    parser.add_argument("--chromium", type=Path, default=Path(shutil.which("chromium") or "/usr/bin/chromium"))
    args = parser.parse_args()
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        configure_server(server)
        add_scene(server, args.tracks)
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=args.chromium, args=list(GL))
            page = browser.new_page(viewport={"width": 1000, "height": 640})
            if not args.as_viser:
                page.add_init_script(PLAIN)
            page.add_init_script(_COUNT)
            page.goto(f"http://127.0.0.1:{server.get_port()}")
            page.wait_for_function("() => window.drawn > 0", timeout=120_000)
            page.wait_for_timeout(5000)
            print(json.dumps({"tracks": args.tracks, **turn(page, args.seconds)}))
            browser.close()
    finally:
        server.stop()


def add_scene(server: viser.ViserServer, tracks: int) -> None:
    """Add the whole scene: lines, blocks near the cursor, a selected track, a picture."""
    length, rng = 25, np.random.default_rng(tracks)
    frame = (np.arange(tracks)[:, None] * 10 + np.arange(length)).ravel()
    track = np.repeat(np.arange(tracks), length)
    side = np.tile(np.linspace(12, 60, length), tracks)
    # Signs move outwards as a car approaches, with the jitter of a tracker.
    along = np.tile(np.linspace(0.0, 1.0, length) ** 2, tracks)
    centre = rng.uniform([300, 150], [1000, 500], (tracks, 2))[track] + along[:, None] * (150, -60)
    centre += rng.normal(0.0, 0.25, centre.shape)
    frames = np.arange(int(frame.max()) + 1)
    data = Scene3dData(
        run_id="run",
        video_id="video",
        width=1280,
        height=720,
        frames=frames,
        times=frames / 25.0,
        ids=np.arange(tracks),
        class_id=rng.integers(0, 43, tracks),
        flagged=rng.random(tracks) < 0.01,
        frame=frame,
        track=track,
        boxes=np.concatenate([centre - side[:, None] / 2, centre + side[:, None] / 2], axis=1),
        source=np.zeros(len(frame), np.int64),
        verdict=rng.integers(0, 3, len(frame)),
        signs={number: Sign(f"sign {number}", pictogram=f"gtsrb/{number}") for number in range(43)},
    )
    hits = DetectionPoints(np.zeros((0, 2)), np.zeros(0), np.zeros(0, np.bool_), 0)
    scene = VolumeScene(
        SceneContext(server.scene, data, lambda: hits, lambda: None, lambda _: np.zeros((8, 8, 4), np.uint8))
    )
    look = scene.draw(ViewState(frame=int(frames[-1]) // 2, track=f"m{tracks // 2}"), None)
    scene.show(rng.integers(0, 255, (540, 960, 3)).astype(np.uint8))
    place_viewers(server, look)
    server.flush()


def turn(page: Page, seconds: float) -> JsonObject:
    """Drag the scene back and forth; returns pictures, draw calls per picture, and the browser's processor time."""
    load = os.getloadavg()[0]
    page.mouse.move(300, 300)
    page.mouse.down()
    before, worked, began, step = (
        page.evaluate("[window.pictures, window.drawn]"),
        _children_seconds(),
        time.monotonic(),
        0,
    )
    while time.monotonic() - began < seconds:
        step += 1
        page.mouse.move(300 + abs(step % 80 - 40) * 4, 300)
        page.wait_for_timeout(30)
    took, worked = time.monotonic() - began, _children_seconds() - worked
    after = page.evaluate("[window.pictures, window.drawn]")
    page.mouse.up()
    pictures = max(1, after[0] - before[0])
    return {
        "pictures_per_second": round(pictures / took, 2),
        "cpu_seconds_per_picture": round(worked / pictures, 3),
        "cores_that_were_left": round(worked / took, 2),
        "draw_calls_per_picture": round((after[1] - before[1]) / pictures, 1),
        "canvas": page.evaluate(
            "(() => { const c = [...document.querySelectorAll('canvas')].pop(); "
            "return [c.width, c.height, c.getContext('webgl2').getContextAttributes().antialias]; })()"
        ),
        "load": round(load, 1),
    }


def _children_seconds() -> float:
    """Processor time of all child processes, s."""
    total = 0.0
    for pid in child_processes(os.getpid()):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            total += processor_seconds(pid)
    return total


if __name__ == "__main__":
    main()
