"""The loop of docs/tutorial.md on the sample drive: ``python -m tests.e2e.tutorial --out DIR``.

Run, accept, correct, export, retrain, run again, compare, report a bug and replay it. The script takes the tutorial's
pictures, prints the duration of each step, and fails if a step does not lead where the tutorial says.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
import urllib.request
import uuid
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
from playwright.sync_api import Page, sync_playwright

from sample_videos import SHIPPED
from tests.e2e.chromium import CHROMIUM, ENVIRONMENT
from tests.e2e.live_server import LiveServer
from tests.e2e.screenshots import FLAGS

MAX_WAIT_S = 900
SEEN = """() => [...document.images].every((image) => image.complete)
  && (r => !r || r.shown === r.frame && r.lanes !== null)(tsr.store.get().review)"""
"""In the page: whatever has a picture shows it."""


def _wait_until(read: Callable[[], dict[str, Any]], done: tuple[str, ...] = ("complete", "ready")) -> dict[str, Any]:
    end = time.monotonic() + MAX_WAIT_S
    while True:
        now = read()
        if now["state"] in done:
            return now
        if now["state"] in ("failed", "cancelled") or time.monotonic() > end:
            raise SystemExit(f"a step has failed: {now['state']}, {now.get('error')}")
        time.sleep(0.5)


def _edit(server: LiveServer, run: str, command: dict[str, Any], held: dict[str, int]) -> None:
    key = command["key"]
    request = urllib.request.Request(f"{server.base}/api/runs/{run}/edits", method="POST")
    request.add_header("Authorization", "Bearer " + (server.home / "token").read_text().strip())
    request.add_header("Content-Type", "application/json")
    request.add_header("If-Match", f'"{key}:{held.get(key, 0)}"')
    request.data = json.dumps({"op_id": str(uuid.uuid4()), "author": "ann", "command": command}).encode()
    with urllib.request.urlopen(request, timeout=60):
        held[key] = held.get(key, 0) + 1


def _shot(page: Page, out: Path, name: str) -> None:
    page.wait_for_function(SEEN)
    page.wait_for_timeout(1200)
    picture = cv2.imdecode(np.frombuffer(page.screenshot(), np.uint8), cv2.IMREAD_COLOR)
    out.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(out / f"{name}.jpg"), picture, [cv2.IMWRITE_JPEG_QUALITY, 82])


def loop(server: LiveServer, page: Page, out: Path) -> None:
    began = time.monotonic()

    def step(what: str) -> None:
        nonlocal began
        print(f"{time.monotonic() - began:6.1f} s  {what}", flush=True)
        began = time.monotonic()

    video = server.call("POST", "/videos", {"path": str(SHIPPED[0].video)})["id"]
    _wait_until(lambda: server.call("GET", f"/videos/{video}"))
    run = server.call("POST", f"/videos/{video}/runs", {})["id"]
    _wait_until(lambda: server.call("GET", f"/runs/{run}"))
    step("imported and run")
    page.goto(server.link())
    page.evaluate(f"location.hash = '#/review/{video}/-?track=next'")
    page.wait_for_function("() => tsr.store.get().review?.selected != null")
    _shot(page, out, "review")
    columns = server.call("GET", f"/runs/{run}/tracks")
    held: dict[str, int] = {}
    for track, first, last in zip(columns["id"], columns["first"], columns["last"], strict=True):
        span = {"track": track, "first": first, "last": last}
        command = {"name": "set_review", "key": f"m{track}", "review": "accepted", "frame": first, "spans": [span]}
        _edit(server, run, command, held)
    middle = (columns["first"][0] + columns["last"][0]) // 2
    step(f"{len(columns['id'])} tracks accepted")
    page.keyboard.press("Shift+e")
    page.locator("dialog[open] input:checked + *", has_text=SHIPPED[0].video.name).wait_for()
    _shot(page, out, "export")
    page.keyboard.press("Escape")
    order = {"runs": [run], "format": "cvat-video", "states": ["accepted", "rejected"], "name": "corrections"}
    export = server.call("POST", "/exports", order)["id"]
    _wait_until(lambda: server.call("GET", f"/outputs/{export}"))
    step("exported")
    version = server.call("POST", "/models", {"name": "After the first drive", "exports": [export], "seed": 0})["id"]
    made = _wait_until(lambda: next(m for m in server.call("GET", "/models")["models"] if m["id"] == version))
    step(f"retrained: {made['figures']}"[:400])
    page.evaluate("location.hash = '#/models'")
    _shot(page, out, "models")
    server.call("POST", f"/models/{version}/promote")
    again = server.call("POST", f"/videos/{video}/runs", {})["id"]
    done = _wait_until(lambda: server.call("GET", f"/runs/{again}"))
    if done["models"] == server.call("GET", f"/runs/{run}")["models"]:
        raise SystemExit("the second run has not used the new version")
    step("run again with the new version")
    figures = {
        name: server.call("GET", f"/compare?reference=annotation:{run}&candidate=run:{candidate}")
        for name, candidate in (("before", run), ("after", again))
    }
    for name, found in figures.items():
        values = {key: found["figures"][key]["value"] for key in ("precision", "recall", "eq7", "signs_classified")}
        print(f"          {name}: {values}", flush=True)
    page.evaluate(f"location.hash = '#/compare?a=annotation:{run}&b=run:{again}'")
    _shot(page, out, "compare")
    order = {"first": middle, "stop": middle + 30, "note": "An example of a report."}
    bundle = _until_output(server, f"/runs/{run}/bundles", order)
    place = server.home / "report.zip"
    request = urllib.request.Request(f"{server.base}/api/outputs/{bundle}/download")
    request.add_header("Authorization", "Bearer " + (server.home / "token").read_text().strip())
    with urllib.request.urlopen(request, timeout=120) as answer:
        place.write_bytes(answer.read())
    step("bug bundle made")
    replayed = subprocess.run(
        [sys.executable, "-c", "import sys; from app.cli.main import run; sys.exit(run())", "replay", str(place)],
        capture_output=True,
        text=True,
        timeout=MAX_WAIT_S,
    )
    step(f"bundle replayed, exit code {replayed.returncode}: {replayed.stdout.strip().splitlines()[-1:]}")
    if replayed.returncode not in (0, 20, 21):
        raise SystemExit(replayed.stderr)


def _until_output(server: LiveServer, path: str, order: dict[str, Any]) -> str:
    made = server.call("POST", path, order)["id"]
    return str(_wait_until(lambda: server.call("GET", f"/outputs/{made}"))["id"])


def main() -> None:
    """Start a server on an empty data folder and run the loop."""
    parser = argparse.ArgumentParser(prog="python -m tests.e2e.tutorial", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/pictures"))
    args = parser.parse_args()
    with (
        TemporaryDirectory() as folder,
        LiveServer(Path(folder), sample=False) as server,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS, env=ENVIRONMENT)
        page = browser.new_context(viewport={"width": 1280, "height": 720}, color_scheme="light").new_page()
        page.set_default_timeout(60_000)
        loop(server, page, args.out)
        browser.close()


if __name__ == "__main__":
    main()
