"""Measures the time from a new data folder to the first correction, as on the first start of the tool."""

from __future__ import annotations

import time
from pathlib import Path

from benchmarks.review.browser_session import open_browser_session
from benchmarks.timing.processes import child_processes, resident_mb
from sample_videos import SHIPPED
from tsr_engine.json_shapes import JsonObject

_CHOOSE = """() => {
  const { id, first } = tsr.store.get().review.tracks;
  location.hash = `${location.hash.split('?')[0]}?frame=${first[0]}&track=m${id[0]}`;
}"""
_STORED = """() => {
  const { docs, selected, unsaved } = tsr.store.get().review;
  return docs[selected]?.review === 'accepted' && !unsaved.length;
}"""


def first_correction(home: Path) -> JsonObject:
    """Start the tool, open the sample drive while the engine runs on it, accept its first track.

    Returns:
        Seconds from the start of the command to each step, ``corrected`` for the stored correction; ``server_mb``:
        memory of the idle server afterwards; ``workers_mb``: memory of each of its worker processes.
    """
    began = time.monotonic()
    steps: JsonObject = {}
    with open_browser_session(home, (SHIPPED[0].video.parent,), sample=True) as session:
        page = session.page()
        page.get_by_role("heading", name="Start with the sample drive").wait_for()
        steps["library"] = time.monotonic() - began
        page.get_by_role("link", name="Review the sample drive").click(timeout=600_000)
        page.wait_for_function("() => tsr.store.get().review?.tracks?.id.length > 0", timeout=600_000)
        steps["first_track"] = time.monotonic() - began
        page.evaluate(_CHOOSE)
        page.wait_for_function("() => tsr.store.get().review.selected")
        page.locator("[data-operation=accept]").click()
        page.wait_for_function(_STORED)
        steps["corrected"] = time.monotonic() - began
        session.server.wait_for_run(SHIPPED[0].video.name, timeout=600)
        steps["run_complete"] = time.monotonic() - began
        page.context.close()
        time.sleep(5)
        steps["server_mb"] = resident_mb([session.server.pid])
        steps["workers_mb"] = [round(resident_mb([pid])) for pid in child_processes(session.server.pid)]
    return steps
