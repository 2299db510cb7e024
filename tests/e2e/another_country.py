"""The steps of docs/another-country.md: ``python -m tests.e2e.another_country --out docs/pictures``.

A CVAT file with names of another country is imported onto a sample drive, corrected and exported. The script takes the
page's pictures, and fails if a step does not lead where the page says.
"""

from __future__ import annotations

import argparse
import io
import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree as ET

import cv2
import numpy as np
from playwright.sync_api import Page, expect, sync_playwright

from sample_videos import SHIPPED
from tests.e2e.chromium import CHROMIUM, ENVIRONMENT
from tests.e2e.foreign_labels import SLOVENIAN, cvat_file
from tests.e2e.live_server import LiveServer
from tests.e2e.scenes import quiet
from tests.e2e.screenshots import FLAGS

MAX_STEP_MS = 90_000
"""How long a step may take on a slow machine, ms."""
ANSWERS = {"otroci": "children", "omejitev_30": "speed limit 30 km/h", "omejitev_50": "speed limit 50 km/h"}
"""A person's choices for the names without a label."""
EXAMPLES = """() => [...document.querySelectorAll('.mapping-example')].every((one) =>
  one.hidden || one.getContext('2d').getImageData(one.width / 2, one.height / 2, 1, 1).data[3] > 0)"""
"""In the page: each name has the picture of its example."""


def _shot(page: Page, out: Path, name: str) -> None:
    quiet(page)
    picture = cv2.imdecode(np.frombuffer(page.screenshot(), np.uint8), cv2.IMREAD_COLOR)
    out.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(out / f"{name}.webp"), picture, [cv2.IMWRITE_WEBP_QUALITY, 80])
    print(f"{name}.webp")


def walk(server: LiveServer, page: Page, out: Path) -> None:
    """Walk the page's steps."""
    video = server.add_video(SHIPPED[1].video)
    content = cvat_file(SHIPPED[1].truth, SLOVENIAN, video["frames"], (video["width"], video["height"]))
    page.goto(server.link())
    # 1. the labels of the country
    page.get_by_role("link", name="Labels").click()
    page.locator(".label-rows .label-row").first.wait_for()
    page.get_by_role("button", name="Files").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("button", name="Add what is missing").click()
    dialog.get_by_text("Added").wait_for()
    page.keyboard.press("Escape")
    page.get_by_label("Search labels").fill("crossing")
    page.locator(".label-rows .label-row", has_text="pedestrian crossing").first.click()
    _shot(page, out, "labels-page")
    # 2. the file of the other tool
    page.evaluate(f"location.hash = '#/review/{video['id']}/-'")
    page.wait_for_function("() => tsr.store.get().review?.timebase")
    page.get_by_role("button", name="Import annotations").click()
    page.locator("[name=import-as][value=run]").check()
    chosen = {"name": "slovenia.xml", "mimeType": "text/xml", "buffer": content}
    page.locator("#import-file").set_input_files(chosen)  # type: ignore[arg-type]
    dialog.get_by_role("button", name="Import", exact=True).click()
    dialog.locator(".mapping").wait_for(timeout=MAX_STEP_MS)
    for name, label in ANSWERS.items():
        dialog.get_by_label(f"How to import {name}").select_option("label")
        dialog.get_by_label(f"Label of {name}").fill(label)
    page.wait_for_function(EXAMPLES)
    _shot(page, out, "country-mapping")
    dialog.get_by_role("button", name="Import", exact=True).click()
    dialog.get_by_role("button", name="Show the run").click(timeout=MAX_STEP_MS)
    # 3. corrections
    page.wait_for_function("() => tsr.store.get().review?.tracks && tsr.store.get().review.run")
    page.keyboard.press("j")
    page.wait_for_function("() => (r => r.selected && r.shown === r.frame)(tsr.store.get().review)")
    page.keyboard.press("l")
    page.locator("dialog[open] input:focus").wait_for()
    page.keyboard.type("crossing")
    _shot(page, out, "country-relabel")
    page.keyboard.press("Escape")
    for _ in SLOVENIAN:
        page.keyboard.press("a")
        page.wait_for_timeout(300)
    page.wait_for_function("() => tsr.store.get().review.unsaved.length === 0")
    # 4. the export
    page.keyboard.press("Shift+e")
    dialog.get_by_label("Format", exact=True).select_option("cvat-video")
    expect(dialog.locator(".export-count")).to_contain_text(f"{len(SLOVENIAN)} tracks", timeout=MAX_STEP_MS)
    dialog.get_by_label("Labels that the files declare").select_option("used")
    dialog.locator("summary", has_text="Class map").click()
    _shot(page, out, "country-export")
    dialog.get_by_role("button", name="Export", exact=True).click()
    with page.expect_download(timeout=MAX_STEP_MS) as download:
        dialog.get_by_role("link", name="Download").click(timeout=MAX_STEP_MS)
    with zipfile.ZipFile(io.BytesIO(Path(download.value.path()).read_bytes())) as archive:
        root = ET.fromstring(archive.read(next(name for name in archive.namelist() if name.endswith(".xml"))))
    names = sorted({track.get("label", "") for track in root.findall("track")})
    print("exported:", ", ".join(names))
    if not {*ANSWERS.values(), "give way", "pedestrian crossing"} <= set(names):
        raise SystemExit("A label of the file is not in the export.")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the walk; the exit code is 0 if every step succeeded."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, required=True, help="folder of the pictures")
    out = parser.parse_args(argv).out
    with TemporaryDirectory() as home, LiveServer(Path(home), sample=False) as server, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS, env=ENVIRONMENT)
        page = browser.new_context(viewport={"width": 1280, "height": 720}, accept_downloads=True).new_page()
        page.set_default_timeout(MAX_STEP_MS)
        walk(server, page, out)
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
