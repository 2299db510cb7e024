"""Pictures of every screen, for people to look at: ``python -m tests.e2e.screenshots --out DIR``.

A server is started on an empty data folder with the sample drives. Each screen is taken at 1280x720, 1440x900 and
3840x2160, light and dark. axe-core (``node_modules``) looks at every screen too; what it finds is printed and is the
exit code.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from playwright.sync_api import Browser, Page, sync_playwright

from sample_videos import SHIPPED
from tests.e2e.chromium import CHROMIUM, ENVIRONMENT
from tests.e2e.live_server import LiveServer
from tests.e2e.scenes import SCENES, VIEWS, Scene
from tests.e2e.screenshot_views import GRAPHICS, record

FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"]
MAX_SCENE_MS = 60_000
"""How long a scene may take on a slow machine, ms."""
AXE_SCRIPT = Path(__file__).resolve().parents[2] / "node_modules" / "axe-core" / "axe.min.js"
SIZES = {"1280x720": (1280, 720), "1440x900": (1440, 900), "3840x2160": (3840, 2160)}


def serious_violations(page: Page, only: Sequence[str] = ()) -> list[str]:
    """What axe-core finds on the page that is serious or worse, one line each.

    The script is evaluated by the test, not loaded by the page, so the page's security policy stays as it is. Below an
    open dialog everything is inert, and scenes of its own: only the dialog is looked at.

    Args:
        only: names of rules; all where it is left out.
    """
    if page.evaluate("() => globalThis.axe === undefined"):
        page.evaluate(AXE_SCRIPT.read_text(encoding="utf-8"))
    options = {"resultTypes": ["violations"]} | ({"runOnly": {"type": "rule", "values": [*only]}} if only else {})
    look = "options => axe.run(document.querySelector('dialog[open]') ?? document, options)"
    found = page.evaluate(look, options)["violations"]
    return [
        f"{one['impact']}: {one['id']}: {one['help']}: {', '.join(str(node['target'][0]) for node in one['nodes'][:5])}"
        for one in found
        if one["impact"] in ("serious", "critical")
    ]


def _facts(server: LiveServer) -> dict[str, Any]:
    """Wait for the first sample's run and import its truth."""
    video = server.wait_for_run(SHIPPED[0].video.name, timeout=1200)
    truth = server.call("GET", f"/videos/{video['id']}/ground-truths")["ground_truths"][0]
    tracks = server.call("GET", f"/runs/{video['latest_run']}/tracks")
    at = max(range(len(tracks["id"])), key=lambda i: tracks["frames"][i])
    made_before = {output["name"] for output in server.call("GET", "/outputs")["outputs"]}
    for name, format_ in (("corrections", "cvat-video"), ("crops", "gtsrb")):
        if f"{name}.zip" in made_before:
            continue
        pictures = "annotated" if format_ == "gtsrb" else "none"
        wanted = {"runs": [video["latest_run"]], "format": format_, "pictures": pictures, "name": name}
        made = server.call("POST", "/exports", wanted)
        end = time.monotonic() + 120
        while server.call("GET", f"/outputs/{made['id']}")["state"] in ("queued", "running"):
            if time.monotonic() > end:
                raise RuntimeError(f"The export {name} was not made in two minutes.")
            time.sleep(0.3)
    return {
        "video": video["id"],
        "run": video["latest_run"],
        "truth": truth["id"],
        "track": f"m{tracks['id'][at]}",
        "frame": (tracks["first"][at] + tracks["last"][at]) // 2,
        "frames": video["frames"],
    }


def _shoot(page: Page, facts: dict[str, Any], scenes: Sequence[Scene], kind: str, out: Path) -> Iterator[str]:
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(f"error in the page: {error}"))
    for scene in scenes:
        scene.go(page, facts)
        page.screenshot(path=out / f"{scene.name}-{kind}.png")
        problems += serious_violations(page) if AXE_SCRIPT.is_file() else []
        yield from (f"{scene.name}, {kind}: {problem}" for problem in problems)
        problems.clear()


def _page(browser: Browser, server: LiveServer, size: str, theme: str) -> Page:
    width, height = SIZES[size]
    context = browser.new_context(
        viewport={"width": width, "height": height}, color_scheme="dark" if theme == "dark" else "light"
    )
    page = context.new_page()
    page.set_default_timeout(MAX_SCENE_MS)
    page.goto(server.link())
    page.wait_for_function("() => globalThis.tsr?.store.get().videos !== null && tsr.store.get().session !== null")
    return page


def main(arguments: list[str] | None = None) -> int:
    """Take the pictures; 1 if axe-core or the page's console had something serious to say."""
    parser = argparse.ArgumentParser(prog="python -m tests.e2e.screenshots", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    parser.add_argument("--size", choices=sorted(SIZES), action="append", help="only this size; repeatable")
    parser.add_argument("--theme", choices=["light", "dark"], action="append", help="only this theme; repeatable")
    parser.add_argument("--home", type=Path, help="data folder that is kept, so that the sample drives run only once")
    names = [scene.name for scene in (*SCENES, *VIEWS)]
    parser.add_argument("--scene", choices=names, action="append", help="only this scene; repeatable")
    chosen = parser.parse_args(arguments)
    for folder in (chosen.out, chosen.home):
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
    problems: list[str] = []
    with TemporaryDirectory() as own, LiveServer(chosen.home or Path(own)) as server, sync_playwright() as playwright:
        facts = _facts(server)
        kinds = [(size, theme) for size in chosen.size or SIZES for theme in chosen.theme or ("light", "dark")]
        for all_scenes, flags in ((SCENES, FLAGS), (VIEWS, [*FLAGS, *GRAPHICS])):
            scenes = [scene for scene in all_scenes if chosen.scene is None or scene.name in chosen.scene]
            if scenes and all_scenes is VIEWS:  # only now, for one of the scenes is that there is no recording
                first = max(0, facts["frame"] - 40)  # the frame that the pictures are of lies in it
                record(server, facts["run"], first, min(first + 80, facts["frames"]), facts["track"])
            browser = playwright.chromium.launch(executable_path=CHROMIUM, args=flags, env=ENVIRONMENT)
            for size, theme in kinds:
                page = _page(browser, server, size, theme)
                problems += _shoot(page, facts, scenes, f"{size}-{theme}", chosen.out)
                page.context.close()
            browser.close()
    for problem in dict.fromkeys(problems):
        print(problem, file=sys.stderr)
    print(f"{len(list(chosen.out.glob('*.png')))} pictures in {chosen.out}")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
